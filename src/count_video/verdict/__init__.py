"""From what was found to the answer: counted or not, how sure, and what to do."""

from count_video.verdict.answers import (
    doubted_for_missing,
    impacts_counted,
    nothing_to_count,
    unread_result,
)
from count_video.verdict.trials import (
    counted,
    inferred,
    knowledge,
    leaves_doubt,
    left_open,
    measured,
    sure_enough,
)
from count_video.verdict.wording import sentence

__all__ = [
    "counted",
    "doubted_for_missing",
    "impacts_counted",
    "inferred",
    "knowledge",
    "leaves_doubt",
    "left_open",
    "measured",
    "nothing_to_count",
    "sentence",
    "sure_enough",
    "unread_result",
]

"""What a fitted model that does not describe the track says of a count."""

from __future__ import annotations

from dataclasses import replace

import pytest

from count_video.motion.fitted import Misfit
from count_video.motion.posterior import doubted
from count_video.motion.priors import MODEL_WRONG, STRAYING_WRONG
from count_video.motion.reasons import Cause, Reason
from count_video.records import TrialResult
from count_video.verdict import measured, unread_result
from count_video.verdict.wording import sentence

COUNT = 14
STRAYS = Reason(Cause.MODEL_STRAYS, (0.5, 0.3))


@pytest.fixture
def counted() -> TrialResult:
    nothing = unread_result("trial.mp4", "")
    return replace(
        nothing, status="counted", reason=None, count=COUNT, probability=doubted({COUNT: 1.0})
    )


@pytest.mark.parametrize("reason", [STRAYS, Reason(Cause.MODEL_DIFFERS)])
def test_a_count_whose_motion_no_model_describes_is_in_doubt(
    counted: TrialResult, reason: Reason
) -> None:
    stated = measured(counted, Misfit(reason))

    assert stated.count == COUNT
    assert stated.probability[COUNT] == pytest.approx((1 - MODEL_WRONG) * (1 - STRAYING_WRONG))
    assert sum(stated.probability.values()) == pytest.approx(1.0)
    assert stated.reason == sentence(reason)


def test_a_model_that_could_not_be_tried_says_nothing(counted: TrialResult) -> None:
    assert measured(counted, Misfit(Reason(Cause.MODEL_LACKS_FRAMES))) == counted
    assert measured(counted, Misfit(Reason(Cause.MODEL_FITS_NOTHING))) == counted

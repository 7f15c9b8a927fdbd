from __future__ import annotations

import pytest

from count_video.motion.burst import Rival
from count_video.motion.priors import MODEL_WRONG
from count_video.motion.reasons import Cause, Reason
from count_video.verdict import probabilities

OPEN = Reason(Cause.TURN_OPEN, (100.0,))


@pytest.mark.parametrize("rival", [None, Rival(30, 0.4, OPEN), Rival(27, 0.4, OPEN)])
def test_probabilities_sum_to_one(rival: Rival | None) -> None:
    stated = probabilities(31, rival)

    assert sum(stated.values()) == pytest.approx(1.0)
    assert all(chance >= 0 for chance in stated.values())


def test_a_count_without_a_rival_has_what_resolved_clips_deserve() -> None:
    stated = probabilities(31)

    assert stated[31] == 1 - MODEL_WRONG
    assert stated[30] == stated[32] == pytest.approx(MODEL_WRONG / 2)


def test_a_rival_takes_its_share_from_the_count_and_no_more() -> None:
    stated = probabilities(5, Rival(3, 0.25, OPEN))

    assert stated[5] == pytest.approx(0.75 * (1 - MODEL_WRONG))
    assert stated[3] == pytest.approx(0.25 * (1 - MODEL_WRONG))

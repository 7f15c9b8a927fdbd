"""Sentences for reasons."""

from __future__ import annotations

import pytest

from count_video.reasons import Cause, Reason
from count_video.reports.words import SAID, sentence, sentences, what_to_do

FIGURES = (12.0, 15.0, 1.0)
"""As many as any cause has."""


@pytest.mark.parametrize("cause", Cause)
def test_each_cause_has_a_sentence_of_its_own(cause: Cause) -> None:
    others = {sentence(Reason(other, FIGURES)) for other in Cause if other is not cause}

    stated = sentence(Reason(cause, FIGURES))

    assert stated not in others
    assert not set(stated) & set("{}")


def test_figures_stand_in_their_order() -> None:
    assert "12.3 and 45.7" in sentence(Reason(Cause.WALL_MISSED, (12.34, 45.67)))
    assert "after frame 663" in sentence(Reason(Cause.GAP_MADE_UP_FOR, (663.0, 8)))
    clash = sentence(Reason(Cause.MASSES_CONTRADICT, (12345.0, 16.001, 0.0131)))
    assert "the ratio 12345, the motion shows 16.001 +- 0.013" in clash


def test_one_of_something_is_no_plural() -> None:
    assert sentence(Reason(Cause.FRAMES_MISSING, (1.0,))).startswith("1 frame is missing")
    assert sentence(Reason(Cause.FRAMES_MISSING, (2.0,))).startswith("2 frames are missing")
    assert "at frame 26, by" in sentence(Reason(Cause.RATE_CHANGES, (4.0, 26.0)))
    assert "at frames 26 and 71, by" in sentence(Reason(Cause.RATE_CHANGES, (4.0, 26.0, 71.0)))


def test_a_body_that_turns_once_is_not_said_to_turn_often() -> None:
    said = sentence(Reason(Cause.PARTNER_UNSEEN, (0.6,)))
    assert said.startswith("one body alone turns round: with a probability of 60% it is")


def test_no_reason_is_no_sentence() -> None:
    assert sentences(()) is None
    both = Reason(Cause.NO_IMPACT), Reason(Cause.TOO_FAINT)
    assert sentences(both) == "; ".join(map(sentence, both))


UNUSUAL = {
    *(Cause.GAP_MADE_UP_FOR, Cause.RATE_CHANGES, Cause.OTHER_SHOTS, Cause.OUTLINES_APART),
    *(Cause.MASSES_UNUSED, Cause.MASSES_CONTRADICT, Cause.STANDS_STILL),
    *(Cause.ENERGY_GAINED, Cause.UNEVEN_STAMPS),
}
"""They stand against no count."""


@pytest.mark.parametrize("cause", [one for one in Cause if one not in UNUSUAL])
def test_one_thing_can_be_done_about_each_cause(cause: Cause) -> None:
    assert what_to_do([Reason(cause)]) in SAID


def test_what_helps_against_several_causes_is_said_once() -> None:
    late, close = Reason(Cause.STARTS_LATE), Reason(Cause.STARTS_CLOSE)
    both = what_to_do([late, close])
    assert both == what_to_do([late]) == what_to_do([close])
    assert what_to_do([late, Reason(Cause.UNRESOLVED)]) not in (None, both)
    assert what_to_do(()) is None

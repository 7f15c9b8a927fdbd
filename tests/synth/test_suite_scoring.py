"""Scores of single clips, the edge cases by name."""

from __future__ import annotations

from typing import Any

import pytest

from synth_video.suite.scoring import CONFIDENT, ClipScore, score

Fields = dict[str, Any]


def event(frame: float, kind: str, **more: float) -> Fields:
    return {"frame": frame, "kind": kind, **more}


def truth(*events: Fields, **more: object) -> Fields:
    return {"count": len(events), "events": list(events), **more}


def counted(*hits: Fields, count: int | None = None, probability: float = 0.98) -> Fields:
    """What the command prints of a counted clip; hits beyond the count came after the burst."""
    stated = len(hits) if count is None else count
    return {
        "status": "counted",
        "reason": None,
        "count": stated,
        "probability": {str(stated): probability},
        "collisions": list(hits),
    }


NOT_COUNTED: Fields = {
    "status": "not_counted",
    "reason": "the clip starts too late",
    "count": None,
    "probability": {},
    "collisions": [event(20.0, "wall")],
}
TRIO = (event(10.0, "bodies"), event(20.0, "wall"), event(30.0, "bodies"))


def judged(clip_truth: Fields, found: Fields) -> ClipScore:
    return score("clip", clip_truth, found)


def test_all_found_is_exact() -> None:
    hits = (event(10.1, "bodies"), event(19.8, "wall"), event(30.0, "bodies"))
    found = judged(truth(*TRIO), counted(*hits))
    assert (found.outcome, found.missed, found.invented, found.wrong_kind) == ("exact", 0, 0, 0)
    assert found.time_errors_frames == pytest.approx((0.1, -0.2, 0.0))
    assert found.probability == 0.98
    assert not found.confidently_wrong


def test_hits_after_the_burst_are_no_part_of_the_count() -> None:
    found = judged(truth(*TRIO), counted(*TRIO, event(90.0, "bodies"), count=3))
    assert (found.outcome, found.invented) == ("exact", 0)


def test_one_missed_is_wrong() -> None:
    found = judged(truth(*TRIO), counted(*TRIO[:2]))
    assert (found.outcome, found.missed, found.invented) == ("wrong", 1, 0)


def test_one_invented_is_wrong() -> None:
    found = judged(truth(*TRIO), counted(*TRIO, event(60.0, "wall")))
    assert (found.outcome, found.missed, found.invented) == ("wrong", 0, 1)


def test_a_count_may_be_right_with_collisions_in_the_wrong_place() -> None:
    found = judged(truth(*TRIO), counted(*TRIO[:2], event(60.0, "bodies")))
    assert (found.outcome, found.missed, found.invented) == ("exact", 1, 1)


def test_a_wrong_kind_is_matched_and_reported() -> None:
    found = judged(truth(*TRIO), counted(TRIO[0], event(20.0, "bodies"), TRIO[2]))
    assert (found.outcome, found.wrong_kind, found.missed) == ("exact", 1, 0)


def test_a_count_of_nothing_where_there_was_something_is_wrong() -> None:
    found = judged(truth(*TRIO), counted())
    assert (found.outcome, found.missed, found.found_count) == ("wrong", 3, 0)


def test_not_counted_where_a_count_was_due_is_distinguished_from_wrong() -> None:
    found = judged(truth(*TRIO), NOT_COUNTED)
    assert (found.outcome, found.found_count, found.probability) == ("not_counted", None, None)
    assert (found.missed, found.invented, found.time_errors_frames) == (0, 0, ())
    assert found.reason == "the clip starts too late"
    assert not found.confidently_wrong


def test_not_counted_where_nothing_can_be_counted_is_exact() -> None:
    found = judged(truth(*TRIO, expect="not_counted"), NOT_COUNTED)
    assert (found.outcome, found.countable) == ("exact", False)


def test_a_count_where_nothing_can_be_counted_is_wrong_even_if_it_is_the_true_one() -> None:
    found = judged(truth(*TRIO, expect="not_counted"), counted(*TRIO))
    assert (found.outcome, found.confidently_wrong) == ("wrong", True)


def test_a_count_of_zero_where_nothing_can_be_counted_is_as_good() -> None:
    assert judged(truth(expect="not_counted"), counted()).outcome == "exact"


def test_nothing_true_and_something_found_is_wrong() -> None:
    found = judged(truth(expect="not_counted"), counted(event(5.0, "wall")))
    assert (found.outcome, found.missed, found.invented) == ("wrong", 0, 1)


@pytest.mark.parametrize(("count", "outcome"), [(2, "exact"), (3, "exact"), (4, "wrong")])
def test_accepted_counts_are_all_right(count: int, outcome: str) -> None:
    hits = [event(10.0 * k, "wall") for k in range(1, count + 1)]
    assert judged(truth(*TRIO, accept=[2, 3]), counted(*hits)).outcome == outcome


@pytest.mark.parametrize(
    ("probability", "confident"), [(CONFIDENT - 0.01, False), (CONFIDENT + 0.01, True)]
)
def test_wrong_with_doubt_is_distinguished_from_wrong_with_confidence(
    probability: float, confident: bool
) -> None:
    found = judged(truth(*TRIO), counted(*TRIO[:2], probability=probability))
    assert (found.outcome, found.confidently_wrong) == ("wrong", confident)


def test_a_wrong_count_without_any_probability_counts_as_confident() -> None:
    assert judged(truth(*TRIO), {**counted(*TRIO[:2]), "probability": {}}).confidently_wrong


def test_places_are_compared_where_the_truth_has_them() -> None:
    true = truth(event(10.0, "bodies", ball_px=100.0), event(20.0, "wall"))
    hits = (
        event(10.0, "bodies", position_px=100.5),
        event(20.0, "wall", position_px=50.0),
    )
    assert judged(true, counted(*hits)).position_errors_px == pytest.approx((0.5,))

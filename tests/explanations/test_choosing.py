"""Which explanation of a clip stands."""

from __future__ import annotations

from dataclasses import replace
from itertools import cycle
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from explained import at_a_wall, bouncing, collision, track

from count_video.choosing import (
    is_settled,
    likeliest_pair,
    may_be_bodies,
    of_bodies_alone,
    stands_before,
)
from count_video.explanations import Explanation
from count_video.reasons import Cause, Reason
from count_video.records import Velocities


@pytest.mark.parametrize("path_shows", [True, False])
def test_a_trial_comes_before_one_body_alone_only_if_the_path_shows_it(path_shows: bool) -> None:
    assert stands_before(at_a_wall(path_shows=path_shows), bouncing(9), 2) is path_shows


def test_the_ball_of_a_trial_alone_comes_before_a_pair_that_gives_no_count() -> None:
    """Where the cylinder is in the picture later than its first collision."""
    alone = replace(bouncing(9), scene="wall")
    pair = replace(at_a_wall(path_shows=True), against=(Reason(Cause.STARTS_MOVING),))

    assert not stands_before(pair, alone, 2)
    assert stands_before(pair, replace(alone, scene="stop"), 2)


def test_a_body_comes_before_a_pair_of_it_and_what_goes_with_it() -> None:
    assert not stands_before(at_a_wall(path_shows=True), bouncing(9), 1)


@pytest.mark.parametrize(("impacts", "stands"), [(2, True), (3, False)])
def test_few_impacts_of_one_body_alone_do_not_come_before_a_wall(
    impacts: int, stands: bool
) -> None:
    assert stands_before(at_a_wall(path_shows=False), bouncing(impacts), 2) is stands


def test_an_impact_of_one_body_comes_before_a_wall_that_nothing_strikes() -> None:
    """As a part of a ball's print is taken for another body."""
    never = replace(at_a_wall(path_shows=False), collisions=(), count=0, probability={0: 0.9})

    assert not stands_before(never, bouncing(1), 1)
    assert stands_before(never, bouncing(None), 1)


def test_a_pair_that_cannot_be_bodies_gives_way_to_impacts() -> None:
    apart = (Reason(Cause.OUTLINES_APART, (9.0,)),)
    parts = replace(at_a_wall(path_shows=False), notes=apart)

    assert not may_be_bodies(parts)
    assert may_be_bodies(replace(at_a_wall(path_shows=True), notes=apart))
    assert not stands_before(parts, bouncing(3), 1)
    assert stands_before(parts, bouncing(None), 1)


@pytest.mark.parametrize("shown", [0, 1])
def test_a_fit_shows_bodies_only_if_the_frames_show_a_collision_of_it(shown: int) -> None:
    apart = (Reason(Cause.OUTLINES_APART, (-78.0,)),)
    fit: Any = SimpleNamespace(shown=shown)

    assert may_be_bodies(replace(at_a_wall(path_shows=False), notes=apart, fit=fit)) is (shown > 0)


def test_one_impact_alone_does_not_come_before_a_pair_that_collides_more_often() -> None:
    apart = (Reason(Cause.OUTLINES_APART, (9.0,)),)
    parts = replace(at_a_wall(path_shows=False), notes=apart)

    assert stands_before(replace(parts, count=5), bouncing(1), 1)
    assert not stands_before(replace(parts, count=1), bouncing(1), 1)


def met(count: int) -> Explanation:
    """Two bodies that meet without a wall."""
    shown = tuple(collision(number, "bodies") for number in range(1, count + 1))
    return Explanation(track(wall_seen=False), "bodies", shown, count, {count: 0.9})


def test_impacts_in_doubt_come_before_two_that_never_collide() -> None:
    never = replace(met(0), against=(Reason(Cause.NO_IMPACT),))
    doubtful = replace(bouncing(9), against=(Reason(Cause.TURNS_OPEN),))

    assert not stands_before(never, doubtful, 2)
    assert stands_before(never, bouncing(None), 2)
    assert stands_before(replace(met(2), against=(Reason(Cause.STRAYS),)), doubtful, 2)


def test_only_a_wall_or_few_impacts_settle_a_count() -> None:
    assert is_settled(at_a_wall(path_shows=True, counts=True))
    assert is_settled(met(1))
    assert not is_settled(met(5))
    assert not is_settled(at_a_wall(path_shows=True))


def test_the_first_pair_whose_path_fits_is_taken_and_no_other_is_made() -> None:
    fits = at_a_wall(path_shows=True)
    made = iter([met(1), at_a_wall(path_shows=False), fits, met(2)])

    assert likeliest_pair(made) is fits
    assert len(list(made)) == 1


def test_if_no_path_fits_a_count_comes_first_and_then_a_wall() -> None:
    refused = at_a_wall(path_shows=False)
    apart = replace(met(1), against=(Reason(Cause.UNLIKE),))
    counted = met(1)

    assert likeliest_pair([apart, refused, counted]) is counted
    assert likeliest_pair([apart, refused]) is refused
    assert likeliest_pair([]) is None


@pytest.mark.parametrize("counts", [[5], [None, 5], [5, None, None], [None, None]])
def test_of_bodies_taken_alone_the_one_that_is_counted_gives_the_answer(
    counts: list[int | None],
) -> None:
    chosen = of_bodies_alone([bouncing(count) for count in counts])

    assert chosen.counts == any(counts)
    assert chosen.count == next((count for count in counts if count), 0)


def later(explained: Explanation, frames: float) -> Explanation:
    """Let all of it come so many frames later."""
    shifted = [replace(one, frame=one.frame + frames) for one in explained.collisions]
    return replace(explained, collisions=tuple(shifted))


def test_what_bounces_with_a_body_is_its_shadow() -> None:
    ball, shadow = bouncing(5), later(bouncing(5), 0.8)

    assert of_bodies_alone([ball, shadow]) is ball
    assert not of_bodies_alone([ball, bouncing(4)]).counts


def test_of_several_bodies_that_bounce_none_is_counted() -> None:
    chosen = of_bodies_alone([bouncing(None), bouncing(5), later(bouncing(5), 4.0)])

    assert not chosen.counts
    assert chosen.against == (Reason(Cause.SEVERAL_BOUNCE, (2,)),)


def test_few_impacts_of_one_of_several_bodies_may_be_those_of_a_trial() -> None:
    chosen = of_bodies_alone([bouncing(2), bouncing(None)])

    assert not chosen.counts
    assert [reason.cause for reason in chosen.against] == [Cause.OTHERS_MOVE]
    assert of_bodies_alone([bouncing(2)]).counts


def to_and_fro(count: int) -> Explanation:
    """One body alone that turns round at two stops, now at the one and now at the other."""
    one = bouncing(count)
    turns = [
        replace(
            at, velocity_before=Velocities(way, np.nan), velocity_after=Velocities(-way, np.nan)
        )
        for at, way in zip(one.collisions, cycle((1.0, -1.0)), strict=False)
    ]
    return replace(one, collisions=tuple(turns))


@pytest.mark.parametrize("impacts", [2, 4, 9])
def test_impacts_at_two_stops_may_be_those_of_a_trial_where_others_move(impacts: int) -> None:
    """Its ball turns round at the wall and at the heavy body, any number of times."""
    assert not of_bodies_alone([to_and_fro(impacts), bouncing(None)]).counts
    assert of_bodies_alone([to_and_fro(impacts)]).counts

"""Copies between evenly taken pictures, and copies in the place of lost ones."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from filmed_trials import Filming, film
from free_paths import alone, between_stops, noisy
from hypothesis import given
from hypothesis import strategies as st

from count_video.motion.meeting import seen_impacts
from count_video.motion.time_hypotheses import with_copies
from count_video.physics.setup import Setup
from count_video.records import Collision, Floats, Track

NOISE_PX = 0.1
PICTURES = 240
TIME_WITHIN = 0.1
"""Frames; at 4 px a frame and 0.1 px of noise a corner is known to some hundredths."""


@cache
def filmed() -> tuple[Track, list[float]]:
    """A body between two stops, and its impacts, by pictures; none is just at a picture."""
    place, impacts = between_stops(4.13, 90.0, PICTURES)
    return alone(noisy(place, NOISE_PX)), impacts


@cache
def an_impact() -> Collision:
    return seen_impacts(filmed()[0]).collisions[0]


def without(track: Track, lost: slice) -> Track:
    """The track without some of its pictures."""
    frame = np.delete(track.frame, lost)
    bodies = [
        replace(
            body,
            position_px=np.delete(body.position_px, lost),
            sigma_px=np.delete(body.sigma_px, lost),
        )
        for body in track.bodies
    ]
    ball, heavy = (*bodies, None)[:2]
    assert ball is not None
    return replace(track, frame=frame, ball=ball, heavy=heavy)


def first_shown(every: int) -> Floats:
    """Frame in which each picture comes first when one of ``every`` is shown twice."""
    pictures = np.arange(PICTURES)
    return (pictures + pictures // every).astype(float)


def when_shown(impact: float, every: int) -> float:
    """Frame of an impact: between the last copy of the picture before and the picture after."""
    before = int(np.floor(impact))
    return float(first_shown(every)[before + 1]) - 1.0 + impact - before


@pytest.mark.parametrize("every", [2, 4, 5, 24])
def test_pictures_with_copies_between_them_are_timed_evenly(every: int) -> None:
    track, impacts = filmed()
    copied = replace(track, frame=first_shown(every))
    cadence = with_copies(copied)
    assert cadence is not None
    assert np.ptp(np.diff(cadence.evened(copied).frame)) == pytest.approx(0.0, abs=1e-9)
    found = [cadence.shown(c).frame for c in seen_impacts(cadence.evened(copied)).collisions]
    wanted = [when_shown(impact, every) for impact in impacts]
    assert found == pytest.approx(wanted, abs=TIME_WITHIN)


def test_copies_that_were_not_noticed_at_first_are_left_out_once_their_time_is_known() -> None:
    track, _ = filmed()
    noticed = replace(track, frame=first_shown(5))
    # The first ten pictures with their two copies, as a track that takes them for pictures.
    rows = np.r_[0:5, 4, 5:10, 9, 10:PICTURES]
    body = track.ball
    ball = replace(body, position_px=body.position_px[rows], sigma_px=body.sigma_px[rows])
    missed = replace(track, frame=np.r_[0:12, noticed.frame[10:]].astype(float), ball=ball)
    cadence = with_copies(missed)
    assert cadence is not None
    assert cadence.frame.tolist() == noticed.frame.tolist()
    assert cadence.evened(missed).ball.position_px == pytest.approx(body.position_px)


@pytest.mark.parametrize("every", [3, 5, 24])
def test_copies_of_which_none_was_noticed_show_by_a_body_that_stands_still(every: int) -> None:
    track, _ = filmed()
    body = track.ball
    rows = np.repeat(np.arange(PICTURES), 1 + (np.arange(PICTURES) % every == every - 1))
    # Encoders change the copies a little.
    place = noisy(body.position_px[rows], NOISE_PX)
    ball = replace(body, position_px=place, sigma_px=body.sigma_px[rows])
    cadence = with_copies(replace(track, frame=np.arange(float(len(rows))), ball=ball))
    assert cadence is not None
    # Of a copy at the very end, after which no picture comes, nothing is known.
    assert cadence.frame[:PICTURES].tolist() == first_shown(every).tolist()


@pytest.mark.parametrize("every", [5, 24])
def test_frames_stay_even_where_copies_stand_for_lost_pictures(every: int) -> None:
    track, _ = filmed()
    assert with_copies(without(track, slice(every - 1, None, every))) is None


@pytest.mark.parametrize("copies", [1, 3, 20])
def test_a_picture_that_freezes_once_takes_no_time(copies: int) -> None:
    track, impacts = filmed()
    middle = int((impacts[2] + impacts[3]) / 2)
    frozen = replace(track, frame=track.frame + copies * (np.arange(PICTURES) > middle))
    cadence = with_copies(frozen)
    assert cadence is not None
    assert np.ptp(np.diff(cadence.evened(frozen).frame)) == pytest.approx(0.0, abs=1e-9)
    found = seen_impacts(cadence.evened(frozen)).collisions
    wanted = [impact + copies * (impact > middle) for impact in impacts]
    assert [cadence.shown(c).frame for c in found] == pytest.approx(wanted, abs=TIME_WITHIN)


@pytest.mark.parametrize("lost", [1, 2, 5])
def test_pictures_that_are_lost_once_leave_time_wherever_they_are(lost: int) -> None:
    track, _ = filmed()
    for first in range(1, PICTURES - lost - 1):
        assert with_copies(without(track, slice(first, first + lost))) is None, first


@pytest.mark.parametrize("lost", [1, 2, 5])
def test_so_do_pictures_of_two_bodies_that_collide(lost: int) -> None:
    trial = film(Setup(heavy_mass_kg=0.1, light_mass_kg=0.01, wall_gap_m=0.02), Filming(480.0))
    for first in range(1, len(trial.track.frame) - lost - 1):
        assert with_copies(without(trial.track, slice(first, first + lost))) is None, first


def test_frames_without_copies_are_even() -> None:
    track, _ = filmed()
    assert with_copies(track) is None
    assert with_copies(replace(track, frame=2.0 * track.frame)) is None


def test_a_body_at_rest_shows_no_cadence() -> None:
    still = alone(noisy(np.full(PICTURES, 50.0), NOISE_PX))
    assert with_copies(replace(still, frame=first_shown(5))) is None


@given(st.integers(2, 30), st.lists(st.floats(0.0, PICTURES - 1.001), min_size=2, max_size=8))
def test_shown_frames_keep_the_order_and_lie_between_the_pictures(
    every: int, places: list[float]
) -> None:
    track, _ = filmed()
    cadence = with_copies(replace(track, frame=first_shown(every)))
    assert cadence is not None
    one = an_impact()
    shown = [
        cadence.shown(
            replace(one, frame=cadence.time[0] + (cadence.time[1] - cadence.time[0]) * place)
        ).frame
        for place in sorted(places)
    ]
    assert np.all(np.diff(shown) >= -1e-6)
    for place, frame in zip(sorted(places), shown, strict=True):
        before = int(np.floor(place + 1e-9))
        assert frame <= first_shown(every)[before + 1] + 1e-6

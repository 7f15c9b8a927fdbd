"""Frames that a camera took at uneven times, which its time stamps say, rightly or not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from filmed_trials import Filming, film
from free_paths import alone, between_stops, noisy
from numpy.typing import NDArray

from count_video.explanations import by_impacts
from count_video.motion.fitted import NOTHING_KNOWN
from count_video.motion.stretches import longest_shot
from count_video.motion.time_base import at_rows
from count_video.motion.time_hypotheses import usual_times
from count_video.physics.setup import Setup
from count_video.reasons import Cause
from count_video.records import Floats, Track

NOISE_PX, PICTURES, LOST_SHARE = 0.1, 240, 0.12
TIME_WITHIN = 0.1
"""Frames; at 4 px a frame and 0.1 px of noise a corner is known to some hundredths."""


def uneven(track: Track) -> Track:
    """What is left of a track if a camera takes some pictures late, and says so."""
    return with_pictures(track, np.random.default_rng(4).random(len(track.frame)) > LOST_SHARE)


def with_pictures(track: Track, kept: NDArray[np.bool_]) -> Track:
    left = at_rows(track, kept)
    return replace(left, frame=np.arange(float(len(left.frame))), stamped=track.frame[kept])


def bouncing() -> tuple[Track, Floats]:
    place, impacts = between_stops(4.13, 90.0, PICTURES)
    return alone(noisy(place, NOISE_PX)), np.array(impacts)


def test_impacts_are_found_by_the_time_stamps_and_placed_among_the_frames() -> None:
    whole, impacts = bouncing()
    track = uneven(whole)
    assert track.stamped is not None
    explained = by_impacts(track, NOTHING_KNOWN)
    assert [note.cause for note in explained.notes] == [Cause.UNEVEN_STAMPS]
    found = [one.frame for one in explained.collisions]
    wanted = np.interp(impacts, track.stamped, track.frame)
    assert found == pytest.approx(wanted, abs=TIME_WITHIN)


def test_time_stamps_are_left_out_of_account_where_bodies_move_evenly_by_the_frames() -> None:
    track, _ = bouncing()
    stamped = uneven(replace(track, stamped=None)).stamped
    assert stamped is not None
    converted = at_rows(track, np.arange(len(track.frame)) < len(stamped))
    assert usual_times(replace(converted, stamped=stamped)).notes == ()


def test_a_step_that_the_time_stamps_explain_is_no_cut() -> None:
    whole = film(Setup(heavy_mass_kg=0.0105 * 4), Filming(240.0, NOISE_PX)).track
    kept = np.ones(len(whole.frame), dtype=bool)
    kept[20:25] = False  # while the heavy body swings in
    track = with_pictures(whole, kept)
    assert len(longest_shot(track).frame) == len(track.frame)
    assert len(longest_shot(replace(track, stamped=None)).frame) < len(track.frame)

"""Edited clips: cut where the camera stands, or with their first or last picture held or faded."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from filmed_trials import FilmedTrial, Filming, film_motion, make_track, part

from count_video.motion.fitted import NOTHING_KNOWN
from count_video.motion.stretches import longest_shot, without_still
from count_video.motion.time_base import at_rows
from count_video.physics.setup import Setup
from count_video.physics.simulator import simulate
from count_video.reasons import Cause, Reason
from count_video.records import BodyTrack, Track
from count_video.scenes import of_pair

LIGHT_KG = 0.0105
NOISE_PX = 0.03
HELD = 40
"""Pictures for which one is held."""
TIME_WITHIN = 0.15
"""Frames: five standard deviations of noise over a slow ball's step of a px."""


# ---- still pictures ------------------------------------------------------------------------------


@cache
def trial(ratio: float) -> FilmedTrial:
    motion = simulate(Setup(heavy_mass_kg=ratio * LIGHT_KG, wall_gap_m=0.03))
    return film_motion(motion, Filming(1200.0, NOISE_PX, lead_frames=60, tail_frames=120))


def held(track: Track, before: int, after: int) -> Track:
    """Hold the first and the last picture; held ones differ by a third of the noise."""
    rng = np.random.default_rng([before, after])

    def longer(body: BodyTrack) -> BodyTrack:
        place = np.pad(body.position_px, (before, after), mode="edge")
        place[:before] += rng.normal(0.0, NOISE_PX / 3, before)
        place[len(place) - after :] += rng.normal(0.0, NOISE_PX / 3, after)
        sigma = np.pad(body.sigma_px, (before, after), mode="edge")
        return replace(body, position_px=place, sigma_px=sigma)

    assert track.heavy is not None
    frame = np.arange(float(len(track.frame) + before + after))
    return replace(track, frame=frame, ball=longer(track.ball), heavy=longer(track.heavy))


@pytest.mark.parametrize(("before", "after"), [(HELD, 0), (0, HELD), (HELD, HELD)])
@pytest.mark.parametrize("ratio", [4.0, 16.0])
def test_held_pictures_change_no_count(ratio: float, before: int, after: int) -> None:
    filmed = trial(ratio)
    track = held(filmed.track, before, after)
    check(track, filmed, Cause.STANDS_STILL, before)


def check(track: Track, filmed: FilmedTrial, cause: Cause, first: int) -> None:
    """Check that a trial is counted that begins at some frame of a track, and why it alone is."""
    explained = of_pair(track, NOTHING_KNOWN, lambda _: (False, False))
    assert explained.counts
    assert explained.count == len(filmed.frames)
    found = [one.frame for one in explained.collisions[: explained.count]]
    np.testing.assert_allclose(found, filmed.frames + first, atol=TIME_WITHIN)
    last = first + len(filmed.track.frame) - 1
    assert Reason(cause, (float(first), float(last))) in explained.notes


@pytest.mark.parametrize("ratio", [1.0, 4.0, 16.0, 100.0])
def test_a_clip_without_held_pictures_keeps_all(ratio: float) -> None:
    track = trial(ratio).track
    assert without_still(track) is track


def test_two_like_pictures_at_an_end_are_no_held_picture() -> None:
    track = held(trial(16.0).track, 0, 1)
    assert without_still(track) is track


@pytest.mark.parametrize("px_per_frame2", [0.1, 0.5, 2.0, 8.0])
def test_a_cylinder_that_is_let_go_is_no_held_picture(px_per_frame2: float) -> None:
    px = 1 / Filming(1.0).px_per_m
    since = np.clip(np.arange(75.0) - 60.0, 0.0, None)
    heavy_m = 1.0 - 0.5 * px_per_frame2 * px * since**2
    track = make_track(np.full(75, 0.05), heavy_m, 0.04, Filming(1.0, NOISE_PX))
    assert without_still(track) is track


def test_bodies_that_stop_each_other_are_no_held_picture() -> None:
    px = 1 / Filming(1.0).px_per_m
    left = np.clip(60.0 - np.arange(90.0), 0.0, None)
    track = make_track(0.5 - 2 * px * left, 0.52 + 2 * px * left, 0.04, Filming(1.0, NOISE_PX))
    assert without_still(track) is track


# ---- cuts ----------------------------------------------------------------------------------------


def joined(*parts: Track) -> Track:
    """Show tracks one after the other."""
    heavy = [one.heavy for one in parts if one.heavy is not None]

    def one_after_the_other(bodies: list[BodyTrack]) -> BodyTrack:
        places, sigmas = (
            np.concatenate([getattr(one, name) for one in bodies])
            for name in ("position_px", "sigma_px")
        )
        return replace(bodies[0], position_px=places, sigma_px=sigmas)

    ball, cylinder = map(one_after_the_other, ([one.ball for one in parts], heavy))
    frame = np.arange(float(len(ball.position_px)))
    return replace(parts[0], frame=frame, ball=ball, heavy=cylinder)


def climax(filmed: FilmedTrial) -> Track:
    """From the second collision to the one before the last."""
    return part(filmed.track, int(filmed.frames[1]) + 2, int(filmed.frames[-2]) - 2)


def attempt(filmed: FilmedTrial) -> Track:
    """All up to the middle of the burst."""
    middle = len(filmed.frames) // 2
    return part(filmed.track, 0, int(filmed.frames[middle]) + 2)


@pytest.mark.parametrize("before", [climax, attempt])
@pytest.mark.parametrize("ratio", [4.0, 16.0])
def test_of_a_clip_that_is_cut_the_whole_trial_is_counted(
    ratio: float, before: Callable[[FilmedTrial], Track]
) -> None:
    filmed = trial(ratio)
    first = before(filmed)
    check(joined(first, filmed.track), filmed, Cause.OTHER_SHOTS, len(first.frame))


@pytest.mark.parametrize("ratio", [4.0, 16.0])
def test_parts_of_a_trial_are_none(ratio: float) -> None:
    filmed = trial(ratio)
    parts = joined(attempt(filmed), climax(filmed), attempt(filmed))
    assert not of_pair(parts, NOTHING_KNOWN, lambda _: (False, False)).counts


@pytest.mark.parametrize("ratio", [1.0, 4.0, 16.0, 100.0])
def test_a_clip_without_a_cut_is_one_shot(ratio: float) -> None:
    track = trial(ratio).track
    assert longest_shot(track) is track


def test_a_knock_of_the_camera_is_no_cut() -> None:
    track = trial(16.0).track
    knock = np.where(track.frame > 90, 25.0, 0.0)
    ball, heavy = (replace(b, position_px=b.position_px + knock) for b in track.bodies)
    knocked = replace(track, ball=ball, heavy=heavy)
    assert longest_shot(knocked) is knocked


@pytest.mark.parametrize("frames", [2, 3, 6])
def test_frames_whose_numbers_are_missing_are_no_cut(frames: int) -> None:
    track = trial(16.0).track
    gone = (track.frame < 30) | (track.frame >= 30 + frames)
    shown = at_rows(track, gone)
    assert longest_shot(shown) is shown


@pytest.mark.parametrize("both", [(), (0,), (0, 40)])
def test_bodies_that_are_hardly_seen_together_are_refused(both: tuple[int, ...]) -> None:
    track = trial(16.0).track
    hidden = np.full(len(track.frame), np.nan)
    hidden[list(both)] = track.ball.position_px[list(both)]
    apart = replace(track, ball=replace(track.ball, position_px=hidden))
    assert not of_pair(apart, NOTHING_KNOWN, lambda _: (False, False)).counts

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from filmed_trials import FilmedTrial, Filming, film

from count_video.explanations import at_wall, shown_at_wall
from count_video.motion.changing_rates import seen_by_time_bases
from count_video.motion.fitted import NOTHING_KNOWN, Between, fit_burst
from count_video.motion.seen import seen_collisions
from count_video.motion.time_base import left_out
from count_video.physics.setup import Setup
from count_video.reasons import Cause
from count_video.records import BodyTrack, Track

FPS = 480.0
SIGMAS = 4.0
"""Of a dozen times none is off by more by chance, one in a thousand."""
SETUP = Setup(heavy_mass_kg=0.168, wall_gap_m=0.03)
"""1:16."""
STEP_PX = 2.0
"""Forty times the noise of a place: clear, whatever makes it."""
HALF_FRAME = 0.5
"""What happened in frames left out is known to no better."""
NEXT_FRAME = 1
"""In a flight the place after the next frame fits as well, but for the noise of one place."""
EQUAL = Setup(heavy_mass_kg=0.0105, wall_gap_m=0.012, restitution_bodies=0.98)


@pytest.fixture(scope="module")
def whole() -> FilmedTrial:
    return film(SETUP, Filming(FPS))


def without(track: Track, after: float, frames: int) -> Track:
    """Leave frames out, and number the others as if they had not been."""
    kept = (track.frame <= after) | (track.frame > after + frames)
    late = track.frame > after
    assert track.heavy is not None
    return replace(
        track,
        frame=(track.frame - frames * late)[kept],
        ball=_rows(track.ball, kept),
        heavy=_rows(track.heavy, kept),
    )


def _rows(body: BodyTrack, kept: np.ndarray) -> BodyTrack:
    return replace(body, position_px=body.position_px[kept], sigma_px=body.sigma_px[kept])


def clear_places(trial: FilmedTrial) -> list[float]:
    """Frames in the middle of the longest flights of the burst."""
    frames = np.array(trial.frames)
    longest = np.argsort(np.diff(frames))[-2:]
    return [float(np.floor(frames[n] + np.diff(frames)[n] / 2)) for n in longest]


def fitted(track: Track) -> tuple[int, tuple[float, ...]]:
    """Count by the fit of the whole burst; after which frame it finds how many left out, if any."""
    fit = fit_burst(track, seen_collisions(track))
    assert isinstance(fit, Between)
    return fit.count, next((note.figures for note in fit.notes), ())


def test_an_even_clip_lacks_no_frames(whole: FilmedTrial) -> None:
    assert fitted(whole.track) == (whole.motion.count, ())


@pytest.mark.parametrize("frames", [3, 5])
def test_frames_left_out_of_a_flight_are_noticed_and_made_up_for(
    whole: FilmedTrial, frames: int
) -> None:
    for after in clear_places(whole):
        count, gap = fitted(without(whole.track, after, frames))

        assert count == whole.motion.count
        assert gap[1] == frames
        assert abs(gap[0] - after) <= NEXT_FRAME


def test_a_single_frame_left_out_changes_no_count(whole: FilmedTrial) -> None:
    for after in clear_places(whole):
        count, gap = fitted(without(whole.track, after, 1))

        assert count == whole.motion.count
        assert not gap or gap[1] == 1


@pytest.mark.parametrize(
    ("ball_px", "heavy_px"), [(STEP_PX, STEP_PX), (STEP_PX, 0.0), (0.0, STEP_PX), (-STEP_PX, 0.0)]
)
def test_a_knock_of_the_camera_or_a_template_that_slips_is_no_frame_left_out(
    whole: FilmedTrial, ball_px: float, heavy_px: float
) -> None:
    track = whole.track
    assert track.heavy is not None
    for after in clear_places(whole):
        late = track.frame > after
        moved = replace(
            track,
            ball=replace(track.ball, position_px=track.ball.position_px + ball_px * late),
            heavy=replace(track.heavy, position_px=track.heavy.position_px + heavy_px * late),
        )
        explained = at_wall(moved, NOTHING_KNOWN)
        notes = [note.cause for note in explained.notes]

        assert (explained.counts, explained.count) == (True, whole.motion.count)
        assert Cause.GAP_MADE_UP_FOR not in notes


def test_collisions_in_frames_left_out_are_not_passed_over(whole: FilmedTrial) -> None:
    """Two of them, after which the bodies go on as if none had been."""
    middle = np.array(whole.frames[2:4])
    after = float(np.floor(middle[0] - 2))
    frames = int(np.ceil(middle[1] + 2) - after)
    track = without(whole.track, after, frames)

    base, found = seen_by_time_bases(track)[0]
    count, gap = fitted(track)

    assert found.burst < whole.motion.count
    assert found.doubts or found.shortcomings
    assert not base.notes
    assert (count, gap) == (whole.motion.count, (after, frames))


@pytest.mark.parametrize("number", [2, 4, 6])
def test_a_collision_in_frames_left_out_leaves_the_times_of_others_right(
    whole: FilmedTrial, number: int
) -> None:
    frames, at = 2, float(np.floor(whole.frames[number]))
    track = without(whole.track, at, frames)

    measured = fit_burst(track, seen_collisions(track))

    assert isinstance(measured, Between)
    assert [note.figures[1] for note in measured.notes] == [frames]
    shown = np.where(whole.frames > at + frames, whole.frames - frames, whole.frames)
    errors = [c.frame - true for c, true in zip(measured.collisions, shown, strict=True)]
    sigmas = [collision.frame_sigma for collision in measured.collisions]
    assert sigmas[number] >= HALF_FRAME
    assert np.abs(np.divide(errors, sigmas)).max() < SIGMAS


def test_collisions_are_dated_by_the_frames_that_are_there(whole: FilmedTrial) -> None:
    found = seen_collisions(whole.track).collisions[0]
    base = left_out(after=100.0, frames=9)

    stated = [
        base.shown(replace(found, frame=at)).frame for at in (99.0, 100.0, 105.0, 110.0, 120.0)
    ]

    assert stated == pytest.approx([99.0, 100.0, 100.5, 101.0, 111.0])


def test_equal_bodies_that_swing_back_and_collide_again_are_counted_once() -> None:
    # The heavy body hardly moves from its first contact on until it is driven back.
    trial = film(EQUAL, Filming(FPS, tail_frames=900))
    explained = shown_at_wall(trial.track, seen_collisions(trial.track))

    assert len(trial.frames) == 3
    assert not explained.against
    assert explained.count == 3
    assert len(explained.collisions) > 3

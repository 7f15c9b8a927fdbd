"""Exports whose rate changes inside the clip, and what the cylinder's path says of a track."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from filmed_trials import FilmedTrial, Filming, film_motion, part
from numpy.typing import NDArray

from count_video.answers import answer
from count_video.explanations import at_wall
from count_video.motion.changing_rates import Timed, resolves, seen_by_time_bases
from count_video.motion.fitted import NOTHING_KNOWN
from count_video.motion.gaps import gaps_of
from count_video.motion.seen import seen_collisions
from count_video.motion.time_base import Ramp
from count_video.motion.time_hypotheses import ramps_of, rate_changes
from count_video.physics.setup import Setup
from count_video.physics.simulator import simulate
from count_video.reasons import Cause
from count_video.records import BodyTrack, Floats, FootageInfo, FootageReport, Track
from count_video.scenes import of_pair
from count_video.settings import TrialSettings

LIGHT_KG = 0.0105
NOISE_PX = 0.03
CAPTURE_FPS = 1200.0
TIME_WITHIN = 0.5
"""Frames: a step at a change of the rate is known to a part of a frame only."""


@cache
def trial(ratio: float = 16.0) -> FilmedTrial:
    motion = simulate(Setup(heavy_mass_kg=ratio * LIGHT_KG, wall_gap_m=0.03))
    return film_motion(motion, Filming(CAPTURE_FPS, NOISE_PX, lead_frames=120, tail_frames=240))


def ramped(whole: FilmedTrial, factor: int) -> tuple[Track, Floats]:
    """One picture of ``factor`` before and after the middle of the burst, and all between.

    Returns the track and the pictures that were kept.
    """
    frame = whole.track.frame
    begin, end = (
        float(whole.frames[a] + whole.frames[a + 1]) / 2 for a in (1, len(whole.frames) - 3)
    )
    sparse = (frame < begin) | (frame > end)
    kept = np.flatnonzero(~sparse | (frame % factor == 0))
    return rows_of(whole.track, kept), frame[kept]


def rows_of(track: Track, kept: NDArray[np.intp]) -> Track:
    """Leave out all pictures but these and number them evenly."""
    assert track.heavy is not None
    bodies = [
        BodyTrack(b.position_px[kept], b.sigma_px[kept], b.low_edge_px, b.high_edge_px)
        for b in (track.ball, track.heavy)
    ]
    return replace(track, frame=np.arange(float(len(kept))), ball=bodies[0], heavy=bodies[1])


@pytest.mark.parametrize("factor", [2, 3, 4])
def test_a_ramp_is_undone(factor: int) -> None:
    whole = trial()
    track, kept = ramped(whole, factor)

    base, found = seen_by_time_bases(track)[0]

    assert found.burst == len(whole.frames)
    assert [(note.cause, note.figures[0]) for note in base.notes] == [(Cause.RATE_CHANGES, factor)]
    shown = np.array([base.shown(collision).frame for collision in found.collisions])
    truth = np.interp(whole.frames, kept, track.frame)
    assert np.abs(shown[: found.burst] - truth).max() < TIME_WITHIN


def test_velocities_of_a_ramp_are_those_of_the_frames() -> None:
    whole = trial()
    track, _ = ramped(whole, 4)
    base, found = seen_by_time_bases(track)[0]
    assert not base.keeps_rate

    first = base.shown(found.collisions[0])

    # One picture of four is left about the first collision: the cylinder comes on by so much.
    assert track.heavy is not None
    coming = np.diff(track.heavy.position_px)[int(first.frame) - 6 : int(first.frame)].mean()
    assert first.velocity_before.heavy_px_frame == pytest.approx(coming, rel=0.05)


def test_times_stand_by_which_the_fit_leaves_least_over(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of an even clip a change between two collisions may lose both of them, and be fitted."""
    whole = trial()
    track, frames = whole.track, whole.frames
    changes = float(frames[3] + frames[4]) / 2, float(frames[5] + frames[6]) / 2
    base = Ramp(changes, sparse_first=False, factor=2).time_base(track.frame)
    wrong = Timed(base, seen_collisions(base.evened(track), pace=1.0))
    right = seen_by_time_bases(track)
    monkeypatch.setattr("count_video.explanations.seen_by_time_bases", lambda _: [wrong, *right])
    explained = at_wall(track, NOTHING_KNOWN)
    assert explained.counts
    assert explained.count == len(frames)
    assert not explained.notes


@pytest.mark.parametrize("after", [0.6, 1.4, 2.6])
def test_a_ramp_next_to_a_collision_is_undone(after: float) -> None:
    """Wherever the change lies between the first two collisions: in sparse pictures from one."""
    whole = trial()
    begin = float(whole.frames[0]) + 4 * after
    frame = whole.track.frame
    end = float(whole.frames[-3] + whole.frames[-2]) / 2
    kept = np.flatnonzero((frame > begin) & (frame < end) | (frame % 4 == 0))

    base, found = seen_by_time_bases(rows_of(whole.track, kept))[0]

    assert found.burst == len(whole.frames)
    factor, *changes = base.notes[0].figures
    assert factor == 4
    assert changes == pytest.approx(np.interp([begin, end], frame[kept], range(len(kept))), abs=1)


@dataclass(frozen=True)
class Export:
    """A trial with parts of it shown faster."""

    setup: Setup
    capture_fps: float
    factor: int
    after_first: float
    """Frames of the camera from the first collision to the first change of the rate."""
    after_last: float
    """Frames of the camera from the last collision to the second change."""

    def film(self) -> tuple[FilmedTrial, Track]:
        filming = Filming(self.capture_fps, NOISE_PX, lead_frames=100, tail_frames=200)
        whole = film_motion(simulate(self.setup), filming)
        frame, ends = whole.track.frame, whole.frames[[0, -1]]
        dense = (frame > ends[0] + self.after_first) & (frame < ends[1] + self.after_last)
        kept = np.flatnonzero(dense | (frame % self.factor == 0))
        return whole, rows_of(whole.track, kept)


def hung(ratio: float, gap_m: float, release_m: float) -> Setup:
    return Setup(
        heavy_mass_kg=ratio * LIGHT_KG, wall_gap_m=gap_m, bodies_gap_m=0.001, release_m=release_m
    )


@pytest.mark.parametrize(
    "export",
    [
        pytest.param(
            Export(hung(2.44, 0.0294, 0.0497), 563.0, 6, 1.16, -120.4), id="few collisions"
        ),
        pytest.param(
            Export(hung(5.13, 0.0142, 0.0907), 1280.0, 8, 1.52, -74.4), id="next to the first"
        ),
        pytest.param(
            Export(hung(4.57, 0.0205, 0.0646), 736.0, 8, -28.9, 58.2), id="outside the burst"
        ),
        pytest.param(
            Export(hung(3.63, 0.0215, 0.0452), 794.0, 4, 57.0, -84.1), id="hides the second"
        ),
    ],
)
def test_the_path_gives_factor_and_places(export: Export) -> None:
    """Few pictures give the speeds to a fifth or so, and corners that are no collisions."""
    whole, track = export.film()

    base, found = seen_by_time_bases(track)[0]

    assert found.burst == len(whole.frames)
    shown = [(note.cause, note.figures[0]) for note in base.notes]
    assert shown == [(Cause.RATE_CHANGES, export.factor)]


def test_the_ball_at_rest_says_nothing_against_a_change() -> None:
    whole = trial()
    begin = float(whole.frames[0]) - 30.0
    frame = whole.track.frame
    kept = np.flatnonzero((frame > begin) | (frame % 4 == 0))

    track = rows_of(whole.track, kept)
    changes = rate_changes(gaps_of(track), seen_collisions(track).collisions)

    assert [round(1 / factor) for _, factor in changes] == [4]
    assert changes[0][0] == pytest.approx(begin / 4, abs=1)


def test_a_collision_that_is_half_shown_hides_no_change() -> None:
    track, _ = ramped(trial(), 4)
    found = seen_collisions(track)
    first = found.collisions[0]
    unknown = replace(first.velocity_after, ball_px_frame=float("nan"))
    collisions = [replace(first, velocity_after=unknown), *found.collisions[1:]]

    changes = rate_changes(gaps_of(track), collisions)

    assert [factor < 1 for _, factor in changes] == [True, False]


def test_a_ball_on_its_way_to_the_wall_at_the_end_hides_no_change() -> None:
    """The fitted motion knows what follows; the clock is another question."""
    setup = Setup(
        heavy_mass_kg=76.68 * LIGHT_KG, wall_gap_m=0.0253, bodies_gap_m=0.0015, release_m=0.0504
    )
    whole = film_motion(simulate(setup), Filming(CAPTURE_FPS, NOISE_PX, tail_frames=40))
    track, _ = ramped(whole, 2)

    base, found = seen_by_time_bases(track)[0]

    assert [reason.cause for reason in found.shortcomings] == [Cause.ENDS_WITHIN]
    assert not base.keeps_rate
    assert found.burst == len(whole.frames)


@pytest.mark.parametrize("end", [2, 4])
def test_no_other_clock_makes_up_for_collisions_that_are_missed(end: int) -> None:
    """Every eighth picture of a burst shows too few: that is no reason to change the rate."""
    whole = trial(60.0)
    kept = np.arange(0, len(whole.track.frame) * end // 4, 8)

    base, found = seen_by_time_bases(rows_of(whole.track, kept))[0]

    assert not base.notes
    assert found.doubts or found.shortcomings


@pytest.mark.parametrize("ratio", [1.0, 4.0, 16.0, 60.0])
def test_a_clip_of_one_rate_has_no_other_clock(ratio: float) -> None:
    track = trial(ratio).track
    assert not list(ramps_of(track, seen_collisions(track).collisions))


def test_a_clock_counts_many_times_where_pictures_are_left_out() -> None:
    ramp = Ramp((2.0, 4.5), sparse_first=True, factor=4)

    base = ramp.time_base(np.arange(7.0))

    assert base.time.tolist() == [0.0, 4.0, 8.0, 9.0, 10.0, 12.5, 16.5]


def test_a_collision_converted_to_a_clock_and_back_is_the_same() -> None:
    hit = seen_collisions(trial().track).collisions[0]
    base = Ramp((40.0, 90.0), sparse_first=False, factor=3).time_base(trial().track.frame)

    for frame in (20.3, 61.7, 120.1):
        there = base.timed(replace(hit, frame=frame))
        back = base.shown(there)
        assert back.frame == pytest.approx(frame)
        assert back.velocity_after.ball_px_frame == pytest.approx(hit.velocity_after.ball_px_frame)


def test_collisions_must_be_resolved_also_where_pictures_are_rare() -> None:
    whole = trial()
    base = Ramp((10.0,), sparse_first=True, factor=4).time_base(whole.track.frame)
    found = seen_collisions(whole.track)
    first, second, *_ = found.collisions

    for begin, resolved in ((12.0, False), (50.0, True)):
        two = replace(first, frame=begin), replace(second, frame=begin + 6.0)
        assert resolves(Timed(base, replace(found, collisions=two, burst=2))) is resolved


def test_a_cylinder_that_leaves_its_path_is_no_evidence() -> None:
    whole = trial()
    assert whole.track.heavy is not None
    good = seen_collisions(whole.track)
    # As if another thing was taken for it for a while, between two of its impacts.
    begin, end = (int(whole.frames[place]) for place in (0, 2))
    away = whole.track.heavy.position_px.copy()
    away[begin + 8 : end - 8] += 8.0
    bad = seen_collisions(replace(whole.track, heavy=replace(whole.track.heavy, position_px=away)))

    assert good.path_fits
    assert all(reason.cause is not Cause.STRAYS for reason in good.shortcomings)
    assert not bad.path_fits


def test_a_missed_pair_of_collisions_is_not_confirmed() -> None:
    whole = trial()
    middle = int(whole.frames[len(whole.frames) // 2])

    # Frames left out for a while: two impacts lie in the gap.
    before, after = part(whole.track, 0, middle - 20), part(whole.track, middle + 20)
    assert before.heavy is not None
    assert after.heavy is not None
    bodies = [
        replace(
            a,
            position_px=np.concatenate([a.position_px, b.position_px]),
            sigma_px=np.concatenate([a.sigma_px, b.sigma_px]),
        )
        for a, b in ((before.ball, after.ball), (before.heavy, after.heavy))
    ]
    frame = np.arange(float(len(bodies[0].position_px)))

    cut = replace(whole.track, frame=frame, ball=bodies[0], heavy=bodies[1])

    assert not seen_collisions(cut).path_fits


def test_a_clip_with_one_collision_with_the_wall_alone_is_judged() -> None:
    whole = trial()

    found = seen_collisions(part(whole.track, int(whole.frames[0]) + 2, int(whole.frames[2]) - 2))

    assert [collision.kind for collision in found.collisions] == ["wall"]
    assert found.shortcomings
    assert not found.path_fits


def test_where_the_rate_changes_there_are_no_times() -> None:
    track, _ = ramped(trial(), 4)
    info = FootageInfo(Path("clip.mp4"), 640, 240, 0, None, 30.0, CAPTURE_FPS, "option")
    report = FootageReport(len(track.frame), len(track.frame), ())
    explained = of_pair(track, NOTHING_KNOWN, lambda _: (False, False))
    result = answer(explained, info, report, TrialSettings())
    assert (result.count, result.even_rate, result.capture_fps) == (
        len(trial().frames),
        False,
        None,
    )
    assert all(one.time_s is None for one in result.collisions)
    whole = of_pair(trial().track, NOTHING_KNOWN, lambda _: (False, False))
    result = answer(whole, info, report, TrialSettings())
    assert (result.even_rate, result.capture_fps) == (True, CAPTURE_FPS)
    assert all(one.time_s is not None for one in result.collisions)

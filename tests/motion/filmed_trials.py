"""Tracks of simulated trials with their truth: exact positions at frame times, seeded noise."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from count_video.physics.setup import Setup
from count_video.physics.simulator import Motion, simulate
from count_video.records import BodyTrack, CollisionKind, Floats, MotionLine, Track, WallSide

PX_PER_M = 2000.0
RESOLVED_FRAMES = 2.5
"""Shortest interval between collisions that the frames show for certain."""


@dataclass(frozen=True)
class Filming:
    """How a trial is filmed."""

    capture_fps: float
    noise_px: float = 0.05
    lead_frames: int = 30
    """Frames before the first collision."""
    tail_frames: int = 60
    """Frames after the last collision of the burst."""
    clock_phase: float = 0.3
    """Where between two frames the first collision lies."""
    wall_side: WallSide = "left"
    px_per_m: float = PX_PER_M
    shift_px: float = 100.0


@dataclass(frozen=True)
class FilmedTrial:
    """A track with its truth."""

    track: Track
    motion: Motion
    frames: Floats
    """Frame coordinates of the collisions of the burst, shape (count,)."""
    kinds: tuple[CollisionKind, ...]

    @property
    def shortest_frames(self) -> float:
        """Shortest interval of the burst in frames."""
        return float(np.diff(self.frames).min(initial=np.inf))


def film(setup: Setup, filming: Filming, seed: int = 0) -> FilmedTrial:
    """Sample a simulated trial at frame times and add white noise."""
    return film_motion(simulate(setup, seed=seed), filming, seed)


def film_motion(motion: Motion, filming: Filming, seed: int = 0) -> FilmedTrial:
    """Sample a motion at frame times and add white noise."""
    rate = filming.capture_fps
    begin_s = motion.burst[0].time_s - (filming.lead_frames + filming.clock_phase) / rate
    end_s = motion.burst[-1].time_s + filming.tail_frames / rate
    frame = np.arange(int((end_s - begin_s) * rate) + 1, dtype=np.float64)
    sample = motion.sample(begin_s + frame / rate)
    radius_m = motion.setup.ball_diameter_m / 2
    track = make_track(
        sample.ball_far_face_m + radius_m, sample.heavy_face_m, 2 * radius_m, filming, seed
    )
    return FilmedTrial(
        track=track,
        motion=motion,
        frames=np.array([(c.time_s - begin_s) * rate for c in motion.burst]),
        kinds=tuple(c.kind for c in motion.burst),
    )


def make_track(
    ball_m: Floats, heavy_m: Floats, diameter_m: float, filming: Filming, seed: int = 0
) -> Track:
    """Turn distances from the wall (ball's centre, heavy body's face) into a noisy track."""
    rng = np.random.default_rng([seed, 5])
    sign = 1.0 if filming.wall_side == "left" else -1.0
    scale, noise = filming.px_per_m, filming.noise_px
    radius = diameter_m * scale / 2
    sigma = np.full(len(ball_m), noise)
    noise_ball, noise_heavy = rng.normal(0.0, noise, (2, len(ball_m)))
    ball = filming.shift_px + sign * (scale * ball_m + noise_ball)
    heavy = filming.shift_px + sign * (scale * heavy_m + noise_heavy)
    edges = (0.0, 2 * radius) if sign > 0 else (-2 * radius, 0.0)
    return Track(
        frame=np.arange(len(ball_m), dtype=np.float64),
        ball=BodyTrack(ball, sigma, -radius, radius),
        heavy=BodyTrack(heavy, sigma, *edges),
        wall_side=filming.wall_side,
        ball_diameter_px=2 * radius,
        line=MotionLine(0.0, 100.0, 0.0, upright=False),
        warnings=(),
    )


def resolving_fps(motion: Motion, interval_frames: float, at_least_fps: float = 240.0) -> float:
    """Capture rate at which the burst's shortest interval spans so many frames."""
    times = np.array([c.time_s for c in motion.burst])
    shortest = float(np.diff(times).min(initial=np.inf))
    return max(at_least_fps, interval_frames / shortest)


def part(track: Track, begin: int, end: int | None = None) -> Track:
    """Return the rows from ``begin`` to before ``end`` of a track; frames keep their numbers."""
    rows = slice(begin, end)
    assert track.heavy is not None
    return replace(
        track,
        frame=track.frame[rows],
        ball=_part(track.ball, rows),
        heavy=_part(track.heavy, rows),
    )


def _part(body: BodyTrack, rows: slice) -> BodyTrack:
    return replace(body, position_px=body.position_px[rows], sigma_px=body.sigma_px[rows])

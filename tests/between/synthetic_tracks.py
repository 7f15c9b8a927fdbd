"""Random trials near 1:100, filmed without pictures: tracks as a good tracker would give them."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from count_video.physics.setup import Setup
from count_video.physics.simulator import Motion, simulate
from count_video.records import BodyTrack, Floats, MotionLine, Track

PX_PER_M = 2000.0
LEAD_FRAMES, TAIL_FRAMES = 30, 40
EXPOSURE_SAMPLES = 24


@dataclass(frozen=True)
class Filming:
    """How a trial is filmed."""

    capture_fps: float
    shutter: float = 0.5
    """Part of the frame interval during which the shutter is open."""
    noise_px: float = 0.05
    clock_phase: float = 0.0
    """Where between two frames the trial starts, 0 to 1."""


@dataclass(frozen=True)
class FilmedTrial:
    """A track with its truth."""

    track: Track
    motion: Motion
    filming: Filming
    event_frames: Floats
    """Frame coordinates of all collisions of the burst."""

    @property
    def count(self) -> int:
        """Collisions of the burst."""
        return self.motion.count

    @property
    def shortest_frames(self) -> float:
        """Shortest interval of the burst in frames."""
        return float(np.diff(self.event_frames).min(initial=np.inf))


def film(setup: Setup, filming: Filming, seed: int) -> FilmedTrial:
    """Film a trial: positions averaged over the exposure, with white noise."""
    rng = np.random.default_rng([seed, 11])
    motion = simulate(setup, seed=seed)
    rate = filming.capture_fps
    begin_s = motion.burst[0].time_s - (LEAD_FRAMES + filming.clock_phase) / rate
    end_s = motion.burst[-1].time_s + TAIL_FRAMES / rate
    frames = np.arange(int((end_s - begin_s) * rate) + 1, dtype=np.float64)
    offsets = (np.arange(EXPOSURE_SAMPLES) + 0.5) / EXPOSURE_SAMPLES - 0.5
    times = begin_s + (frames[:, None] + filming.shutter * offsets) / rate
    sample = motion.sample(times.ravel())
    ball = sample.ball_far_face_m.reshape(times.shape).mean(axis=1) + setup.ball_diameter_m / 2
    heavy = sample.heavy_face_m.reshape(times.shape).mean(axis=1)
    events = np.array([(bounce.time_s - begin_s) * rate for bounce in motion.burst])
    diameter_px = setup.ball_diameter_m * PX_PER_M
    track = Track(
        frame=frames,
        ball=_body(ball, filming, rng, -diameter_px / 2, diameter_px / 2),
        heavy=_body(heavy, filming, rng, 0.0, 100.0),
        wall_side="left",
        ball_diameter_px=diameter_px,
        line=MotionLine(0.0, 100.0, 0.0, False),
        warnings=(),
    )
    return FilmedTrial(track, motion, filming, events)


def _body(
    place_m: Floats, filming: Filming, rng: np.random.Generator, low: float, high: float
) -> BodyTrack:
    noise = rng.normal(0.0, filming.noise_px, len(place_m))
    sigma = np.full(len(place_m), filming.noise_px)
    return BodyTrack(100.0 + PX_PER_M * place_m + noise, sigma, low, high)


def random_setup(rng: np.random.Generator) -> Setup:
    """Draw a set-up near 1:100 with losses as balls and walls have them."""
    scatter = float(rng.choice([0.0, 0.003, 0.01]))
    return setup_of(rng, scatter, float(rng.uniform(60.0, 140.0)), least_restitution=0.94)


def setup_of(
    rng: np.random.Generator, scatter: float, mass_ratio: float, *, least_restitution: float
) -> Setup:
    """Draw the rest of a set-up."""
    return Setup(
        heavy_mass_kg=0.0105 * mass_ratio,
        wall_gap_m=float(rng.uniform(0.01, 0.07)),
        bodies_gap_m=float(rng.uniform(0.0, 0.004)),
        release_m=float(rng.uniform(0.05, 0.09)),
        light_thread_m=float(rng.uniform(0.97, 1.03)),
        restitution_bodies=float(rng.uniform(least_restitution, 1.0)),
        restitution_wall=float(rng.uniform(least_restitution, 1.0)),
        restitution_bodies_sd=scatter,
        restitution_wall_sd=scatter,
    )


def random_long_trial(seed: int, capture_fps: float) -> FilmedTrial:
    """Draw a trial near 1:10 000 with bodies as hard as steel."""
    rng = np.random.default_rng([seed, 99])
    setup = Setup(
        heavy_mass_kg=0.0105 * float(rng.uniform(9000.0, 11000.0)),
        wall_gap_m=float(rng.uniform(0.02, 0.06)),
        bodies_gap_m=float(rng.uniform(0.0, 0.002)),
        release_m=float(rng.uniform(0.06, 0.09)),
        light_thread_m=float(rng.uniform(0.98, 1.02)),
        restitution_bodies=float(rng.uniform(0.995, 1.0)),
        restitution_wall=float(rng.uniform(0.995, 1.0)),
    )
    return film(setup, Filming(capture_fps, clock_phase=float(rng.random())), seed)


def random_trial(seed: int, capture_fps: float) -> FilmedTrial:
    """Draw a trial of 25 to 35 collisions whose shortest interval is at least 0.25 frame."""
    rng = np.random.default_rng([seed, round(capture_fps)])
    while True:
        setup = random_setup(rng)
        motion = simulate(setup, seed=seed)
        intervals = [b.time_s - a.time_s for a, b in pairwise(motion.burst)]
        if not 25 <= motion.count <= 35 or min(intervals) * capture_fps < 0.25:
            continue
        filming = Filming(
            capture_fps,
            shutter=float(rng.uniform(0.1, 0.9)),
            noise_px=float(rng.uniform(0.03, 0.1)),
            clock_phase=float(rng.random()),
        )
        return film(setup, filming, seed)

"""Random set-ups for a scene, so that many clips of it are as many different trials."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np

from count_video.errors import UsageError
from count_video.physics.setup import Setup
from count_video.physics.simulator import Motion, simulate
from count_video.records import WallSide
from synth_video.experiments.happening import varied_experiment
from synth_video.scene import Scene
from synth_video.schedule import first_event_s, last_event_s

FEWEST_COLLISIONS, MOST_COLLISIONS = 3, 45
HIGHEST_RATIO = 250.0
SHORTEST_INTERVAL_FRAMES = (2.7, 6.0)
"""The capture rate is drawn so that the shortest interval of the burst takes this many frames."""
LOWEST_RATE = 120.0
"""Frames per second: slower is no slow motion."""
LONGEST_BURST_FRAMES = 1500.0
_TRIES = 1000


def varied(scene: Scene, seed: int) -> Scene:
    """Draw the set-up, the wall's side and the capture rate of a scene at random.

    Mass ratio from 1 to 250, counts from 3 to 45, restitution 1 in half of the draws and 0.9 to 1
    in the others. The rate suits the burst: all its collisions are seen one by one. A trial that
    would take too many frames at such a rate, or more than ``clip.max_frames`` leaves for the
    burst, is drawn again.

    Raises
    ------
    UsageError
        If the scene's bodies allow no such trial.
    """
    if scene.experiment.kind != "pi":
        return varied_experiment(scene, seed)
    rng = np.random.default_rng(seed)
    for _ in range(_TRIES):
        setup = _drawn_setup(scene.setup, rng)
        motion = simulate(setup, seed=seed)
        drawn = _filmed(replace(scene, setup=setup), motion, rng)
        if not FEWEST_COLLISIONS <= motion.count <= MOST_COLLISIONS:
            continue
        if _short(drawn, motion) and _in_sight(drawn, motion):
            return drawn
    raise UsageError(f"no trial found for scene {scene.name} in {_TRIES} draws; check its set-up")


def _filmed(scene: Scene, motion: Motion, rng: np.random.Generator) -> Scene:
    """Draw the wall's side and a capture rate that suits the burst."""
    interval_frames = rng.uniform(*SHORTEST_INTERVAL_FRAMES)
    side: WallSide = "left" if rng.random() < 0.5 else "right"
    rate = max(LOWEST_RATE, round(interval_frames / _shortest_interval_s(motion), 2))
    camera, wall = replace(scene.camera, capture_fps=rate), replace(scene.wall, side=side)
    drawn = replace(scene, camera=camera, wall=wall)
    return _entered(drawn, motion) if scene.view.beyond_m and motion.burst else drawn


def _short(scene: Scene, motion: Motion) -> bool:
    """Return whether the clip leaves enough frames for the burst."""
    clip = scene.clip
    longest = min(LONGEST_BURST_FRAMES, clip.max_frames - clip.lead_frames - clip.tail_frames - 2)
    shown_s = last_event_s(clip, motion) - first_event_s(clip, motion)
    return shown_s * scene.camera.capture_fps <= longest


def _in_sight(scene: Scene, motion: Motion) -> bool:
    """Return whether every collision of the burst happens within the picture."""
    return _farthest_m(motion) <= scene.view.width_m - scene.view.wall_m


def _farthest_m(motion: Motion) -> float:
    """Where the cylinder's face is at most when the burst collides, from the wall."""
    times_s = np.array([bounce.time_s for bounce in motion.burst])
    return float(motion.sample(times_s).ball_near_face_m.max())


def _entered(scene: Scene, motion: Motion) -> Scene:
    """Narrow the view until the cylinder comes in from outside, and start before it does.

    A cylinder that is released within the view makes the clip start before its release: too
    early, and the trial is refused for its length.
    """
    view, clip, rate = scene.view, scene.clip, scene.camera.capture_fps
    edge_m = _farthest_m(motion) + view.beyond_m
    first_s = motion.collisions[0].time_s
    before_s = np.arange(0.0, first_s, 1 / rate)
    outside = motion.sample(before_s).heavy_face_m > edge_m
    enters_s = float(before_s[outside][-1]) if outside.any() else -np.inf
    lead = clip.lead_frames + min((first_s - enters_s) * rate, float(clip.max_frames))
    return replace(
        scene,
        view=replace(view, width_m=view.wall_m + edge_m),
        clip=replace(clip, lead_frames=int(lead)),
    )


def _drawn_setup(setup: Setup, rng: np.random.Generator) -> Setup:
    """Masses, gaps, release and restitution at random, all else as it is."""
    ratio = float(np.exp(rng.uniform(0.0, np.log(HIGHEST_RATIO))))
    perfect = rng.random() < 0.5
    bodies, wall = (1.0 if perfect else float(rng.uniform(0.9, 1.0)) for _ in range(2))
    return replace(
        setup,
        heavy_mass_kg=ratio * setup.light_mass_kg,
        wall_gap_m=float(rng.uniform(0.01, 0.07)),
        bodies_gap_m=float(rng.uniform(0.0, 0.005)),
        release_m=float(rng.uniform(0.05, 0.09)),
        restitution_bodies=bodies,
        restitution_wall=wall,
    )


def _shortest_interval_s(motion: Motion) -> float:
    """Shortest time between two collisions of the burst."""
    times_s = [bounce.time_s for bounce in motion.burst]
    return min((b - a for a, b in pairwise(times_s)), default=np.inf)

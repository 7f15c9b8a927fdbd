r"""How well can a picture show where a body is? The bound of Cramér and Rao, from its slopes.

A pixel p shows a body that lies at (x, y), under light of gain g and offset o, as

    m_p = g I_p(x, y) + o,       with white noise of variance s^2 on top.

The logarithm of the likelihood of a picture is - sum_p (seen_p - m_p)^2 / 2 s^2, so what it says
of the four unknowns q = (x, y, g, o) is Fisher's information

    J = (1 / s^2) sum_p (dm_p/dq) (dm_p/dq)^T,   dm/dq = (dI/dx, dI/dy, I, 1)   at g = 1, o = 0,

and no unbiased estimate of x has a variance below (J^-1)_xx. Were only x unknown, that would be
s^2 / sum (dI/dx)^2; the others take away the part of dI/dx that has their shape:

    var(x) >= s^2 / sum_p r_p^2,   r = dI/dx less its projection on dI/dy, I and 1.

(A body with an edge on both sides loses next to nothing: its slopes are of opposite sign.) The sum
runs over the pixels that the body covers or that its edge reaches. The slopes are differences of
noiseless pictures in which the body alone is moved by a quarter of a px, so they are those of the
scene before it was sampled, and not of a smoothed one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from count_video.physics.simulator import simulate
from count_video.records import Floats
from synth_video.experiments.course import course_of_trial
from synth_video.film import ART, CLOCK, Compositor
from synth_video.moving_layers import Moving
from synth_video.optics import vignette
from synth_video.projection import projection_of
from synth_video.scene import Scene
from synth_video.schedule import BodyPath, Paths, exposures, schedule_of
from synth_video.stage import BALL, HEAVY, set_stage

STEP_PX = 0.25
LUMA = np.array([0.299, 0.587, 0.114])
COVERED = 1e-3
"""Coverage from which on a pixel shows the body."""
EVERY = 40
"""The bound hardly changes from frame to frame: every fortieth is looked at."""


@dataclass
class NoiselessFilm:
    """Pictures of a scene without noise, and with a body moved out of its place."""

    scene: Scene
    seed: int

    def __post_init__(self) -> None:
        self.projection = projection_of(self.scene)
        art = np.random.default_rng([self.seed, ART])
        self.stage = set_stage(self.scene, self.projection, art)
        self._compositor = Compositor(self.stage)
        camera = self.scene.camera
        shade = vignette(camera.width_px, camera.height_px, camera.vignette)
        self._shade = shade * self.scene.light.brightness

    def paths(self) -> list[Paths]:
        """Where the bodies are in every fortieth frame."""
        motion = simulate(self.scene.setup, seed=self.seed)
        schedule = schedule_of(self.scene, motion, np.random.default_rng([self.seed, CLOCK]))
        scale, rising = self.projection.px_per_m, self.scene.view.rising_path
        return list(exposures(course_of_trial(motion, rising=rising), schedule, scale))[::EVERY]

    def luma(self, paths: Paths) -> Floats:
        """Brightness, shape (height, width), not rounded; the wall stands on the left."""
        return np.asarray((self._compositor.compose(paths) @ LUMA) * self._shade)

    def body_pixels(self, paths: Paths, body: int) -> np.ndarray:
        """Which pixels show the body at least in part, shape (height, width)."""
        shown = np.zeros(self._shade.shape, dtype=bool)
        for source in self.stage.layer_sources:
            if not (isinstance(source, Moving) and source.body == body and source.level_m is None):
                continue
            for layer in () if source.mirrored else source.layers(paths, self.projection):
                y, x = np.nonzero(layer.placed.pixels[..., 3] > COVERED)
                y, x = y + layer.placed.y_px, x + layer.placed.x_px
                inside = (y >= 0) & (x >= 0) & (y < shown.shape[0]) & (x < shown.shape[1])
                shown[y[inside], x[inside]] = True
        return shown


def bounds_px(scene: Scene, seed: int) -> tuple[float, float]:
    """Lowest standard deviations of the places of ball and heavy body, RMS over the frames.

    They are in px for a noise of one grey level, and grow with it.
    """
    film = NoiselessFilm(scene, seed)
    paths = film.paths()
    ball, heavy = (
        float(np.sqrt(np.mean([_variance(film, path, body) for path in paths])))
        for body in (BALL, HEAVY)
    )
    return ball, heavy


def _variance(film: NoiselessFilm, paths: Paths, body: int) -> float:
    """Bound on the variance of x in one frame, in px squared, for a noise of one grey level."""
    step_m = STEP_PX / film.projection.px_per_m
    shown = film.body_pixels(paths, body)
    slopes = [
        (film.luma(_moved(paths, body, shift)) - film.luma(_moved(paths, body, -shift)))
        / (2 * STEP_PX)
        for shift in (np.array([step_m, 0.0]), np.array([0.0, step_m]))
    ]
    picture = film.luma(paths)
    gradients = np.stack([*(s[shown] for s in slopes), picture[shown], np.ones(shown.sum())])
    return float(np.linalg.inv(gradients @ gradients.T)[0, 0])


def _moved(paths: Paths, body: int, shift_m: Floats) -> Paths:
    """Paths with one body moved along the line and upward."""
    bodies = list(paths.bodies)
    bodies[body] = BodyPath(bodies[body].along_m + shift_m[0], bodies[body].up_m + shift_m[1])
    return Paths(tuple(bodies), paths.times_s)

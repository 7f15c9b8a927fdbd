"""Things that get into the picture besides the apparatus."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np

from count_video.physics.laws import Law
from count_video.records import Floats
from synth_video.body_picture import BodyCanvas, BodyPicture, Pixels, as_pixels, body_canvas
from synth_video.moving_layers import Layer, LayerSource, Lens, Standing, light_appearance, standing
from synth_video.projection import Projection
from synth_video.raster import Raster
from synth_video.scene import Scene
from synth_video.schedule import Paths

# ---- hand ----------------------------------------------------------------------------------------
# The hand that holds the cylinder and lets it go.

SKIN = np.array([204.0, 152.0, 124.0])
SLEEVE = np.array([58.0, 74.0, 70.0])
BACK_M_S2, UP_M_S2 = 3.0, 2.0
"""How the hand draws back: away from the wall, and upward."""
FINGERS = ((-0.021, 0.034), (-0.007, 0.040), (0.007, 0.038), (0.020, 0.030))
"""Height of each finger over the cylinder's axis and how far it reaches over it, in m."""
FINGER_M = 0.0066
"""Half thickness of a finger."""
KNUCKLES_M = 0.012
"""From the cylinder's far end to where the back of the hand begins."""


@dataclass(frozen=True)
class Hand:
    """A hand that goes with the cylinder until it lets go, then draws back."""

    picture: BodyPicture
    """About the axis of the cylinder at its far end."""
    law: Law
    """The cylinder's swing until the first collision: position of its face."""
    start_m: float
    """Face of the cylinder at the release."""
    length_m: float
    let_go_s: float

    def layers(self, paths: Paths, projection: Projection) -> Iterator[Layer]:
        """Lay the hand over the cylinder's far end, or where it has drawn back to."""
        held_s = np.clip(paths.times_s, 0.0, self.let_go_s)
        since_s = np.maximum(paths.times_s - self.let_go_s, 0.0)
        along_m = self._face_m(held_s) + self.length_m + 0.5 * BACK_M_S2 * since_s**2
        yield Layer(self.picture.placed(*projection.tilted(along_m, 0.5 * UP_M_S2 * since_s**2)))

    def _face_m(self, times_s: Floats) -> Floats:
        start = np.full_like(times_s, self.start_m)
        return np.asarray(start + self.law.advance(start, np.zeros_like(start), times_s)[0])


def paint_hand(lens: Lens) -> BodyPicture:
    """Paint four fingers over the far end, the back of the hand and a sleeve behind it.

    Channels: red, green, blue (premultiplied), coverage.
    """
    scale = lens.px_per_m
    reach, back, half = 0.050 * scale, 0.150 * scale, 0.052 * scale
    canvas = body_canvas((-reach, back), (-half, half), lens.tilt_deg, lens.blur_px, 2)
    along, up = canvas.along_px / scale, -canvas.down_px / scale
    cover = np.zeros_like(along)
    rgb = np.zeros((3, *along.shape))
    _lay(canvas, rgb, cover, _capsule(along, up, (0.070, 0.006), 0.110, 0.030) * scale, SLEEVE)
    back_of_hand = _capsule(along, up, (KNUCKLES_M, 0.0), 0.070, 0.027) * scale
    _lay(canvas, rgb, cover, back_of_hand, 0.93 * SKIN)
    for height_m, length_m in FINGERS:
        place = (KNUCKLES_M - length_m, height_m)
        finger = _capsule(along, up, place, length_m, FINGER_M) * scale
        round_light = 1 + 0.25 * np.clip((up - height_m) / FINGER_M, -1, 1)
        _lay(canvas, rgb, cover, finger, np.multiply.outer(SKIN, round_light))
    return canvas.finish([*np.clip(rgb, 0, 255), cover], lens.blur_px)


def _capsule(
    along_m: Floats, up_m: Floats, start_m: tuple[float, float], length_m: float, radius_m: float
) -> Floats:
    """Distance outside a level bar with round ends, from its start toward the hand."""
    beyond = along_m - np.clip(along_m, start_m[0], start_m[0] + length_m)
    return np.asarray(np.hypot(beyond, up_m - start_m[1]) - radius_m)


def _lay(canvas: BodyCanvas, rgb: Floats, cover: Floats, outside_px: Floats, color: Floats) -> None:
    """Paint a part, darker toward its outline, over what is there; in place."""
    part = canvas.coverage(outside_px)
    rim = np.clip(1.0 + 0.05 * outside_px, 0.0, 1.0)
    tone = color[:, None, None] if color.ndim == 1 else color
    rgb += (tone * (1 - 0.35 * rim) - rgb) * part
    cover += (1 - cover) * part


# ---- person --------------------------------------------------------------------------------------
# A person at the edge of the picture: a coat with folds and checks, out of focus, that sways.

COAT = np.array([74.0, 82.0, 104.0])
CHECK = np.array([150.0, 66.0, 58.0])
HAND_SKIN = np.array([196.0, 146.0, 118.0])
SOFT_M = 0.0012
"""Defocus of somebody who stands behind the apparatus."""
SWAY_SHARE = 0.4
"""Part of the reach by which the person sways about its mean place."""
DIP_M = 0.006
"""Height of the sway."""


@dataclass(frozen=True)
class Person:
    """Somebody who sways into the picture and out of it."""

    picture: BodyPicture
    """About the foremost point of the coat, which reaches away from the bodies."""
    edge_m: float
    """Distance from the wall of the picture's edge."""
    inward: int
    """-1 where the person comes from far off, 1 from behind the wall."""
    reach_m: float
    speed_m_s: float
    phase_rad: float

    def layers(self, paths: Paths, projection: Projection) -> Iterator[Layer]:
        """Lay the coat where the person has swayed to."""
        sway_m = SWAY_SHARE * self.reach_m
        angle = self.speed_m_s / sway_m * paths.times_s + self.phase_rad
        along_m = self.edge_m + self.inward * (self.reach_m - sway_m * (1 - np.sin(angle)))
        up_m = DIP_M * np.sin(0.7 * angle)
        yield Layer(self.picture.placed(*projection.tilted(along_m, up_m)))


def paint_person(
    width_px: int, height_px: int, px_per_m: float, inward: int, rng: np.random.Generator
) -> BodyPicture:
    """Paint a coat of this size, its foremost point in the middle of one upright side.

    Channels: red, green, blue (premultiplied), coverage.
    """
    # Depth counts from the foremost point into the coat.
    depth_m = np.arange(width_px) / px_per_m
    down_m = ((np.arange(height_px, dtype=np.float64) - height_px / 2) / px_per_m)[:, None]
    front_m = _front_m(down_m, rng)
    cover = as_pixels(np.clip((depth_m - front_m) * px_per_m, 0, 1))
    folds = _noise((height_px, width_px), 0.02 * px_per_m, rng)
    weave = _noise((height_px, width_px), 0.0012 * px_per_m, rng)
    checks = (np.sin(2 * np.pi * (depth_m + 0.1 * down_m) / 0.017) > 0.55) * 0.6
    checks = np.maximum(checks, (np.sin(2 * np.pi * (down_m - 0.1 * depth_m) / 0.02) > 0.6) * 0.5)
    rgb = COAT + (CHECK - COAT) * checks[..., None]
    lit = 1 + 0.22 * folds + 0.06 * weave - 3.0 * np.clip(0.02 - (depth_m - front_m), 0, 0.02)
    sleeve = np.abs(down_m - 0.035) + 0.35 * np.abs(depth_m - front_m - 0.01) < 0.010
    rgb[sleeve] = HAND_SKIN
    rgb = np.clip(rgb * lit[..., None], 0, 255)
    sheet = np.concatenate([rgb * cover[..., None], cover[..., None]], axis=-1)
    soft = as_pixels(cv2.GaussianBlur(as_pixels(sheet), (0, 0), max(SOFT_M * px_per_m, 0.5)))
    if inward < 0:
        return BodyPicture(np.ascontiguousarray(soft), 1, 0.0, height_px / 2)
    return BodyPicture(np.ascontiguousarray(soft[:, ::-1]), 1, float(width_px), height_px / 2)


def _front_m(down_m: Floats, rng: np.random.Generator) -> Floats:
    """Depth at which the coat begins, by height: waves, and a shoulder that slopes away."""
    front_m = 0.012 + 0.9 * np.clip(-down_m - 0.03, 0, None)
    for depth_m, length_m in ((0.006, 0.11), (0.003, 0.045), (0.0015, 0.021)):
        front_m += depth_m * np.sin(2 * np.pi * down_m / length_m + rng.uniform(0, 2 * np.pi))
    return np.asarray(front_m)


def _noise(shape: tuple[int, int], sigma_px: float, rng: np.random.Generator) -> Pixels:
    """Smooth random field of unit spread."""
    field = as_pixels(rng.standard_normal(shape))
    smooth = as_pixels(cv2.GaussianBlur(field, (0, 0), max(sigma_px, 0.3)))
    return as_pixels(smooth / (smooth.std() + 1e-6))


# ---- the things of a scene -----------------------------------------------------------------------
# The things of a scene as layer_sources: those behind the bodies, and those in front of them.

CORD_COLORS = ((52.0, 48.0, 46.0), (206.0, 200.0, 188.0), (120.0, 52.0, 44.0))
PERSON_DEPTH = 1.3
"""Width of the painted coat, in reaches: it must not end within the picture."""


def behind(
    scene: Scene, projection: Projection, lens: Lens, rng: np.random.Generator
) -> tuple[LayerSource, ...]:
    """Person and lying ball."""
    layer_sources: list[LayerSource] = []
    if scene.things.person:
        layer_sources.append(_person(scene, projection, rng))
    if scene.things.lying_ball:
        layer_sources.append(_lying_ball(scene, projection, lens))
    return tuple(layer_sources)


def before(scene: Scene, raster: Raster, lens: Lens) -> tuple[LayerSource, ...]:
    """Hand and cords."""
    layer_sources: list[LayerSource] = []
    if scene.things.hand_s and scene.setup.mounting == "suspended":
        layer_sources.append(_hand(scene, lens))
    if scene.things.cords:
        layer_sources.append(_cords(scene, raster, lens.blur_px / lens.px_per_m))
    return tuple(layer_sources)


def _person(scene: Scene, projection: Projection, rng: np.random.Generator) -> Person:
    things, width_m = scene.things, scene.view.width_m
    inward = -1 if things.person_side == "far" else 1
    reach_m = things.person * width_m
    scale = projection.px_per_m
    size = round(PERSON_DEPTH * reach_m * scale) + projection.width_px // 4
    picture = paint_person(size, 2 * projection.height_px, scale, inward, rng)
    edge_m = width_m - scene.view.wall_m if inward < 0 else -scene.view.wall_m
    return Person(picture, edge_m, inward, reach_m, things.person_m_s, float(rng.uniform(0, 6.28)))


def _lying_ball(scene: Scene, projection: Projection, lens: Lens) -> Standing:
    picture = light_appearance(scene.ball, scene.setup.ball_diameter_m, lens).at(0.0)
    along_m, up_m = np.array([scene.things.lying_along_m]), np.array([scene.things.lying_up_m])
    return Standing(picture.placed(*projection.tilted(along_m, up_m)))


def _hand(scene: Scene, lens: Lens) -> Hand:
    setup = scene.setup
    law = Law.hanging(
        setup.heavy_thread_m, setup.gravity_m_s2, setup.heavy_damping_per_s, setup.heavy_rest_m
    )
    start_m, length_m = setup.heavy_rest_m + setup.release_m, scene.cylinder.length_m
    return Hand(paint_hand(lens), law, start_m, length_m, scene.things.hand_s)


def _cords(scene: Scene, raster: Raster, lens_m: float) -> Standing:
    """Straight cords at all angles across the ball's way or the cylinder."""
    rng, half_m = raster.rng, scene.things.cord_m / 2
    cover = np.zeros(raster.shape, dtype=np.float32)
    rgb = np.zeros((*raster.shape, 3), dtype=np.float32)
    for number in range(scene.things.cords):
        along_m = rng.uniform(0.0, scene.setup.heavy_rest_m + 0.5 * scene.cylinder.length_m)
        lean = rng.uniform(-1.2, 1.2)
        wide_m = half_m * np.hypot(1.0, lean)
        cord = raster.polygon(
            [
                (along_m + lean * up_m + side * wide_m, up_m)
                for up_m, side in ((-0.5, -1), (-0.5, 1), (0.5, 1), (0.5, -1))
            ]
        )
        color = np.array(CORD_COLORS[number % len(CORD_COLORS)], dtype=np.float32)
        rgb += cord[..., None] * (color - rgb)
        cover += cord * (1 - cover)
    return standing(raster.picture(rgb, lens_m), raster.picture(cover, lens_m))

"""The hand that holds the cylinder and lets it go."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from count_video.physics.flights import Pendulum
from count_video.records import Floats
from synth_video.body_picture import BodyPicture
from synth_video.body_shapes import Lens
from synth_video.canvas import BodyCanvas, body_canvas
from synth_video.exposure import Paths
from synth_video.moving_layers import Layer
from synth_video.projection import Projection

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
    law: Pendulum
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
        return start + self.law.advance(start, np.zeros_like(start), times_s)[0]


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

"""Threads from the bodies up to their hangers, drawn row by row with exact coverage."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from count_video.records import Floats
from synth_video.body_picture import Placed
from synth_video.pixels import Pixels
from synth_video.projection import Projection

MOST_SAMPLES = 8
SHORT_TRAVEL_PX = 0.25
"""A thread that moves less than this during an exposure is drawn once, at its mean place: next to
the lens blur the rest does not show."""
PROFILE_STEP_PX = 1 / 512


@dataclass(frozen=True)
class Thread:
    """One thread; its upper end is fixed, its lower end moves with a body."""

    hanger_along_m: float
    hanger_up_m: float
    """The fixed end."""
    knot_along_m: float
    knot_up_m: float
    """The lower end, as seen from the body's reference point."""


@dataclass(frozen=True)
class ThreadAppearance:
    """What all threads have in common."""

    rgb: NDArray[np.float64]
    opacity: float
    profile: Floats
    """Covered part of a pixel by offset, as from ``thread_profile``."""


def draw_thread(
    thread: Thread,
    appearance: ThreadAppearance,
    projection: Projection,
    along_m: Floats,
    up_m: Floats,
) -> Placed | None:
    """Picture of a thread while its body's reference point passes the points given, shape (m,).

    Channels: red, green, blue (premultiplied), coverage. None where nothing of it is in sight.
    """
    knot_x, knot_y = projection.tilted(along_m + thread.knot_along_m, up_m + thread.knot_up_m)
    parts = 1 if np.ptp(knot_x) + np.ptp(knot_y) < SHORT_TRAVEL_PX else MOST_SAMPLES
    knot_x, knot_y = _thinned(knot_x, parts), _thinned(knot_y, parts)
    top_x, top_y = projection.tilted(np.array(thread.hanger_along_m), np.array(thread.hanger_up_m))
    bottom = min(int(np.ceil(knot_y.max())), projection.height_px)
    if bottom <= 0:
        return None
    rows = np.arange(bottom)[:, None]
    slope = (knot_x - top_x) / (knot_y - top_y)
    middle = top_x + (rows - top_y) * slope  # (rows, samples)
    left, right = int(np.floor(middle.min())) - 3, int(np.ceil(middle.max())) + 4
    columns = np.arange(left, right)[None, :, None]
    steps = np.abs(columns - middle[:, None, :]) / PROFILE_STEP_PX
    last = len(appearance.profile) - 1
    cover = appearance.profile[np.minimum(np.rint(steps).astype(np.intp), last)].mean(axis=2)
    cover *= appearance.opacity
    pixels: Pixels = np.empty((bottom, right - left, 4), dtype=np.float32)
    pixels[..., :3] = cover[..., None] * appearance.rgb
    pixels[..., 3] = cover
    return Placed(left, 0, pixels)


def _thinned(path_px: Floats, parts: int) -> Floats:
    """Mean positions of equal parts of a path."""
    return np.array([part.mean() for part in np.array_split(path_px, parts)])


def thread_profile(width_px: float, blur_px: float) -> Floats:
    """Covered part of a pixel by the offset of its centre from a thread seen through the lens.

    A box of the thread's width, blurred by the lens, averaged over the pixel: twice the integral
    of a normal distribution, tabulated from offset 0 in steps of ``PROFILE_STEP_PX``.
    """
    sigma = max(blur_px, 0.3)

    def integral(x_px: Floats) -> Floats:
        z = x_px / sigma
        density = np.exp(-0.5 * z * z) / np.sqrt(2 * np.pi)
        return np.asarray(sigma * (z * ndtr(z) + density))

    offset = np.arange(0, (width_px + 1) / 2 + 5 * sigma, PROFILE_STEP_PX)
    near, far = (1 - width_px) / 2, (1 + width_px) / 2
    steps = integral(offset + far) - integral(offset + near)
    return np.asarray(steps - integral(offset - near) + integral(offset - far))

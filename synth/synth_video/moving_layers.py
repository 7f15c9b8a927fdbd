"""What moves, or stands, before the still picture: each thing lays its layers frame by frame."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from count_video.records import Floats
from synth_video.appearance import BallSettings, CylinderSettings
from synth_video.body_picture import BodyPicture, Pixels, Placed
from synth_video.paint_bodies import (
    BallView,
    BlockAppearance,
    paint_ball,
    paint_block,
    paint_cart,
    paint_cylinder,
    paint_puck,
)
from synth_video.projection import Projection
from synth_video.schedule import Paths

# ---- threads -------------------------------------------------------------------------------------
# Threads from the bodies up to their hangers, drawn row by row with exact coverage.

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


# ---- layers --------------------------------------------------------------------------------------
# What moves, or stands, before the still picture: each thing lays its layers frame by frame.


@dataclass(frozen=True)
class Layer:
    """A picture to be laid over what is there already."""

    placed: Placed
    """Channels: red, green, blue (premultiplied), coverage; a fifth mirrors the lamps."""
    strength: Pixels | None = None
    """How far the picture shows at each place of the frame, shape (h, w, 1); None for fully."""


class LayerSource(Protocol):
    """A thing of the scene. Coordinates are tilted ones: the wall stands on the left."""

    def layers(self, paths: Paths, projection: Projection) -> Iterator[Layer]:
        """Yield its appearance during one exposure, the farthest first."""


class Appearance(Protocol):
    """The appearance of a body, which may change with time."""

    def at(self, time_s: float) -> BodyPicture:
        """Its picture at a real time."""


@dataclass(frozen=True)
class Moving:
    """A picture that goes with a body."""

    appearance: Appearance
    body: int
    """Index of the body in ``Paths.bodies``."""
    shift_m: float = 0.0
    """From the body's reference point to the picture's, along the line of motion."""
    level_m: float | None = None
    """Height at which the picture stays (a shadow); None to rise and fall with the body."""
    mirrored: bool = False
    """True for the image in the wall."""
    strength: Pixels | None = None

    def layers(self, paths: Paths, projection: Projection) -> Iterator[Layer]:
        """Lay the picture along the path of its body."""
        path = paths.bodies[self.body]
        along_m = path.along_m + self.shift_m
        up_m = path.up_m if self.level_m is None else np.full_like(along_m, self.level_m)
        at = projection.tilted(-along_m if self.mirrored else along_m, up_m)
        picture = self.appearance.at(float(paths.times_s.mean()))
        yield Layer(picture.placed(*at), self.strength)


@dataclass(frozen=True)
class Hanging:
    """The threads of a body."""

    threads: tuple[Thread, ...]
    appearance: ThreadAppearance
    body: int

    def layers(self, paths: Paths, projection: Projection) -> Iterator[Layer]:
        """Draw those of the threads that are in sight."""
        path = paths.bodies[self.body]
        for thread in self.threads:
            placed = draw_thread(thread, self.appearance, projection, path.along_m, path.up_m)
            if placed is not None:
                yield Layer(placed)


@dataclass(frozen=True)
class Standing:
    """A picture that stays where it is, in front of what was laid before."""

    placed: Placed

    def layers(self, paths: Paths, projection: Projection) -> Iterator[Layer]:
        """Lay it as it is."""
        yield Layer(self.placed)


def standing(rgb: Pixels, cover: Pixels) -> Standing:
    """Cut the smallest picture that holds all that is covered.

    Parameters
    ----------
    rgb
        Premultiplied colour of the whole frame, shape (h, w, 3).
    cover
        Its coverage, shape (h, w).
    """
    rows, columns = np.flatnonzero(cover.any(axis=1)), np.flatnonzero(cover.any(axis=0))
    if not rows.size:
        return Standing(Placed(0, 0, np.zeros((0, 0, 4), dtype=np.float32)))
    spot = slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)
    pixels = np.concatenate([rgb[spot], cover[spot][..., None]], axis=-1)
    return Standing(Placed(int(columns[0]), int(rows[0]), pixels))


# ---- bodies as their settings describe them ------------------------------------------------------
# Light and heavy body as their settings describe them, whatever their shape.

STEPS_OF_A_TURN = 90
"""Pictures of a body that turns: 4 degrees from one to the next."""
CELLS_OF_A_TURN = 4
"""Cells to a px of a body that turns; it is painted often."""


@dataclass
class Spinning:
    """An appearance that turns with time; each picture is painted when it is first needed."""

    paint: Callable[[float], BodyPicture]
    """Paints the body turned by an angle in radians."""
    spin_hz: float
    _painted: dict[int, BodyPicture] = field(default_factory=dict)

    def at(self, time_s: float) -> BodyPicture:
        """Picture at a real time, to the nearest step of the turn."""
        step = round(self.spin_hz * time_s * STEPS_OF_A_TURN) % STEPS_OF_A_TURN
        if step not in self._painted:
            self._painted[step] = self.paint(2 * np.pi * step / STEPS_OF_A_TURN)
        return self._painted[step]


@dataclass(frozen=True)
class Lens:
    """How the camera sees all bodies."""

    px_per_m: float
    tilt_deg: float
    blur_px: float


def light_appearance(
    ball: BallSettings, length_m: float, lens: Lens, *, reflected: bool = False
) -> Appearance:
    """Paint the light body about its centre."""
    length_px = length_m * lens.px_per_m
    if ball.shape == "ball":
        cells = CELLS_OF_A_TURN if ball.spin_hz else None
        view = BallView(length_px, lens.tilt_deg, lens.blur_px, reflected, cells)
        return _turning(ball.spin_hz, lambda turn_rad: paint_ball(ball, view, turn_rad))
    appearance = BlockAppearance(
        left_px=-length_px / 2,
        right_px=length_px / 2,
        height_px=(ball.height_m or length_m) * lens.px_per_m,
        color=ball.color,
        trim_color=ball.ring_color,
        mark_color=ball.mark_color,
        mark=ball.mark,
    )
    return _straight(ball.shape, appearance, lens, ball.spin_hz)


def heavy_appearance(cylinder: CylinderSettings, lens: Lens) -> Appearance:
    """Paint the heavy body about the middle of the face that meets the light one."""
    if cylinder.shape == "cylinder":
        return paint_cylinder(cylinder, lens.px_per_m, lens.tilt_deg, lens.blur_px)
    appearance = BlockAppearance(
        left_px=0.0,
        right_px=cylinder.length_m * lens.px_per_m,
        height_px=cylinder.diameter_m * lens.px_per_m,
        color=cylinder.color,
        trim_color=cylinder.clay_color,
        mark_color=(32, 32, 36),
        mark="M",
    )
    return _straight(cylinder.shape, appearance, lens, 0.0)


def _straight(shape: str, appearance: BlockAppearance, lens: Lens, spin_hz: float) -> Appearance:
    """Paint a block, a cart or a puck."""
    tilt_deg, blur_px = lens.tilt_deg, lens.blur_px
    if shape == "puck":
        return _turning(
            spin_hz, lambda turn_rad: paint_puck(appearance, tilt_deg, blur_px, turn_rad)
        )
    return (paint_block if shape == "block" else paint_cart)(appearance, tilt_deg, blur_px)


def _turning(spin_hz: float, paint: Callable[[float], BodyPicture]) -> Appearance:
    """Paint once what does not turn."""
    return Spinning(paint, spin_hz) if spin_hz else paint(0.0)

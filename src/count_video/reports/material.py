"""What the evidence is made of: a clip's answer, its track, and how to say both in units."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from count_video.records import Collision, Floats, Frame, MotionLine, Track, TrialResult

Luma = NDArray[np.uint8]
Point = tuple[float, float]
Range = tuple[float, float]
CROWD_SHARE = 0.6
"""The enlarged stretch is the shortest that holds this share of the burst."""
MARGIN_SHARE = 0.06
"""Of a stretch of frames, shown on either side of it."""
BESIDE_DIAMETERS = 0.35
"""Shown beyond the ball's path, towards the wall and towards the heavy body."""


@dataclass(frozen=True)
class SpaceTime:
    """The space-time image: the line of motion, cut out of every frame and laid row upon row."""

    frame: Floats
    """Frame coordinates of the rows, shape (n,)."""
    image: Luma
    """Brightness, shape (n, length): row by frame, column by position along the line in px."""


@dataclass(frozen=True)
class Pendulum:
    """How the heavy body swings, as measured."""

    rate_squared: float
    """Square of the angular rate in (radians per frame) squared."""
    centre_px: float
    """Distance of its face from the wall's side where the threads hang straight down, in px along
    the line, growing away from the wall."""


@dataclass(frozen=True)
class Material:
    """All that pictures and tables of one clip are made from."""

    result: TrialResult
    track: Track
    space_time: SpaceTime
    pendulum: Pendulum | None
    """None where the swing does not show."""

    @property
    def outward(self) -> int:
        """+1 where positions grow away from the wall, -1 where they fall."""
        return 1 if self.track.wall_side == "left" else -1

    @cached_property
    def burst(self) -> tuple[Collision, ...]:
        """The collisions that count, or would if the clip were counted."""
        size = burst_size(self.result)
        return tuple(c for c in self.result.collisions if c.number <= size)

    @cached_property
    def shown_frames(self) -> Range:
        """First and last frame of the whole picture: all collisions, or the clip without any."""
        frames = self.track.frame
        ends = (float(frames[0]), float(frames[-1]))
        collisions = self.result.collisions
        if not collisions:
            return ends
        low, high = collisions[0].frame, collisions[-1].frame
        margin = max(10.0, 2 * MARGIN_SHARE * (high - low))
        return max(ends[0], low - margin), min(ends[1], high + margin)

    @cached_property
    def crowded_frames(self) -> Range:
        """The shortest stretch of frames that holds most of the burst."""
        times = [collision.frame for collision in self.burst]
        if len(times) < 3:
            return self.shown_frames
        held = max(3, round(CROWD_SHARE * len(times)))
        starts = range(len(times) - held + 1)
        start = min(starts, key=lambda first: times[first + held - 1] - times[first])
        low, high = times[start], times[start + held - 1]
        margin = MARGIN_SHARE * (high - low) + 1.0
        return low - margin, high + margin

    def shown_places(self, frames: Range) -> Range:
        """Lowest and highest position shown: from the wall to the heavy body's face, and beyond."""
        track = self.track
        inside = (track.frame >= frames[0]) & (track.frame <= frames[1])
        low, high = (edge[inside] for edge in ball_edges_px(track))
        face = track.heavy.position_px[inside] if track.heavy is not None else high
        values = np.concatenate([low, high, face])
        values = values[np.isfinite(values)]
        if values.size == 0:
            return 0.0, float(self.space_time.image.shape[1])
        beside = BESIDE_DIAMETERS * track.ball_diameter_px
        return float(values.min()) - beside, float(values.max()) + beside


def burst_size(result: TrialResult) -> int:
    """How many of the collisions found belong to the burst, counted or not."""
    return result.count if result.count is not None else result.seen or 0


def contact_px(collision: Collision, track: Track) -> float:
    """Place along the line where the ball touches: its edge turned to heavy body or wall."""
    to_wall_low = track.wall_side == "left"
    low = to_wall_low == (collision.kind == "wall")
    edge = track.ball.low_edge_px if low else track.ball.high_edge_px
    return collision.position_px + edge


def ball_edges_px(track: Track) -> tuple[Floats, Floats]:
    """Outline of the ball along the line, at smaller and at larger positions, shape (n,) each."""
    ball = track.ball
    return ball.position_px + ball.low_edge_px, ball.position_px + ball.high_edge_px


# ---- units ------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Scale:
    """Turns px and frames into what the axes say."""

    length: float
    """Millimetres a px, or 1."""
    length_unit: str
    time: float
    """Milliseconds a frame, or 1."""
    time_unit: str

    @property
    def speed(self) -> float:
        """Speed units a px per frame; mm/ms is m/s."""
        return self.length / self.time

    @property
    def speed_unit(self) -> str:
        """``m/s`` where both scales are known."""
        if (self.length_unit, self.time_unit) == ("mm", "ms"):
            return "m/s"
        return f"{self.length_unit}/{self.time_unit}"


def scale_of(result: TrialResult) -> Scale:
    """Best units that are known."""
    millimetres, fps = result.millimetres_per_px, result.capture_fps
    return Scale(
        length=millimetres or 1.0,
        length_unit="mm" if millimetres else "px",
        time=1000.0 / fps if fps else 1.0,
        time_unit="ms" if fps else "frame",
    )


# ---- states -----------------------------------------------------------------------------------


@dataclass(frozen=True)
class States:
    """The state before the first collision of the burst and after each; arrays have shape (n,)."""

    number: Floats
    """0 before the first collision, then the collision's number."""
    scaled_heavy: Floats
    """V1 = sqrt(M) v1, away from the wall, in units of the first state's length; NaN if unknown."""
    scaled_light: Floats
    """V2 = sqrt(m) v2, likewise."""
    heavy_sigma: Floats
    """Standard uncertainty of V1, in the same unit, which counts as exact; NaN if unknown."""
    light_sigma: Floats
    """Standard uncertainty of V2, likewise."""
    swing_energy: Floats
    """Energy stored in the heavy body's swing, in units of the first state's kinetic energy and
    counted from there; 0 where the swing is not known."""


def measured_states(material: Material) -> States | None:
    """States of the burst; None where the mass ratio or the first state is not known."""
    burst, ratio = material.burst, material.result.mass_ratio
    if not burst or ratio is None:
        return None
    velocities = [burst[0].velocity_before, *(c.velocity_after for c in burst)]
    heavy, light, heavy_sigma, light_sigma = np.array(
        [
            (v.heavy_px_frame, v.ball_px_frame, v.heavy_sigma_px_frame, v.ball_sigma_px_frame)
            for v in velocities
        ]
    ).T * np.array([[math.sqrt(ratio)], [1.0]] * 2)
    length = math.hypot(heavy[0], light[0])
    if not (length > 0 and math.isfinite(length)):
        return None
    times = np.array([burst[0].frame, *(c.frame for c in burst)])
    swing = _swing_energy(material, times) * ratio
    return States(
        number=np.arange(len(velocities), dtype=np.float64),
        scaled_heavy=material.outward * heavy / length,
        scaled_light=material.outward * light / length,
        heavy_sigma=heavy_sigma / length,
        light_sigma=light_sigma / length,
        swing_energy=(swing - swing[0]) / length**2,
    )


def _swing_energy(material: Material, frames: Floats) -> Floats:
    """Twice the potential energy of the heavy body a unit of its mass, in (px/frame) squared."""
    pendulum, heavy = material.pendulum, material.track.heavy
    if pendulum is None or heavy is None or not np.isfinite(heavy.position_px).any():
        return np.zeros_like(frames)
    seen = np.isfinite(heavy.position_px)
    face = np.interp(frames, material.track.frame[seen], heavy.position_px[seen])
    return pendulum.rate_squared * (face * material.outward - pendulum.centre_px) ** 2


# ---- places in the picture --------------------------------------------------------------------


def image_point(line: MotionLine, position_px: float, shift: Point = (0.0, 0.0)) -> Point:
    """Image x and y of a position along the line of motion, in a picture shifted so far."""
    slope = np.tan(np.radians(line.tilt_deg))
    x, y = position_px, line.anchor_y_px + slope * (position_px - line.anchor_x_px)
    if line.upright:
        x, y = line.anchor_x_px + slope * (position_px - line.anchor_y_px), position_px
    return x + shift[0], y + shift[1]


def shift_of(track: Track, row: int) -> Point:
    """How far the picture of one row of a track is shifted by the camera's motion, by x and y."""
    if track.shift_px is None:
        return 0.0, 0.0
    x, y = track.shift_px[row]
    return float(x), float(y)


def touching(track: Track, collisions: tuple[Collision, ...]) -> Track:
    """Shift the heavy body's reference point to where the ball touches it, in the median.

    Its face is learnt from the picture, and a rim, a shadow or a reflection can pass for it. The
    track is not wrong by that, only shifted by a constant; and the collisions between the bodies
    give the constant, for there the heavy body's face is where the ball's outline is.
    """
    contacts = [c for c in collisions if c.kind == "bodies" and c.seen]
    if track.heavy is None or not contacts or not np.isfinite(track.heavy.position_px).any():
        return track
    place = track.heavy.position_px
    seen = np.isfinite(place)
    face = np.interp([c.frame for c in contacts], track.frame[seen], place[seen])
    shift = float(np.median(np.array([contact_px(c, track) for c in contacts]) - face))
    heavy = replace(
        track.heavy,
        position_px=place + shift,
        low_edge_px=track.heavy.low_edge_px - shift,
        high_edge_px=track.heavy.high_edge_px - shift,
    )
    return replace(track, heavy=heavy)


FRAMES_ENOUGH = 8
REACH_DIAMETERS = 0.3
STEP_PX = 0.5
BESIDE_RIM_PX = 1.5
"""Brightness is compared this far inside and outside of the circle."""
ANGLES_DEG = np.concatenate([np.arange(40, 141, 4), np.arange(220, 321, 4)])
"""The upper and the lower arc, which a shift across the line moves off the rim."""
CLEARER = 1.3
"""The best height is believed if it is so much clearer than the typical one."""


def levelled(track: Track, frames: list[Frame]) -> Track:
    """Shift the line of motion across itself so that the ball's circle lies on its rim.

    The track follows motion along the line and measures the line's height only roughly. Place and
    radius along the line being known, the height is where the brightness steps from inside to
    outside all around the circle. Where no rim shows (the body is no ball) the track is left as it
    is. A few frames are enough.
    """
    diameter = track.ball_diameter_px
    offsets = np.arange(-REACH_DIAMETERS, REACH_DIAMETERS, STEP_PX / diameter) * diameter
    clearness = np.zeros(len(offsets))
    rows = {int(index): row for row, index in enumerate(track.frame)}
    for frame in frames:
        row = rows.get(frame.index)
        if row is not None and np.isfinite(track.ball.position_px[row]):
            clearness += _rim_clearness(frame, track, row, offsets)
    best = int(np.argmax(clearness))
    if clearness[best] <= CLEARER * float(np.median(clearness)):
        return track
    anchor = "anchor_x_px" if track.line.upright else "anchor_y_px"
    height = getattr(track.line, anchor) + float(offsets[best])
    return replace(track, line=replace(track.line, **{anchor: height}))


def _rim_clearness(frame: Frame, track: Track, row: int, offsets: Floats) -> Floats:
    """Step of the brightness across the circle, for each offset across the line, shape (n,)."""
    from scipy.ndimage import map_coordinates  # noqa: PLC0415 - not for who only counts

    radius = track.ball_diameter_px / 2
    angle = np.radians(ANGLES_DEG)
    middle = image_point(track.line, float(track.ball.position_px[row]), shift_of(track, row))
    along, across = middle[::-1] if track.line.upright else middle
    picture = (frame.luma.T if track.line.upright else frame.luma).astype(np.float64)

    def brightness(size: float) -> Floats:
        x = np.broadcast_to(along + size * np.cos(angle), (len(offsets), len(angle)))
        y = across + offsets[:, None] + size * np.sin(angle)
        values: Floats = map_coordinates(picture, [y, x], order=1, mode="nearest")
        return values

    step = np.abs(brightness(radius + BESIDE_RIM_PX) - brightness(radius - BESIDE_RIM_PX))
    return np.asarray(step.mean(axis=1), np.float64)

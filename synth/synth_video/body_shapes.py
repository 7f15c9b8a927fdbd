"""Light and heavy body as their settings describe them, whatever their shape."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from synth_video.appearance import BallSettings, CylinderSettings
from synth_video.body_picture import BodyPicture
from synth_video.moving_layers import Appearance
from synth_video.paint_ball import BallView, paint_ball
from synth_video.paint_block import BlockAppearance, paint_block, paint_cart, paint_puck
from synth_video.paint_cylinder import paint_cylinder

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

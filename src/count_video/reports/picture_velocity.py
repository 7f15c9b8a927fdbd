"""The panel with the velocities of both bodies against time, and their jumps."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes

from count_video.records import Collision, Floats, Velocities
from count_video.reports.material import Material, scale_of
from count_video.reports.palette import BALL, BLACK, HEAVY, MARKS


@dataclass(frozen=True)
class _Body:
    label: str
    colour: str
    position_px: Floats
    of: Callable[[Velocities], float]


def draw_velocities(axes: Axes, material: Material, frames: tuple[float, float]) -> None:
    """Draw the velocities in a stretch of frames; positive is away from the wall."""
    scale = scale_of(material.result)
    unit = scale.speed * material.outward
    for body in _bodies(material):
        _draw_dots(axes, material, body, unit)
        _draw_pieces(axes, material.result.collisions, body, unit)
    for collision in material.result.collisions:
        colour = MARKS[collision.kind].colour
        axes.axvline(collision.frame, color=colour, linewidth=0.8, alpha=0.45, zorder=0)
    axes.axhline(0.0, color=BLACK, linewidth=0.8)
    axes.set_xlim(*frames)
    axes.set_ylim(*_limits(material, frames, unit))
    axes.set_xlabel("frame")
    axes.set_ylabel(f"velocity ({scale.speed_unit})\naway from the wall is up")
    axes.set_title("Velocities and their jumps")


def _bodies(material: Material) -> list[_Body]:
    track = material.track
    bodies = [_Body("ball", BALL, track.ball.position_px, _ball)]
    if track.heavy is not None:
        position = track.heavy.position_px
        bodies.append(_Body("cylinder", HEAVY, position, _heavy))
    return bodies


def _ball(velocities: Velocities) -> float:
    return velocities.ball_px_frame


def _heavy(velocities: Velocities) -> float:
    return velocities.heavy_px_frame


def _draw_dots(axes: Axes, material: Material, body: _Body, unit: float) -> None:
    """From one frame to the next, but for the steps that hold a collision."""
    frame = material.track.frame
    step = np.diff(body.position_px) / np.diff(frame) * unit
    middle = (frame[1:] + frame[:-1]) / 2
    times = np.array([c.frame for c in material.result.collisions])
    crossed = np.searchsorted(times, frame[1:]) != np.searchsorted(times, frame[:-1])
    axes.plot(middle[~crossed], step[~crossed], ".", color=body.colour, markersize=5, alpha=0.55)


def _draw_pieces(axes: Axes, collisions: tuple[Collision, ...], body: _Body, unit: float) -> None:
    """Lines of what was fitted between the collisions, joined by the jumps."""
    x, y = [], []
    for collision in collisions:
        x += [collision.frame] * 2
        y += [body.of(collision.velocity_before) * unit, body.of(collision.velocity_after) * unit]
    axes.plot(x, y, color=body.colour, linewidth=2.0, label=body.label, gid=body.label)


def _limits(material: Material, frames: tuple[float, float], unit: float) -> tuple[float, float]:
    shown = [c for c in material.result.collisions if frames[0] <= c.frame <= frames[1]]
    sides = [side for c in shown for side in (c.velocity_before, c.velocity_after)]
    values = [rate * unit for side in sides for rate in (side.ball_px_frame, side.heavy_px_frame)]
    known = [value for value in values if np.isfinite(value)]
    low, high = min(known, default=-1.0), max(known, default=1.0)
    room = 0.12 * (high - low) or 1.0
    return low - room, high + room

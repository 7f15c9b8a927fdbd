"""One body alone, or two without a wall: their track along the line of their impacts.

Asked when no ball and heavy body at a wall can be followed, or when they give no count.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from count_video.errors import TrackingError
from count_video.footage.reader import Footage
from count_video.progress import NO_PROGRESS, Progress
from count_video.records import BodyTrack, Floats, MotionLine, Track
from count_video.signals import sigma_of
from count_video.tracking.patches.choice import bodies_among
from count_video.tracking.patches.closer import seen_closer
from count_video.tracking.patches.movers import Movers, find_movers
from count_video.tracking.patches.parts import completed
from count_video.tracking.patches.paths import Path, cleaned
from count_video.tracking.roles import wall_side
from count_video.tracking.view import TrackSettings

DIRECTION_STEPS = (1, 2, 3, 4, 6, 8)
AGREEING = 0.9
"""Pictures over which second differences are taken, and the share of them, each with the weight of
its square, that agree in direction where they tell it."""
DIRECTION_ROUNDS = 4
DIRECTION_SPREAD_RAD = 0.35
"""Jumps further than this from the common direction are mistakes of the tracking, or glancing."""
NEAR_FACTOR = 1.15
"""Bodies up to this many times as far apart as at their nearest tell the line of their centres."""


@dataclass(frozen=True)
class Places:
    """Where one body was in every picture, in px of the footage; NaN where not seen."""

    x_px: Floats
    y_px: Floats
    width_px: float
    height_px: float

    @property
    def xy_px(self) -> Floats:
        """Shape (n, 2)."""
        return np.stack([self.x_px, self.y_px], axis=1)


def track_free_bodies(
    footage: Footage, settings: TrackSettings, progress: Progress = NO_PROGRESS
) -> Track:
    """Measure where one body alone, or each of two, was along the line of the impacts.

    Of two bodies the one at smaller positions is called the ball. Its ``wall_side`` is the side on
    which a body alone turns most sharply; for two it says nothing.

    Raises
    ------
    TrackingError
        If there is no such body, or there are more; the message says what was found.
    """
    movers = find_movers(footage, settings, progress)
    bodies = bodies_among(movers.paths)
    wholes = [completed(path, movers.paths, movers.sights) for path in bodies]
    frame = np.array([sight.frame for sight in movers.sights], dtype=np.float64)
    if len(wholes) == 1:
        alone = seen_closer(wholes[0], movers, footage, settings)
        return _lone_track(frame, _places(alone, movers, settings))
    return _pair_track(frame, [_places(cleaned(path), movers, settings) for path in wholes])


def _places(path: Path, movers: Movers, settings: TrackSettings) -> Places:
    """Turn a path in shrunk px into places in the footage."""
    scale = movers.scale
    left, top = (0, 0) if settings.region is None else settings.region[:2]
    x, y = (np.full(len(movers.sights), np.nan) for _ in range(2))
    x[path.rows] = (path.x_px + 0.5) * scale - 0.5 + left
    y[path.rows] = (path.y_px + 0.5) * scale - 0.5 + top
    width = float(np.median([blob.width_px for blob in path.blobs])) * scale
    height = float(np.median([blob.height_px for blob in path.blobs])) * scale
    return Places(x, y, width, height)


def _lone_track(frame: Floats, body: Places) -> Track:
    line = _line(body, _jump_direction(body.xy_px))
    ball = _body_track(body, line)
    side = wall_side(ball.position_px, ball.position_px) or "left"
    return Track(
        frame=frame,
        ball=ball,
        heavy=None,
        wall_side=side,
        ball_diameter_px=min(body.width_px, body.height_px),
        line=line,
        warnings=_unseen_warnings(ball, "body"),
    )


def _pair_track(frame: Floats, bodies: Sequence[Places]) -> Track:
    direction = _line_of_centres(bodies[1].xy_px - bodies[0].xy_px)
    left, right = sorted(bodies, key=lambda body: float(np.nanmedian(body.xy_px @ direction)))
    line = _line(left, direction)
    ball, heavy = _body_track(left, line), _body_track(right, line)
    reach = heavy.low_edge_px
    heavy = BodyTrack(heavy.position_px + reach, heavy.sigma_px, 0.0, heavy.high_edge_px - reach)
    return Track(
        frame=frame,
        ball=ball,
        heavy=heavy,
        wall_side="left",
        ball_diameter_px=min(left.width_px, left.height_px),
        line=line,
        warnings=(*_unseen_warnings(ball, "left body"), *_unseen_warnings(heavy, "right body")),
        wall_seen=False,
    )


def _jump_direction(xy_px: Floats) -> Floats:
    """Direction in which the velocity jumps, by the second differences; a unit vector.

    Over few pictures a jump stands out from a bent path most, over more from the noise: the first
    step is taken over which most of the differences agree in direction.
    """
    steps = [_second_differences(xy_px, step) for step in DIRECTION_STEPS]
    if not any(len(second) for second in steps):
        raise TrackingError("what moves cannot be followed: it is lost too often")
    agreeing = [_agreement(second) for second in steps]
    step = next((k for k, share in enumerate(agreeing) if share > AGREEING), np.argmax(agreeing))
    # Twice the angle, so that jumps there and back agree; others than most have no say.
    second = steps[int(step)]
    twice = _twice(second)
    angle, common = np.arctan2(second[:, 1], second[:, 0]), np.angle(twice.sum()) / 2
    for _ in range(DIRECTION_ROUNDS):
        away = (angle - common + np.pi / 2) % np.pi - np.pi / 2
        common = np.angle((twice * np.exp(-((away / DIRECTION_SPREAD_RAD) ** 2))).sum()) / 2
    direction = np.array([np.cos(common), np.sin(common)])
    forward = direction[int(np.argmax(np.abs(direction)))]
    return np.asarray(direction * np.sign(forward))


def _second_differences(xy_px: Floats, step: int) -> Floats:
    """Second differences over so many pictures, shape (n, 2), where all three show the body."""
    second = xy_px[2 * step :] - 2 * xy_px[step:-step] + xy_px[: -2 * step]
    return np.asarray(second[np.isfinite(second).all(axis=1)])


def _twice(second_px: Floats) -> NDArray[np.complex128]:
    """Turn differences, shape (n, 2), into complex numbers of twice their angle and square size."""
    return np.asarray((second_px[:, 0] + 1j * second_px[:, 1]) ** 2)


def _agreement(second_px: Floats) -> float:
    """Share of differences that agree in direction: 1 for a line, 0 for noise."""
    twice = _twice(second_px)
    whole = float(np.abs(twice).sum())
    return float(np.abs(twice.sum())) / whole if whole > 0 else 0.0


def _line_of_centres(apart_px: Floats) -> Floats:
    """Direction from one body to the other where they are nearest; a unit vector."""
    distance = np.hypot(*apart_px.T)
    if not np.isfinite(distance).any():
        raise TrackingError("two things move, but are never seen together")
    near = distance < NEAR_FACTOR * np.nanmin(distance)
    direction = apart_px[near].mean(axis=0)
    forward = direction[int(np.argmax(np.abs(direction)))]
    return np.asarray(direction * np.sign(forward) / np.hypot(*direction))


def _line(body: Places, direction: Floats) -> MotionLine:
    x, y = (float(np.nanmedian(place)) for place in (body.x_px, body.y_px))
    upright = bool(abs(direction[1]) > abs(direction[0]))
    along, across = (direction[1], direction[0]) if upright else (direction[0], direction[1])
    return MotionLine(x, y, float(np.degrees(np.arctan(across / along))), upright)


def _body_track(body: Places, line: MotionLine) -> BodyTrack:
    """Project a body's places on the line; positions are image x or y of the projection."""
    along = float(np.cos(np.radians(line.tilt_deg)))
    across = float(np.sin(np.radians(line.tilt_deg)))
    x, y = body.x_px - line.anchor_x_px, body.y_px - line.anchor_y_px
    forward, sideways = (y, x) if line.upright else (x, y)
    anchor = line.anchor_y_px if line.upright else line.anchor_x_px
    position = anchor + along * (along * forward + across * sideways)
    half = along * (body.height_px if line.upright else body.width_px) / 2
    sigma = np.where(np.isfinite(position), sigma_of(position), np.nan)
    return BodyTrack(position, sigma, -half, half)


def _unseen_warnings(body: BodyTrack, name: str) -> tuple[str, ...]:
    unseen = int(np.isnan(body.position_px).sum())
    if unseen == 0:
        return ()
    return (f"the {name} is not seen in {unseen} of {len(body.position_px)} frames",)

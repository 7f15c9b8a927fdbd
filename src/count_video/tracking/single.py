"""Bodies that move on their own: the track of each along the line of its impacts.

Asked when no two bodies that meet can be followed, or when they give no count.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from count_video.errors import TrackingError
from count_video.records import BodyTrack, Floats, MotionLine, Track
from count_video.signals import interpolated
from count_video.tracking.following import was_followed
from count_video.tracking.observation import Observation
from count_video.tracking.pairing import (
    Places,
    camera_shift,
    camera_turned,
    places_of,
    unseen_warning,
    wall_side,
)

DIRECTION_STEPS = (1, 2, 3, 4, 6, 8)
AGREEING = 0.9
"""Pictures over which second differences are taken, and the share of them, each with the weight of
its square, that agree in direction where they have one."""
DIRECTION_ROUNDS = 4
DIRECTION_SPREAD_RAD = 0.35
"""Jumps further than this from the common direction are mistakes of the tracking, or glancing."""
TRAVEL_SHARE = 0.3
"""A body moves on its own if it moves by this share of the way of the one that moves furthest."""
GOES_WITH_SHARE, GOES_WITH_SEEN = 0.1, 0.25
"""A shadow's path is a linear function of the body's, but for this share of its travel, in the
pictures that show both, if these are such a share of all."""


def single_tracks(seen: Observation) -> list[Track]:
    """Measure where each body that moves on its own was, along the line of its impacts.

    Those that move furthest, are largest and seen most come first. What moves as one of them makes
    it move is left out, and so is what hardly moves. Their ``wall_side`` is the side on which they
    turn most sharply.

    Raises
    ------
    TrackingError
        If there is no such body; the message says why.
    """
    movers, view = seen.movers, seen.view
    places = [places_of(body, movers, view) for body in movers.bodies if was_followed(body.x_px)]
    if not places:
        raise TrackingError("nothing moves that can be followed through the clip as one body")
    places = [place for place in places if _is_followed(place)]
    if not places:
        raise TrackingError("what moves cannot be followed: it is lost too often")
    least = TRAVEL_SHARE * max(_travel(place) for place in places)
    own: list[Places] = []
    for place in sorted(places, key=_prominence, reverse=True):
        if _travel(place) > least and not any(_goes_with(place, body) for body in own):
            own.append(place)
    return [_track(body, seen) for body in own]


def _is_followed(body: Places) -> bool:
    """Whether three pictures show a body that are few enough frames apart to show how it turns."""
    return any(len(_second_differences(body.xy_px, step)) for step in DIRECTION_STEPS)


def _prominence(body: Places) -> float:
    """Travel times size, in px squared, times the share of the pictures that show the body."""
    size_px = float(np.sqrt(body.width_px * body.height_px))
    return _travel(body) * size_px * float(np.isfinite(body.x_px).mean())


def _track(body: Places, seen: Observation) -> Track:
    line = _line(body, _jump_direction(body.xy_px))
    ball, aside_px = _along_and_across(body, line)
    return Track(
        frame=seen.frames.astype(np.float64),
        ball=ball,
        heavy=None,
        wall_side=wall_side(ball.position_px, ball.position_px) or "left",
        ball_diameter_px=float(min(body.width_px, body.height_px)),
        line=line,
        warnings=tuple(unseen_warning("body", ball.position_px)),
        shift_px=camera_shift(seen.movers, seen.view),
        turned=camera_turned(seen.movers, seen.view),
        beside_px=aside_px,
    )


def _goes_with(other: Places, body: Places) -> bool:
    """Whether a thing moves as a body makes it move: its shadow, mirror image or thread."""
    both = np.isfinite(other.x_px) & np.isfinite(body.x_px)
    if np.count_nonzero(both) < len(both) * GOES_WITH_SEEN:
        return False
    design = np.column_stack([body.xy_px[both], np.ones(np.count_nonzero(both))])
    solution, *_ = np.linalg.lstsq(design, other.xy_px[both], rcond=None)
    left_over = np.quantile(np.abs(other.xy_px[both] - design @ solution), 0.9, axis=0)
    return bool(left_over.max() <= GOES_WITH_SHARE * max(_travel(other), 1.0))


def _travel(body: Places) -> float:
    known = body.xy_px[np.isfinite(body.x_px)]
    return float(np.ptp(known, axis=0).max())


def _jump_direction(xy_px: Floats) -> Floats:
    """Direction in which the velocity jumps, by the second differences; a unit vector.

    Over few pictures a jump stands out from a bent path most, over more from the noise: the first
    step is taken over which most of the differences agree in direction.
    """
    steps = [_second_differences(xy_px, step) for step in DIRECTION_STEPS]
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


def _line(body: Places, direction: Floats) -> MotionLine:
    x, y = (float(np.nanmedian(place)) for place in (body.x_px, body.y_px))
    upright = bool(abs(direction[1]) > abs(direction[0]))
    along, across = (direction[1], direction[0]) if upright else (direction[0], direction[1])
    return MotionLine(x, y, float(np.degrees(np.arctan(across / along))), upright)


def _along_and_across(body: Places, line: MotionLine) -> tuple[BodyTrack, Floats]:
    """Project a body's places on the line; positions are image x or y of the projection.

    Also how far from the line it is, across it, by image x and y, shape (n, 2).
    """
    along = float(np.cos(np.radians(line.tilt_deg)))
    across = float(np.sin(np.radians(line.tilt_deg)))
    x, y = body.x_px - line.anchor_x_px, body.y_px - line.anchor_y_px
    forward, sideways = (y, x) if line.upright else (x, y)
    anchor = line.anchor_y_px if line.upright else line.anchor_x_px
    position = anchor + along * (along * forward + across * sideways)
    half = along * (body.height_px if line.upright else body.width_px) / 2
    aside = interpolated(along * sideways - across * forward)
    beside_px = np.outer(aside, [along, -across] if line.upright else [-across, along])
    return BodyTrack(position, body.sigma_px, -half, half), beside_px

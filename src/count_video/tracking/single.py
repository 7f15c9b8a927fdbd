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
    return any(len(_jumps(body.xy_px, step)) for step in DIRECTION_STEPS)


def _prominence(body: Places) -> float:
    """Travel times size, in px squared, times the share of the pictures that show the body."""
    return _travel(body) * float(np.sqrt(body.size_px.prod())) * float(body.seen.mean())


def _track(body: Places, seen: Observation) -> Track:
    """Project a body's places on the line of its jumps; positions are image x or y on it."""
    direction = _jump_direction(body.xy_px)
    upright = bool(abs(direction[1]) > abs(direction[0]))
    axes = [1, 0] if upright else [0, 1]
    anchor = np.nanmedian(body.xy_px, axis=0)
    (along, across), (forward, sideways) = direction[axes], (body.xy_px - anchor)[:, axes].T
    position = anchor[axes[0]] + along * (along * forward + across * sideways)
    half = float(along * body.size_px[axes[0]] / 2)
    aside = interpolated(along * sideways - across * forward)
    x, y = anchor.tolist()
    return Track(
        frame=seen.frames.astype(np.float64),
        ball=BodyTrack(position, body.sigma_px, -half, half),
        heavy=None,
        wall_side=wall_side(position, position) or "left",
        ball_diameter_px=float(body.size_px.min()),
        line=MotionLine(x, y, float(np.degrees(np.arctan(across / along))), upright),
        warnings=tuple(unseen_warning("body", position)),
        shift_px=camera_shift(seen.movers, seen.view),
        turned=camera_turned(seen.movers, seen.view),
        stamped=seen.view.footage.stamped(seen.frames),
        beside_px=np.outer(aside, np.array([-across, along])[axes]),
    )


def _goes_with(other: Places, body: Places) -> bool:
    """Whether a thing moves as a body makes it move: its shadow, mirror image or thread."""
    both = other.seen & body.seen
    if np.count_nonzero(both) < len(both) * GOES_WITH_SEEN:
        return False
    design = np.column_stack([body.xy_px[both], np.ones(np.count_nonzero(both))])
    solution, *_ = np.linalg.lstsq(design, other.xy_px[both], rcond=None)
    left_over = np.quantile(np.abs(other.xy_px[both] - design @ solution), 0.9, axis=0)
    return bool(left_over.max() <= GOES_WITH_SHARE * max(_travel(other), 1.0))


def _travel(body: Places) -> float:
    return float(np.ptp(body.xy_px[body.seen], axis=0).max())


def _jump_direction(xy_px: Floats) -> Floats:
    """Direction in which the velocity jumps, by the second differences; a unit vector.

    Over few pictures a jump stands out from a bent path most, over more from the noise: the first
    step is taken over which most of the differences agree in direction.
    """
    steps = [_jumps(xy_px, step) for step in DIRECTION_STEPS]
    agreeing = [_agreement(jumps) for jumps in steps]
    step = next((k for k, share in enumerate(agreeing) if share > AGREEING), np.argmax(agreeing))
    jumps = steps[int(step)]
    common = np.angle(jumps.sum()) / 2
    for _ in range(DIRECTION_ROUNDS):  # others than most have no say
        away = np.angle(jumps * np.exp(-2j * common)) / 2
        common = np.angle((jumps * np.exp(-((away / DIRECTION_SPREAD_RAD) ** 2))).sum()) / 2
    direction = np.array([np.cos(common), np.sin(common)])
    forward = direction[int(np.argmax(np.abs(direction)))]
    return np.asarray(direction * np.sign(forward))


def _jumps(xy_px: Floats, step: int) -> NDArray[np.complex128]:
    """Second differences over so many pictures, where all three show the body, shape (n,).

    They are complex numbers of twice the angle and square size: jumps there and back agree.
    """
    second = xy_px[2 * step :] - 2 * xy_px[step:-step] + xy_px[: -2 * step]
    known = second[np.isfinite(second).all(axis=1)]
    return np.asarray((known[:, 0] + 1j * known[:, 1]) ** 2)


def _agreement(jumps: NDArray[np.complex128]) -> float:
    """Share of jumps that agree in direction: 1 for a line, 0 for noise."""
    whole = float(np.abs(jumps).sum())
    return float(np.abs(jumps.sum())) / whole if whole > 0 else 0.0

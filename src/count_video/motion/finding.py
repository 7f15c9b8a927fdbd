r"""Which low points of the two gaps are collisions: one likelihood ratio for each.

The ball stands between two gaps, one to the wall and one to the heavy body. Each collision is a
low point of one of them, but so is each turn of a swing. All low points are fitted together as
contacts, each with a place of its own. What is none has no jump of the velocity, for the flights on
both sides may bend, or it lies where others are not. The least likely is left out, and the rest is
fitted anew, until all have a jump at the common place. Contacts come by turns, on one side and on
the other: where one is missing, the clearest corner there is a candidate too, however shallow.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from count_video.motion.batches import fit_contacts
from count_video.motion.gaps import Gaps
from count_video.motion.joint import ROUNDS, Contacts, Fitting
from count_video.motion.model import Paths
from count_video.motion.pieces import HALF_EXPOSURE
from count_video.motion.priors import (
    OUTLINE_PX,
    OUTLINE_SHARE,
    STRAY_SIGMAS,
    TIME_MOVES_FRAMES,
    TURN_LOG_RATIO,
)
from count_video.records import CollisionKind, Floats
from count_video.signals import depths, flight_of, low_points, sigma_of, weighted_median

KINDS: tuple[CollisionKind, ...] = ("wall", "bodies")
HYSTERESIS_SIGMAS = 6.0
"""Of 10 000 independent frames none strays from its neighbours by so much."""
SELECTION_ROUNDS = 2
SIGMA_AT_LEAST = 1e-6
LEAST_WEIGHT = 1e-9
OWN_PLACE_SIGMAS = 1e4
"""Contacts that share no place are free within so many standard deviations of a frame."""
PLACE_SIGMAS = 4.0
CORNER_ROWS, CORNERS_TRIED = 10, 400
"""Rows that show a corner at least, and about how many of them are tried at most."""


@dataclass(frozen=True)
class LowPoint:
    """A closing of a gap."""

    kind: CollisionKind
    lowest: float
    """Frame coordinate of its lowest sample."""
    frame: float
    """Best frame coordinate so far."""
    depth_px: float
    """How far the gap opens on the way to the next narrower one; inf where that is not asked."""


def low_points_of(gaps: Gaps) -> list[LowPoint]:
    """Low points of both gaps, in order of time."""
    found = []
    for kind in KINDS:
        signal = gaps.closing(kind)
        depth = HYSTERESIS_SIGMAS * sigma_of(signal)
        lows = low_points(signal, depth)
        places = zip(gaps.frame[lows].tolist(), depths(signal, lows).tolist(), strict=True)
        found += [LowPoint(kind, frame, frame, deep) for frame, deep in places]
    return sorted(found, key=lambda point: point.frame)


def find_contacts(gaps: Gaps, ball_diameter_px: float) -> Contacts:
    """Find the contacts of a clip of ball, heavy body and wall."""
    paths = Paths(gaps.frame, gaps.ball_px, gaps.heavy_px)
    tolerance = max(OUTLINE_PX, OUTLINE_SHARE * ball_diameter_px)
    how = Fitting(OWN_PLACE_SIGMAS, rounds=SELECTION_ROUNDS)
    points, how = _likely(paths, low_points_of(gaps), how, gaps, tolerance)
    missing = _missing(points, gaps)
    if missing:
        both = sorted([*points, *missing], key=lambda point: point.frame)
        points, how = _likely(paths, both, how, gaps, tolerance)
    how = replace(how, stray_sigmas=STRAY_SIGMAS)
    points, how = _likely(paths, points, how, gaps, tolerance)
    return _fit(paths, points, replace(how, rounds=ROUNDS, fitted=True))


def _likely(
    paths: Paths, points: list[LowPoint], how: Fitting, gaps: Gaps, tolerance_px: float
) -> tuple[list[LowPoint], Fitting]:
    """Leave out the least likely points until all are contacts; also how they are fitted then."""
    way = float(np.nanmax(gaps.ball_px) - np.nanmin(gaps.ball_px))
    while points:
        fitted = _fit(paths, points, how)
        how = replace(how, rounds=1, errors=fitted.errors)
        points = [replace(p, frame=float(f)) for p, f in zip(points, fitted.frame, strict=True)]
        worst = _shallow(fitted, points) or _worst(fitted, tolerance_px, way)
        worst = worst or _strayed(fitted, points, gaps)
        if not worst:
            break
        points = [point for n, point in enumerate(points) if n not in worst]
    return points, how


def _missing(points: Sequence[LowPoint], gaps: Gaps) -> list[LowPoint]:
    """Where contacts of one kind follow each other, the likeliest corner of the other gap between.

    The ball cannot come to one side twice but by a contact on the other, nor from rest to the wall.
    Such a contact may be no deeper than the noise. A kind that no contact shows, as where two balls
    meet far from any wall, is not missing.
    """
    found, shown = [], {point.kind for point in points}
    for before, after in zip([None, *points], points, strict=False):
        kind = KINDS[after.kind == "wall"]
        if kind in shown and after.kind == (before.kind if before else "wall"):
            low = before.frame if before else -np.inf
            corner = _corner(gaps.frame, gaps.closing(kind), low, after.frame)
            if corner is not None:
                found.append(LowPoint(kind, corner, corner, np.inf))
    return found


def _corner(frame: Floats, signal: Floats, low: float, high: float) -> float | None:
    """Frame between two others at which a signal most clearly turns from closing to opening.

    Before and after it obeys x'' = g - w^2 (x - x0), so that with a ramp for the jump it is linear
    in five unknowns. None where too few places are seen, or it does not turn there.
    """
    inside = (frame > low + HALF_EXPOSURE) & (frame < high - HALF_EXPOSURE)
    flight = flight_of(frame[inside], signal[inside])
    if flight is None or len(flight.clock) < CORNER_ROWS:
        return None
    time, place = flight.clock, flight.place_px
    law = np.column_stack([flight.own, flight.shared])
    basis, triangle = np.linalg.qr(law)
    tried = np.arange(1, len(time) - 1, 1 + len(time) // CORNERS_TRIED)
    ramps = np.maximum(time[:, None] - time[tried], 0.0)
    shared = basis.T @ ramps
    ramps -= basis @ shared
    squares = (ramps**2).sum(axis=0)
    clear = place @ ramps
    best = int(np.argmax(clear / np.sqrt(squares)))
    jump, row = clear[best] / squares[best], tried[best]
    free = np.linalg.solve(triangle, basis.T @ place - jump * shared[:, best])
    closing = np.gradient(law @ free, time)[row]
    return float(time[row]) if closing < 0 < closing + jump else None


def _fit(paths: Paths, points: Sequence[LowPoint], how: Fitting) -> Contacts:
    return fit_contacts(paths, [p.kind for p in points], [p.frame for p in points], how)


def jumps_of(fitted: Contacts) -> tuple[Floats, Floats]:
    """Jump of the opening velocity and its standard uncertainty; NaN where not shown."""
    ball = fitted.bodies[0]
    outward = np.where([kind == "far" for kind in fitted.kinds], -1.0, 1.0)
    jump, variance = outward * ball.jump, ball.jump_sigma**2
    for body in fitted.bodies[1:]:
        touching = np.array([kind == "bodies" for kind in fitted.kinds])
        jump = np.where(touching, body.jump - jump, jump)
        variance = np.where(touching, variance + body.jump_sigma**2, variance)
    return jump, np.sqrt(variance)


def smoothness_of(fitted: Contacts) -> Floats:
    """Logarithm of the likelihood ratio of no jump against one; 0 where none is shown.

    Jumps are expected to be as large as the largest speeds of the ball, against which their
    uncertainty is a share: what is not measured speaks for neither.
    """
    jump, sigma = jumps_of(fitted)
    speed = float(np.nanmax(np.abs(fitted.bodies[0].rate), initial=0.0))
    ratio = 1 + (speed / np.maximum(sigma, SIGMA_AT_LEAST)) ** 2
    clear = np.maximum(jump, 0.0) / np.maximum(sigma, SIGMA_AT_LEAST)
    return np.nan_to_num(np.log(ratio) / 2 - clear**2 / 2 * (1 - 1 / ratio))


def _shallow(fitted: Contacts, points: Sequence[LowPoint]) -> list[int]:
    """Low points no deeper than the errors of places make, those included that last for frames."""
    least = {kind: HYSTERESIS_SIGMAS * _gap_noise_px(fitted, kind) for kind in KINDS}
    return [n for n, point in enumerate(points) if point.depth_px < least[point.kind]]


def _worst(fitted: Contacts, tolerance_px: float, way_px: float) -> list[int]:
    """Contacts that are none, each less likely one than its neighbours; empty if all of them are.

    Turns are taken out before what jumps elsewhere, which they may have misled.
    """
    smooth = smoothness_of(fitted)
    turns = smooth - _at_place(fitted, smooth < 0, tolerance_px, way_px) - TURN_LOG_RATIO
    if turns.max() > 0:
        return peaks(turns)
    jump, sigma = jumps_of(fitted)
    away = np.zeros(len(jump))
    for kind in set(fitted.kinds):
        own = np.array([one == kind for one in fitted.kinds])
        level = weighted_median(
            fitted.stray_px[own], np.maximum(np.nan_to_num(jump / sigma)[own], LEAST_WEIGHT)
        )
        allowed = tolerance_px + PLACE_SIGMAS * fitted.stray_sigma[own]
        away[own] = np.abs(fitted.stray_px[own] - level) / allowed - 1
    return peaks(away)


def _at_place(
    fitted: Contacts, jumps: NDArray[np.bool_], tolerance_px: float, way_px: float
) -> Floats:
    """Logarithm of the likelihood ratio of a contact against a turn by where it lies.

    Contacts of a kind lie where the others do that have a jump, within the tolerance. A turn may
    lie anywhere on the ball's way, and so may a contact that the fit has misplaced.
    """
    kinds, found = np.array(fitted.kinds), np.zeros(len(fitted.kinds))
    density = way_px / (tolerance_px * np.sqrt(2 * np.pi))
    for number, kind in enumerate(fitted.kinds):
        others = jumps & (kinds == kind)
        others[number] = False
        if others.any():
            away = fitted.stray_px[number] - np.median(fitted.stray_px[others])
            found[number] = np.log1p(density * np.exp(-((away / tolerance_px) ** 2) / 2))
    return found


def _strayed(fitted: Contacts, points: Sequence[LowPoint], gaps: Gaps) -> list[int]:
    """Contacts that lie farther from their lowest sample than the steps next to it, or the noise.

    So it is where pictures in between do not show the body: what happened there is not seen. Noise
    moves the lowest sample the more, the more slowly the gap opens or closes.
    """
    lowest = np.array([point.lowest for point in points])
    place = np.searchsorted(gaps.frame, lowest)
    steps = np.diff(gaps.frame, prepend=gaps.frame[0], append=gaps.frame[-1])
    longest = np.maximum(np.maximum(steps[place], steps[place + 1]), 1.0)
    noise = np.array([_gap_noise_px(fitted, point.kind) for point in points])
    sigma = np.hypot(fitted.frame_sigma, noise / _slowest(fitted))
    allowed = TIME_MOVES_FRAMES * longest + PLACE_SIGMAS * sigma
    return peaks(np.abs(fitted.frame - lowest) / allowed - 1)


def _gap_noise_px(fitted: Contacts, kind: CollisionKind) -> float:
    """Estimate the standard deviation of one sample of a gap."""
    errors = fitted.errors if kind == "bodies" else fitted.errors[:1]
    known = [one.sigma_px for one in errors if one is not None]
    return float(np.linalg.norm(known))


def _slowest(fitted: Contacts) -> Floats:
    """How fast the gap of each contact closes or opens, the slower of both; inf where not shown."""
    ball, heavy = (body.rate for body in fitted.bodies)
    touching = np.array([kind == "bodies" for kind in fitted.kinds])
    speed = np.abs(np.where(touching[:, None], heavy - ball, ball))
    slowest = np.minimum(speed[:, 0], speed[:, 1])
    shown = np.maximum(slowest, SIGMA_AT_LEAST)
    return np.asarray(np.where(np.isfinite(slowest), shown, np.inf))


def peaks(values: Floats, above: float = 0.0) -> list[int]:
    """List the values above a level that are above both neighbours as well."""
    padded = np.concatenate([[-np.inf], values, [-np.inf]])
    highest = (values > padded[:-2]) & (values >= padded[2:]) & (values > above)
    return [int(index) for index in np.flatnonzero(highest)]

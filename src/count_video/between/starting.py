"""Where the fit may start: what the calm frames tell.

The heavy body's approach, the ball's place at rest, the wall and the contact are read off. The
lightness of the ball follows roughly from how near the heavy body comes to the wall: with d the
ball's way between the two and V its speed, V d stays the same while both change slowly, and at the
turn the ball has all the energy that the threads leave, m V^2 = M (v^2 - w^2 (L - d)^2). At first d
is the ball's way L to the wall and V is 2 v, of which half is the heavy body's own, so that V d is
v L.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from count_video.between.observations import Observations
from count_video.between.parameters import FIRST_DEVIATION, Column
from count_video.motion.swing import Swing
from count_video.records import Collision, Floats

CLEAR_FRAMES = 0.6
"""Frames nearer to a collision may hold it in their exposure."""
CALM_FRAMES = 3.0
"""Flights this long on both sides show where a contact is."""
CALM_CONTACTS = 4
"""Fewer do not tell a trend."""
PARALLAX_AT_MOST = 0.15
NEAREST_SHARE = 0.003
"""No clip shows the heavy body nearer to the wall than by this share of the ball's way."""
SWUNG_AT_MOST = 0.8
"""Share of the energy that the threads may take up before the turn."""
RATES = (5e-4, 0.1)
"""Angular rates in radians per frame that threads and cameras bring about."""
RATE_SIGMAS = 2.0
"""Threads that would bend the heavy body's whole path by more than this beyond what it shows are
ruled out."""
RATE_UNKNOWN = 4e-3
RATE_FACTOR = 1.5
"""Threads are hardly twice as long or half as long as usual."""
RESTITUTION_UNKNOWN = 0.96
RESTITUTION_AT_LEAST = 0.7


def rough_values(
    observed: Observations,
    burst: Sequence[Collision],
    expected_rate: float | None,
    swing: Swing | None = None,
) -> Floats:
    """Read the parameters off the calm frames; shape (columns without deviations,).

    ``expected_rate`` is the angular rate of usual threads in radians per frame, if it can be said;
    ``swing`` what the heavy body's path through the burst tells, if it does.
    """
    values = np.zeros(FIRST_DEVIATION)
    before = observed.frame < -CLEAR_FRAMES
    wall = _wall_place(observed, burst)
    rest = float(np.nanmedian(observed.ball_px[before]))
    rate = _swing_rate(observed, expected_rate, swing)
    place, velocity = _approach(observed.frame[before], observed.heavy_px[before] - rest, rate)
    values[Column.BALL_REST] = values[Column.HEAVY] = rest
    values[Column.WALL] = wall
    values[Column.CONTACT] = place
    values[Column.HEAVY_RATE] = velocity
    values[Column.SWING] = np.log(rate)
    parallax = values[Column.PARALLAX] = _parallax(observed, burst)
    nearest = (float(np.nanmin(observed.heavy_px)) - place - rest) / (1 + parallax) + rest - wall
    way = max(rest - wall, 1e-9)
    share = np.clip(nearest / way, NEAREST_SHARE, 1.0)
    swung = (rate * (way - share * way) / velocity) ** 2 if velocity else 0.0
    values[Column.LIGHTNESS] = 2 * np.log(share) + np.log1p(-min(swung, SWUNG_AT_MOST))
    values[Column.EXPOSURE] = 0.5
    calm = calm_ones(burst)
    values[Column.BODIES] = _restitution([c for c in calm if c.kind == "bodies"])
    values[Column.BOUNCE] = _restitution([c for c in calm if c.kind == "wall"])
    return values


def calm_ones(burst: Sequence[Collision]) -> list[Collision]:
    """Select the collisions with flights on both sides that are long enough to be measured."""
    frames = [-np.inf, *(collision.frame for collision in burst), np.inf]
    return [
        collision
        for place, collision in enumerate(burst)
        if min(collision.frame - frames[place], frames[place + 2] - collision.frame) > CALM_FRAMES
    ]


def _restitution(calm: Sequence[Collision]) -> float:
    """Restitution from calm collisions of one kind, the median by closing speed."""
    ratios = []
    for collision in calm:
        before, after = collision.velocity_before, collision.velocity_after
        wall = collision.kind == "wall"
        closing = before.ball_px_frame - (0.0 if wall else before.heavy_px_frame)
        parting = after.ball_px_frame - (0.0 if wall else after.heavy_px_frame)
        if np.isfinite(closing) and np.isfinite(parting) and closing:
            ratios.append(-parting / closing)
    if not ratios:
        return RESTITUTION_UNKNOWN
    return float(np.clip(np.median(ratios), RESTITUTION_AT_LEAST, 1.0))


def _wall_place(observed: Observations, burst: Sequence[Collision]) -> float:
    """Median of the places at wall contacts whose flights are long enough to show them."""
    calm = [observed.sign * c.position_px for c in calm_ones(burst) if c.kind == "wall"]
    return float(np.median(calm)) if calm else float(np.nanmin(observed.ball_px))


def _parallax(observed: Observations, burst: Sequence[Collision]) -> float:
    """Change of the outlines' gap in contact with the distance; 0 where few contacts tell it."""
    contacts = [c for c in calm_ones(burst) if c.kind == "bodies"]
    calm = [(observed.sign * c.position_px, c.frame - observed.origin) for c in contacts]
    if len(calm) < CALM_CONTACTS:
        return 0.0
    ball, frame = np.array(calm).T
    seen = np.isfinite(observed.heavy_px)
    heavy = np.interp(frame, observed.frame[seen], observed.heavy_px[seen])
    first, second = np.triu_indices(len(ball), 1)
    run, rise = ball[first] - ball[second], (heavy - ball)[first] - (heavy - ball)[second]
    far = np.abs(run) > 0.2 * np.ptp(ball)
    return float(np.clip(np.median(rise[far] / run[far]), -PARALLAX_AT_MOST, PARALLAX_AT_MOST))


def _approach(frame: Floats, heavy: Floats, rate: float) -> tuple[float, float]:
    """Place and velocity of the heavy body at time 0, from its swing about 0 before."""
    seen = np.isfinite(heavy)
    if seen.sum() < 2:
        return float(np.nanmedian(heavy)), 0.0
    design = np.column_stack([np.cos(rate * frame), np.sin(rate * frame) / rate])
    solution, *_ = np.linalg.lstsq(design[seen], heavy[seen], rcond=None)
    return float(solution[0]), float(solution[1])


def _swing_rate(observed: Observations, expected: float | None, swing: Swing | None) -> float:
    """Angular rate of the heavy body's pendulum, from its free path before and after the burst.

    x(t) = a + b t - w^2 (second integral of x), with a and b of their own on each side. A short
    path leaves w^2 open by more than its value; the long one through the burst bounds it.
    """
    seen = np.isfinite(observed.heavy_px)
    contact = float(np.interp(0.0, observed.frame[seen], observed.heavy_px[seen]))
    columns, places = [], []
    sides = (observed.frame < -CLEAR_FRAMES, observed.frame > observed.last + CLEAR_FRAMES)
    for number, side in enumerate(sides):
        chosen = side & seen
        if chosen.sum() < 8:
            continue
        frame = observed.frame[chosen]
        offset = observed.heavy_px[chosen] - contact
        clock = frame - frame[0]
        once = np.concatenate([[0], np.cumsum(np.diff(frame) * (offset[1:] + offset[:-1]) / 2)])
        twice = np.concatenate([[0], np.cumsum(np.diff(frame) * (once[1:] + once[:-1]) / 2)])
        free = np.zeros((len(frame), 4))
        free[:, 2 * number], free[:, 2 * number + 1] = 1.0, clock
        columns.append(np.column_stack([free, -twice]))
        places.append(offset)
    if not columns:
        return RATE_UNKNOWN if expected is None else expected
    solution, *_ = np.linalg.lstsq(np.vstack(columns), np.concatenate(places), rcond=None)
    low, high = RATES if expected is None else (expected / RATE_FACTOR, expected * RATE_FACTOR)
    if swing is not None and expected is None:
        most = max(swing.rate_squared, 0.0) + RATE_SIGMAS * swing.rate_squared_sigma
        high = max(low, min(high, float(np.sqrt(most))))
    return float(np.sqrt(np.clip(solution[-1], low**2, high**2)))

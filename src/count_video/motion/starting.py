"""Where the fit may start: what the calm frames tell.

The heavy body's approach, the ball's place at rest, the wall and the contact are read off. The
lightness of the ball follows roughly from how near the heavy body comes to the wall: with d the
ball's way between the two and V its speed, V d stays the same while both change slowly, and at the
turn the ball has all the energy that the threads leave, m V^2 = M (v^2 - w^2 (L - d)^2). At first d
is the ball's way L to the wall and V is 2 v, of which half is the heavy body's own, so that V d is
v L.

What they do not tell, lightness and restitution and so the count, is scanned. Many sets of
parameters are followed at once and compared with a few frames; what is far from all of them is as
bad as what is far from one. The best places of each count are where fits may start.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from count_video.motion.exposures import sample
from count_video.motion.observations import Observations, at_rows
from count_video.motion.parameters import FIRST_DEVIATION, Column, Prior, within_limits
from count_video.motion.priors import CLEAR_FRAMES
from count_video.motion.solving import modelled
from count_video.motion.swing import Swing
from count_video.records import Collision, Floats

CALM_FRAMES = 3.0
"""Flights this long on both sides show where a contact is."""
BEYOND_SHARE = 0.02
"""Share of the places that may be wrong."""
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
    values[Column.LIGHTNESS] = _lightness(nearest, max(rest - wall, 1e-9), rate, velocity)
    values[Column.EXPOSURE] = 0.5
    calm = calm_ones(burst)
    values[Column.BODIES] = _restitution([c for c in calm if c.kind == "bodies"])
    values[Column.BOUNCE] = _restitution([c for c in calm if c.kind == "wall"])
    return values


def _lightness(nearest: float, way: float, rate: float, velocity: float) -> float:
    """Logarithm of the lightness by how near the heavy body comes to the wall, in px."""
    share = np.clip(nearest / way, NEAREST_SHARE, 1.0)
    swung = (rate * (way - share * way) / velocity) ** 2 if velocity else 0.0
    return float(2 * np.log(share) + np.log1p(-min(swung, SWUNG_AT_MOST)))


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
    """Median of the places at wall contacts whose flights are long enough to show them.

    The ball is never beyond the wall: a contact at which it seems to be before it was none.
    """
    calm = [observed.sign * c.position_px for c in calm_ones(burst) if c.kind == "wall"]
    if not calm:
        return float(np.nanmin(observed.ball_px))
    return float(min(np.median(calm), np.nanquantile(observed.ball_px, BEYOND_SHARE)))


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


LIGHTNESS_SPAN = (-0.35, 1.1)
"""The scan reaches so far from the rough value, in its logarithm: losses let the heavy body come
nearer, so that the ball looks lighter than it is. In long bursts it comes so near that the rough
value says little, and the scan reaches further."""
STEPS_AT_MOST = 121
PHASE_STEP = 0.25
"""Collisions by which neighbours of the scan differ at most through their lightness."""
RESTITUTIONS = np.linspace(-0.03, 0.03, 7)
"""Added to the rough restitution of both contacts."""
ASYMMETRIES = (-0.02, 0.0, 0.02)
"""Added to that of the bodies and taken from that of the wall."""
SKIPS = (0.0, 1.0, 2.0, 3.0, 4.5, 6.0, 8.0, 10.0, 12.5, 15.0, 18.0, 22.0)
"""Frames that may be left out, where that is in question."""
MOST_COLLISIONS = 600
"""More are not looked for: no track tells them from one another."""
LIGHTEST = float(np.log(2.0))
"""Logarithm of the greatest lightness: a heavy body of half the ball's mass."""
LONG_BURST = 60
"""With more collisions the same loss of energy is a smaller one at each: the steps shrink."""
SETS_AT_ONCE = 512
"""So many are followed together: all at once would take too much memory."""
SCAN_FRAMES = 60
SCAN_FLOOR_PX = 2.0
"""At first anything nearer than this is as good."""


def scan(observed: Observations, rough: Floats, prior: Prior) -> Floats:
    """Scan lightness and restitution; the sets by rising loss, shape (sets, columns).

    The last column is the number of collisions until the last frame.
    """
    steps = _lightness_steps(rough, prior)
    finer = min(1.0, LONG_BURST / expected_count(float(np.median(steps))))
    grid = np.meshgrid(steps, finer * RESTITUTIONS, finer * np.array(ASYMMETRIES))
    lightness, restitution, asymmetry = (axis.ravel() for axis in grid)
    sets = np.repeat(rough[None], len(lightness), axis=0)
    sets[:, Column.LIGHTNESS] = lightness
    # Above 1 neither restitution can lie; the fit may stray there, its start should not.
    sets[:, Column.BODIES] = np.minimum(rough[Column.BODIES] + restitution + asymmetry, 1.0)
    sets[:, Column.BOUNCE] = np.minimum(rough[Column.BOUNCE] + restitution - asymmetry, 1.0)
    sets = within_limits(sets)
    most = round(1.5 * expected_count(float(steps.min()))) + 4
    skips = SKIPS if prior.sigma[Column.SKIP] else SKIPS[:1]
    parts = np.array_split(sets, _parts(len(sets)))
    rows = np.concatenate([_scanned(observed, part, most, skips) for part in parts])
    return np.asarray(rows[np.argsort(rows[:, -1])])


def expected_count(lightness: float) -> float:
    """Tell the number of collisions of free bodies, for the logarithm of the lightness."""
    return float(np.pi / np.exp(lightness / 2))


def lightness_of(count: int) -> float:
    """Logarithm of the lightness of free bodies that collide so often."""
    return float(2 * np.log(np.pi / count))


def _parts(sets: int) -> int:
    return -(-sets // SETS_AT_ONCE)


def _scanned(observed: Observations, sets: Floats, most: int, skips: Sequence[float]) -> Floats:
    """Give the sets with their numbers of collisions and their losses in two more columns."""
    thin = _thinned(observed)
    paths, _ = modelled(thin, sets, most)
    found = []
    for skip in skips:
        skipped = sets.copy()
        skipped[:, Column.SKIP] += skip
        times = observed.times(skipped)[:, -1:]
        with np.errstate(invalid="ignore", over="ignore"):
            sampled = sample(paths, skipped, thin.times(skipped))
            loss = _capped(sampled.ball - thin.ball_px) + _capped(sampled.heavy - thin.heavy_px)
        counts = (paths.time[:, 1:] <= times).sum(axis=1)
        found.append(np.column_stack([skipped, counts, loss]))
    return np.concatenate(found)


def _lightness_steps(rough: Floats, prior: Prior) -> Floats:
    low, high = rough[Column.LIGHTNESS] + np.array(LIGHTNESS_SPAN)
    high += max(0.0, np.log(expected_count(float(rough[Column.LIGHTNESS])) / LONG_BURST))
    # The frame nearest to the wall may show the ball half of its way in a frame off it.
    near = np.exp(rough[Column.LIGHTNESS] / 2) * (rough[Column.BALL_REST] - rough[Column.WALL])
    high += 2 * np.log1p(abs(rough[Column.HEAVY_RATE]) / max(near, 1e-9))
    high = min(high, LIGHTEST)
    low = max(low, lightness_of(MOST_COLLISIONS))
    if np.isfinite(prior.sigma[Column.LIGHTNESS]):
        reach = 3 * prior.sigma[Column.LIGHTNESS]
        low, high = prior.mean[Column.LIGHTNESS] + np.array([-reach, reach])
    # N is about pi sqrt(M/m): its logarithm moves half as much as that of the lightness.
    number = 2 + int(np.ceil((high - low) * expected_count(low) / 2 / PHASE_STEP))
    return np.linspace(low, high, min(number, STEPS_AT_MOST))


def _thinned(observed: Observations) -> Observations:
    keep = np.unique(np.linspace(0, len(observed.frame) - 1, SCAN_FRAMES).round().astype(int))
    return at_rows(observed, keep)


def _capped(residuals: Floats) -> Floats:
    squares = (residuals / SCAN_FLOOR_PX) ** 2
    finite = np.where(np.isfinite(squares), squares, 1e6)
    return np.asarray(np.log1p(finite).sum(axis=1))

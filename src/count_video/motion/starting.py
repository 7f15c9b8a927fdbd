"""Where the fit may start: what the calm frames show.

The heavy body's swing, the ball's place at rest and the wall are read off. The lightness of the
ball follows roughly from how near the heavy body comes to the wall: with d the ball's way between
the two and V its speed, V d stays the same while both change slowly, and at the turn the ball has
all the energy, m V^2 = M v^2. At first d is the way L to the wall and V is 2 v, of which half
is the heavy body's own, so that V d is v L.

What they do not show, lightness and restitution and so the count, is scanned. Many sets of
parameters are followed at once and compared with a few frames; what is far from all of them is as
bad as what is far from one. The best of them is where the search of the count begins.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from count_video.motion.exposures import sample
from count_video.motion.observations import Observations, thinned
from count_video.motion.parameters import (
    FIRST_DEVIATION,
    LIMITS,
    Column,
    Knowledge,
    Prior,
    within_limits,
)
from count_video.motion.pendulums import follow
from count_video.motion.priors import CLEAR_FRAMES, DAMPING, EXPOSURE, PULL_SHARE, RESTITUTION
from count_video.motion.seen import SeenCollisions
from count_video.motion.swing import Swing
from count_video.records import Floats

BEYOND_SHARE = 0.02
"""Share of the places that may be wrong."""
NEAREST_SHARE = 0.003
"""No clip shows the heavy body nearer to the wall than by this share of the ball's way."""
RATE_STEPS = np.linspace(-3.0, 3.0, 49)
"""Angular rates that are tried, in standard deviations of what is known of its logarithm."""
SWING_FLOOR_PX = 0.5
"""Places of the heavy body that err together stray from its swing by so much."""


def rough_values(observed: Observations, found: SeenCollisions, known: Knowledge) -> Floats:
    """Read the parameters off the calm frames; shape (columns without deviations,)."""
    values = np.zeros(FIRST_DEVIATION)
    rest = float(np.nanmedian(observed.ball_px[observed.frame < -CLEAR_FRAMES]))
    wall = float(np.nanquantile(observed.ball_px, BEYOND_SHARE))
    way = max(rest - wall, 1e-9)
    values[Column.BALL_REST] = values[Column.HEAVY] = rest
    values[Column.WALL] = wall
    values[Column.EXPOSURE] = EXPOSURE[0]
    values[Column.DAMPING] = DAMPING[0]
    values[[Column.BODIES, Column.BOUNCE]] = RESTITUTION[0]
    if observed.shows_heavy:
        rate, place, velocity = _swinging(observed, rest, way, known, found.swing)
        lightness = _lightness(float(np.nanmin(observed.heavy_px)) - place - wall, way)
        values[Column.CONTACT] = place
    else:
        # It is where the ball turns back, and gives the ball at rest V (1 + e) / (1 + m/M).
        rate = known.rate[0]
        lightness = _lightness(_nearest_turn(observed, found, rest) - wall, way)
        velocity = _given(observed, rest, rate) * (1 + np.exp(lightness)) / (1 + RESTITUTION[0])
    values[Column.HEAVY_RATE] = velocity
    values[Column.SWING] = np.log(rate)
    values[Column.LIGHTNESS] = lightness
    swing = found.swing
    if found.is_whole and swing is not None and swing.is_clear:
        values[Column.LIGHTNESS] = -np.log(swing.mass_ratio)
    return values


def _lightness(nearest_px: float, way_px: float) -> float:
    """Logarithm of the ball's lightness, by how near the heavy body comes to the wall."""
    return float(2 * np.log(np.clip(nearest_px / way_px, NEAREST_SHARE, 1.0)))


def _nearest_turn(observed: Observations, found: SeenCollisions, rest: float) -> float:
    """Place nearest to the wall from which the ball is driven back to it, or else its rest."""
    walls = [one.frame for one in found.collisions[: found.burst] if one.kind == "wall"]
    frame, place = observed.origin + observed.frame, observed.ball_px
    visits = ((frame > low) & (frame < high) & np.isfinite(place) for low, high in pairwise(walls))
    return min((float(place[rows].max()) for rows in visits if rows.any()), default=rest)


def _given(observed: Observations, rest: float, rate: float) -> float:
    """Velocity that the first blow gives the ball, by the angular rate of its pendulum.

    Until the next collision it swings from its rest, x = v sin(w t) / w.
    """
    frame, place = observed.frame, observed.ball_px - rest
    until = observed.burst[1] if len(observed.burst) > 1 else np.inf
    first = np.isfinite(place) & (frame > CLEAR_FRAMES) & (frame < until - CLEAR_FRAMES)
    frame, place = frame[first], place[first]
    swung = np.sin(rate * frame) / rate
    return float(swung @ place) / max(float(swung @ swung), 1e-9)


def _swinging(
    observed: Observations, rest: float, way: float, known: Knowledge, swing: Swing | None
) -> tuple[float, float, float]:
    """Angular rate of the heavy body, and its place from the ball's rest and velocity at time 0.

    It swings freely before the burst and again after it. For a given rate both paths are linear in
    two unknowns each and the place where it hangs, of which the prior says that it is near the
    ball's. The rate is that with the least loss, its own prior and ``swing`` included.
    """
    frame, place = observed.frame, observed.heavy_px - rest
    seen = np.isfinite(place)
    before = np.flatnonzero(seen & (frame < -CLEAR_FRAMES))
    after = np.flatnonzero(seen & (frame > observed.burst[-1] + CLEAR_FRAMES))
    first, later = slice(0, len(before)), slice(len(before), -1)
    place = np.concatenate([place[before], place[after], [0.0]])
    usual, unsure = known.rate
    noise_px = max(float(observed.sigma_px[1]), SWING_FLOOR_PX)
    best = np.inf, usual, 0.0, 0.0
    for step in RATE_STEPS:
        rate = usual * float(np.exp(unsure * step))
        free = np.column_stack([np.cos(rate * frame), np.sin(rate * frame) / rate])
        design = np.zeros((len(place), 5))
        design[first, :2], design[later, 2:4] = free[before], free[after]
        # Where it hangs moves the first path only away from time 0.
        design[first, 4], design[later, 4] = 1 - free[before, 0], 1.0
        design[-1, 4] = noise_px / (PULL_SHARE * way)
        solution, *_ = np.linalg.lstsq(design, place, rcond=None)
        left = (place - design @ solution) / noise_px
        loss = float(left @ left + step**2)
        if swing is not None and swing.rate_squared_sigma > 0:
            loss += ((rate**2 - swing.rate_squared) / swing.rate_squared_sigma) ** 2
        best = min(best, (loss, rate, float(solution[0]), float(solution[1])))
    return best[1:]


LIGHTNESS_SPAN = (-0.35, 1.1)
"""The scan reaches so far from the rough value, in its logarithm: losses let the heavy body come
nearer, so that the ball seems lighter than it is. In long bursts it comes so near that the rough
value says little, and the scan reaches further."""
STEPS_AT_MOST = 81
PHASE_STEP = 0.5
"""Collisions by which neighbours of the scan differ at most through their lightness."""
RESTITUTIONS = np.linspace(-0.03, 0.03, 5)
"""Added to the rough restitution of both contacts."""
MOST_COLLISIONS = 600
"""More are not sought: no track distinguishes them."""
LONG_BURST = 60
"""With more collisions the same loss of energy is a smaller one at each: the steps shrink."""
LONGEST_STEP = 4
"""Two numbers of collisions that differ by less than this part of them are neighbours."""
SCANNED = 3
"""So many of a scan are fitted, none the neighbour of another one."""
SCAN_FRAMES = 60
SCAN_FLOOR_PX = 2.0
"""At first anything nearer than this is as good, ..."""
SCAN_FLOOR_FRAMES = 1.0
"""... and any time of a calm collision."""


def scan(observed: Observations, rough: Floats, prior: Prior) -> list[tuple[int, Floats]]:
    """Scan lightness and restitution for counts; those with the least losses.

    Each comes with its set, shape (columns,), the best one first. None is another's neighbour: far
    from the solution the losses of neighbours are alike, and one of them is enough to search from.
    """
    steps = _lightness_steps(rough, prior)
    finer = min(1.0, LONG_BURST / expected_count(float(np.median(steps))))
    grid = np.meshgrid(steps, finer * RESTITUTIONS)
    lightness, restitution = (axis.ravel() for axis in grid)
    sets = np.repeat(rough[None], len(lightness), axis=0)
    sets[:, Column.LIGHTNESS] = lightness
    # Above 1 neither restitution can lie; the fit may stray there, its start should not.
    sets[:, Column.BODIES] = np.minimum(rough[Column.BODIES] + restitution, 1.0)
    sets[:, Column.BOUNCE] = np.minimum(rough[Column.BOUNCE] + restitution, 1.0)
    sets = within_limits(sets)
    expected = min(expected_count(float(steps.min())), MOST_COLLISIONS)
    longest = max(observed.calm, round(1.5 * expected) + 4)
    thin = observed.at(thinned(len(observed.frame), SCAN_FRAMES))
    counts, losses = _scanned(thin, sets, longest)
    losses[(counts < 1) | (counts > MOST_COLLISIONS)] = np.inf
    found: list[tuple[int, Floats]] = []
    while len(found) < SCANNED and np.isfinite(losses).any():
        best = int(np.argmin(losses))
        count = int(counts[best])
        found.append((count, sets[best]))
        losses[np.abs(counts - count) * LONGEST_STEP <= count] = np.inf
    return found or [(1, sets[0])]


def expected_count(lightness: float) -> float:
    """Return the number of collisions of free bodies, for the logarithm of the lightness."""
    return float(np.pi / np.exp(lightness / 2))


def _scanned(observed: Observations, sets: Floats, most: int) -> tuple[NDArray[np.intp], Floats]:
    """Give the numbers of collisions until the last frame, and the losses; shape (sets,) each."""
    paths, frame = follow(sets, most, observed.start), observed.times(sets)
    with np.errstate(invalid="ignore", over="ignore"):
        sampled = sample(paths, sets, frame)
        loss = _capped((sampled.ball - observed.ball_px) / SCAN_FLOOR_PX)
        loss += _capped((sampled.heavy - observed.heavy_px) / SCAN_FLOOR_PX)
        calm = paths.time[:, 1 : 1 + observed.calm] - observed.burst[: observed.calm]
        loss += _capped(calm / SCAN_FLOOR_FRAMES)
    counts = (paths.time[:, 1:] <= frame[:, -1:]).sum(axis=1)
    return counts, loss


def _lightness_steps(rough: Floats, prior: Prior) -> Floats:
    low, high = rough[Column.LIGHTNESS] + np.array(LIGHTNESS_SPAN)
    high += max(0.0, np.log(expected_count(float(rough[Column.LIGHTNESS])) / LONG_BURST))
    # The frame nearest to the wall may show the ball half of its way in a frame off it.
    near = np.exp(rough[Column.LIGHTNESS] / 2) * (rough[Column.BALL_REST] - rough[Column.WALL])
    high += 2 * np.log1p(abs(rough[Column.HEAVY_RATE]) / max(near, 1e-9))
    high = min(high, LIMITS[Column.LIGHTNESS][1])
    low = max(low, 2 * np.log(np.pi / MOST_COLLISIONS))
    reach = 3 * prior.sigma[Column.LIGHTNESS]
    if 2 * reach < high - low:
        low, high = prior.mean[Column.LIGHTNESS] + np.array([-reach, reach])
    # N is about pi sqrt(M/m): its logarithm moves half as much as that of the lightness.
    number = 2 + int(np.ceil((high - low) * expected_count(low) / 2 / PHASE_STEP))
    return np.linspace(low, high, min(number, STEPS_AT_MOST))


def _capped(residuals: Floats) -> Floats:
    squares = residuals**2
    finite = np.where(np.isfinite(squares), squares, 1e6)
    return np.asarray(np.log1p(finite).sum(axis=1))

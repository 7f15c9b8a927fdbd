"""A scan over what the calm frames do not tell: lightness and restitution, and so the count.

Many sets of parameters are followed at once and compared with a few frames; what is far from all
of them is as bad as what is far from one. The best places of each count are where fits may start.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from count_video.between.observations import Observations
from count_video.between.parameters import Column, Prior, within_limits
from count_video.between.solving import modelled
from count_video.records import Floats

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
MOST_COLLISIONS = 600
"""More are not looked for: no track tells them from one another."""
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
    rows = np.concatenate(
        [_scanned(observed, part, most) for part in np.array_split(sets, _parts(len(sets)))]
    )
    return np.asarray(rows[np.argsort(rows[:, -1])])


def expected_count(lightness: float) -> float:
    """Tell the number of collisions of free bodies, for the logarithm of the lightness."""
    return float(np.pi / np.exp(lightness / 2))


def lightness_of(count: int) -> float:
    """Logarithm of the lightness of free bodies that collide so often."""
    return float(2 * np.log(np.pi / count))


def _parts(sets: int) -> int:
    return -(-sets // SETS_AT_ONCE)


def _scanned(observed: Observations, sets: Floats, most: int) -> Floats:
    """Give the sets with their numbers of collisions and their losses in two more columns."""
    thin = _thinned(observed)
    paths, sampled = modelled(thin, sets, most)
    with np.errstate(invalid="ignore"):
        loss = _capped(sampled.ball - thin.ball_px) + _capped(sampled.heavy - thin.heavy_px)
    counts = (paths.time[:, 1:] <= observed.frame[-1]).sum(axis=1)
    return np.column_stack([sets, counts, loss])


def _lightness_steps(rough: Floats, prior: Prior) -> Floats:
    low, high = rough[Column.LIGHTNESS] + np.array(LIGHTNESS_SPAN)
    high += max(0.0, np.log(expected_count(float(rough[Column.LIGHTNESS])) / LONG_BURST))
    low = max(low, lightness_of(MOST_COLLISIONS))
    if np.isfinite(prior.sigma[Column.LIGHTNESS]):
        reach = 3 * prior.sigma[Column.LIGHTNESS]
        low, high = prior.mean[Column.LIGHTNESS] + np.array([-reach, reach])
    # N is about pi sqrt(M/m): its logarithm moves half as much as that of the lightness.
    number = 2 + int(np.ceil((high - low) * expected_count(low) / 2 / PHASE_STEP))
    return np.linspace(low, high, min(number, STEPS_AT_MOST))


def _thinned(observed: Observations) -> Observations:
    keep = np.unique(np.linspace(0, len(observed.frame) - 1, SCAN_FRAMES).round().astype(int))
    return replace(
        observed,
        frame=observed.frame[keep],
        ball_px=observed.ball_px[keep],
        heavy_px=observed.heavy_px[keep],
        drift=observed.drift[keep],
    )


def _capped(residuals: Floats) -> Floats:
    squares = (residuals / SCAN_FLOOR_PX) ** 2
    finite = np.where(np.isfinite(squares), squares, 1e6)
    return np.asarray(np.log1p(finite).sum(axis=1))

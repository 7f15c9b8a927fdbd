"""Rival counts: each number of collisions gets its own best fit, and its share of probability.

The evidence for a count is its likelihood integrated over all parameters (Laplace's approximation
about the best fit), so that a count that needs unlikely scatter of the restitution pays for it.

A burst is fitted from its beginning on: the first few collisions, then more and more of them. Where
the first collisions are seen, they give wall, contact and losses well enough to foresee the next
few, and these give them better. So no fit ever starts more than a small part of a collision from
where it ends, and nothing has to be searched for.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from count_video.motion.observations import Observations, until
from count_video.motion.parameters import (
    FIRST_DEVIATION,
    FIRST_DRIFT,
    Column,
    Prior,
    deviation_places,
    deviations_of,
    within_limits,
)
from count_video.motion.priors import (
    BALL_RATE_SIGMA,
    CLEAR_FRAMES,
    DRIFT_SIGMA_PX,
    EXPOSURE,
    PARALLAX_SIGMA,
    PULL_SHARE,
    RATE_SIGMA,
    RATE_SIGMA_UNKNOWN,
    RESTITUTION,
    USUAL_RATE_PER_S,
)
from count_video.motion.resolution import RESOLVED_FRAMES
from count_video.motion.seen import SeenCollisions
from count_video.motion.solving import Noise, Question, Solution, modelled, noise_of, solve
from count_video.motion.starting import MOST_COLLISIONS, scan
from count_video.motion.swing import Swing
from count_video.records import Collision, Floats

FLOORS_PX = (6.0, 0.6)
"""Until all counts are compared, anything nearer than this is as good; the first far from the
solution, where only large residuals should pull."""
FORWARD_FLOOR_PX = 0.3
"""The same until all collisions that are seen are in."""
STARTS = 5
"""Numbers of collisions that are fitted from the first scan."""
SEEN_SHARE = 0.5
"""The number seen is tried if it is more than this share of the scan's best count."""
HOPELESS = 150.0
"""A count whose loss exceeds the best by so much needs no further fit."""
SKIPS = (1.0, 3.0, 8.0)
"""Numbers of frames left out from which fits begin, besides the likeliest by first order."""
MOST_TRIED = 80
"""Neighbours of the best count are tried at most so often."""
PAIR = 2
"""A pair more or less changes little of how the burst ends; single ones come last."""
LONG_STEPS = 32
"""The first neighbours of a count are this part of it away, in pairs, if that is more than one."""


@dataclass(frozen=True)
class Knowledge:
    """What is known of a trial besides its track."""

    capture_fps: float | None = None
    """The camera's rate; None if unknown."""
    mass_ratio: float | None = None
    """Heavy over light; None to let the fit measure it."""
    mass_ratio_sigma: float = 0.0
    """Its standard uncertainty."""

    @property
    def expected_rate(self) -> float | None:
        """Angular rate of usual threads in radians per frame."""
        return None if self.capture_fps is None else USUAL_RATE_PER_S / self.capture_fps


def prior_of(rough: Floats, known: Knowledge) -> Prior:
    """State what is known before the fit about the parameters without deviations."""
    prior = Prior(rough.copy(), np.full(FIRST_DEVIATION, np.inf))
    rate, sigma = float(rough[Column.SWING]), RATE_SIGMA_UNKNOWN
    if known.expected_rate is not None:
        rate, sigma = float(np.log(known.expected_rate)), RATE_SIGMA
    pull = PULL_SHARE * np.exp(2 * rate) * (rough[Column.BALL_REST] - rough[Column.WALL])
    prior = prior.with_value(Column.HEAVY_PULL, 0.0, float(pull))
    prior = prior.with_value(Column.SWING, rate, sigma)
    prior = prior.with_value(Column.BALL_SWING, 0.0, BALL_RATE_SIGMA)
    prior = prior.with_value(Column.EXPOSURE, *EXPOSURE)
    prior = prior.with_value(Column.PARALLAX, 0.0, PARALLAX_SIGMA)
    prior.sigma[FIRST_DRIFT:FIRST_DEVIATION] = DRIFT_SIGMA_PX
    prior = prior.with_value(Column.SKIP, 0.0, 0.0)
    prior = prior.with_value(Column.BODIES, *RESTITUTION)
    prior = prior.with_value(Column.BOUNCE, *RESTITUTION)
    if known.mass_ratio is not None:
        relative = max(known.mass_ratio_sigma / known.mass_ratio, 1e-4)
        prior = prior.with_value(Column.LIGHTNESS, -float(np.log(known.mass_ratio)), relative)
    return prior


def with_deviations(prior: Prior, count: int, scatter: float) -> Prior:
    """Let the restitution of each collision deviate by a scatter."""
    sharing = np.bincount(deviation_places(count))
    return Prior(
        np.concatenate([prior.mean[:FIRST_DEVIATION], np.zeros(len(sharing))]),
        np.concatenate([prior.sigma[:FIRST_DEVIATION], scatter / np.sqrt(sharing)]),
    )


def coarse_fits(
    observed: Observations,
    rough: Floats,
    prior: Prior,
    seen: int,
    start: Solution | None = None,
) -> list[Solution]:
    """Fit promising counts coarsely, without scatter; the solutions by rising loss.

    It begins with the ``start`` if there is one; unless that fits the track as well as noise lets
    it, also with the number that was seen and the counts that a scan likes best. As long as the
    best one's neighbours have not been tried they come next, each from the best fit so far.
    """
    fitted: dict[int, Solution] = {}
    if start is not None and not prior.sigma[Column.SKIP]:
        first = start.values[:FIRST_DEVIATION]
        fitted[start.count] = refloored(observed, prior, first, start.count)
        # Of two bodies in n frames noise alone makes a loss of n, half its chi-square.
        if fitted[start.count].loss < len(observed.frame):
            return _from(observed, prior, fitted)
    if start is not None and prior.sigma[Column.SKIP]:
        return _from(observed, prior, {start.count: _skipping(observed, prior, start)})
    rows = scan(observed, rough, prior)
    likeliest = _likeliest(rows, STARTS)
    wanted = [seen] if not likeliest or seen > SEEN_SHARE * likeliest[0] else []
    for count in dict.fromkeys(wanted + likeliest):
        away = np.abs(rows[:, -2] - count)
        nearest = rows[int(np.argmin(away)), :FIRST_DEVIATION]
        best = _coarse_fit(observed, prior, nearest, count, _bearable(fitted))
        fitted[count] = min(best, fitted.get(count, best), key=_loss_of)
    return _from(observed, prior, fitted)


def _skipping(observed: Observations, prior: Prior, start: Solution) -> Solution:
    """Fit with frames left out, from different numbers of them, and keep the best."""
    best = None
    for skip in (start.values[Column.SKIP], *SKIPS):
        values = start.values[:FIRST_DEVIATION].copy()
        values[Column.SKIP] = skip
        bearable = np.inf if best is None else best.loss + HOPELESS
        fit = _coarse_fit(observed, prior, values, start.count, bearable)
        best = fit if best is None else min(best, fit, key=_loss_of)
    assert best is not None
    return best


def _from(observed: Observations, prior: Prior, fitted: dict[int, Solution]) -> list[Solution]:
    """Fit the neighbours of the best count as long as they are better; by rising loss.

    A neighbour that was fitted from elsewhere to no avail is fitted again from the best.
    """
    best = min(fitted.values(), key=_loss_of)
    step = PAIR * max(1, best.count // LONG_STEPS)
    tried: set[tuple[int, int]] = set()
    while step > 0 and len(tried) < MOST_TRIED:
        for count in (best.count - step, best.count + step):
            if (best.count, count) in tried or not 0 < count <= MOST_COLLISIONS:
                continue
            tried.add((best.count, count))
            bearable = _bearable(fitted)
            if count not in fitted or fitted[count].loss > bearable:
                again = _coarse_fit(observed, prior, neighbouring(best, count), count, bearable)
                fitted[count] = min(again, fitted.get(count, again), key=_loss_of)
        better = min(fitted.values(), key=_loss_of)
        if better is best:
            # Half as far, in whole pairs; at last a single one.
            step = step // 2 // PAIR * PAIR if step > PAIR else step - 1
        else:
            # In long bursts the way may be long: step further as long as it goes downhill.
            best, step = better, 2 * step if best.count > 2 * LONG_STEPS else max(step, PAIR)
    return sorted(fitted.values(), key=_loss_of)


def _loss_of(solution: Solution) -> float:
    return solution.loss


def _bearable(fitted: dict[int, Solution]) -> float:
    """Loss above which a count is out of the question."""
    return min((fit.loss for fit in fitted.values()), default=np.inf) + HOPELESS


def _likeliest(rows: Floats, number: int) -> list[int]:
    """List the counts with the best places of a scan, at most so many."""
    counts = [int(count) for count in rows[:, -2] if 0 < count <= MOST_COLLISIONS]
    return list(dict.fromkeys(counts))[:number]


def _coarse_fit(
    observed: Observations, prior: Prior, start: Floats, count: int, bearable: float
) -> Solution:
    noise = noise_of(observed, start, count, FLOORS_PX[0])
    coarsest = solve(Question(observed, noise, prior, count), start)
    return refloored(observed, prior, coarsest.values, count, bearable)


def refloored(
    observed: Observations, prior: Prior, start: Floats, count: int, bearable: float = np.inf
) -> Solution:
    """Fit a count coarsely, without scatter."""
    start = _led_to_the_last(observed, prior, start, count)
    noise = noise_of(observed, start, count, FLOORS_PX[-1])
    return solve(Question(observed, noise, prior, count), start, bearable)


def _led_to_the_last(observed: Observations, prior: Prior, start: Floats, count: int) -> Floats:
    """Improve a start in which the last collision does not come about in time.

    That one is often slow and easily missed, and what does not happen has no derivative to follow.
    So the frames before it are fitted first, with the collisions before it.
    """
    paths, _ = modelled(observed, start[None], count)
    before = until(observed, observed.last - CLEAR_FRAMES)
    if (
        paths.time[0, -1] <= observed.times(start[None])[0, -1]
        or len(before.frame) < 2
        or count < 2
    ):
        return start
    noise = noise_of(before, start, count - 1, FLOORS_PX[-1])
    return solve(Question(before, noise, prior, count - 1), start).values


def fine_fit(
    observed: Observations,
    noise: Noise,
    prior: Prior,
    coarse: Solution,
    scatter: float,
    bearable: float = np.inf,
) -> Solution:
    """Fit with scatter of the restitution, from a coarse fit or another fine one."""
    columns = FIRST_DEVIATION + deviations_of(coarse.count)
    start = np.concatenate([coarse.values, np.zeros(columns)])
    start = start[:columns]  # a fine fit brings deviations of its own
    start[Column.SKIP] = round(start[Column.SKIP])
    full = with_deviations(prior, coarse.count, scatter).with_value(Column.SKIP, 0.0, 0.0)
    return solve(Question(observed, noise, full, coarse.count), start, bearable)


def neighbouring(solution: Solution, count: int) -> Floats:
    """Turn a fit into a start, shape (columns without deviations,), for another count.

    One collision fewer or more is the burst's end cut or gone on. For pairs, the number of
    collisions grows as the root of the mass ratio. With that changed, and each loss so that their
    sum stays, what goes before and what comes after the thick of it is still where it was seen.
    """
    values = solution.values[:FIRST_DEVIATION].copy()
    if (count - solution.count) % PAIR:
        return values
    values[Column.LIGHTNESS] -= 2 * np.log(count / solution.count)
    contacts = [Column.BODIES, Column.BOUNCE]
    values[contacts] = 1 - (1 - values[contacts]) * solution.count / count
    return within_limits(values)


def log_evidence(solution: Solution, scatter: float) -> float:
    """Logarithm of the evidence for a count, up to what all counts have in common."""
    if not np.isfinite(solution.loss):
        return -np.inf
    scale = np.sqrt(np.maximum(np.diag(solution.hessian), 1e-300))
    scaled = solution.hessian / scale[:, None] / scale
    _, log_determinant = np.linalg.slogdet(scaled + 1e-10 * np.eye(len(scaled)))
    volume = log_determinant + 2 * np.log(scale).sum()
    spread = np.log(scatter / np.sqrt(np.bincount(deviation_places(solution.count)))).sum()
    return float(-solution.loss - 0.5 * volume - spread)


FIRST_COLLISIONS = 4
GROWTH = 2
"""Each fit spans so many times the collisions of the one before: they foresee the others' times to
a small part of a collision."""
SCATTER = 0.006
"""Of the restitution from collision to collision, to begin with."""
SWING_SIGMAS = 4.0
"""The heavy body's swing must be measured this clearly to begin with it."""


def forward_fit(
    observed: Observations, rough: Floats, prior: Prior, found: SeenCollisions, seen: int
) -> Solution:
    """Fit the first so many collisions of a burst, every one of which is seen."""
    burst = found.collisions[: found.burst]
    values = rough
    if seen == len(burst) and found.swing is not None:
        values = _with_swing(rough, found.swing)
    counts = stages(seen)
    # The rough values may be px off: the first few are fitted coarsely before.
    for count, floor_px in [(counts[0], FLOORS_PX[0]), *((n, FORWARD_FLOOR_PX) for n in counts)]:
        part = observed
        if count < len(burst):
            part = until(observed, burst[count].frame - observed.origin - CLEAR_FRAMES)
        missing = FIRST_DEVIATION + deviations_of(count) - len(values)
        values = np.concatenate([values, np.zeros(max(missing, 0))])
        noise = noise_of(part, values, count, floor_px)
        full = with_deviations(prior, count, SCATTER)
        solution = solve(Question(part, noise, full, count), values)
        values = solution.values
    return solution


def calm_beginning(burst: Sequence[Collision]) -> int:
    """Count the collisions up to the first two between which some may be missing."""
    flights = np.diff([collision.frame for collision in burst])
    close = np.flatnonzero(flights < RESOLVED_FRAMES)
    return int(close[0]) + 1 if len(close) else len(burst)


def _with_swing(rough: Floats, swing: Swing) -> Floats:
    """Take from the heavy body's path what it gives better than the rough values do."""
    values = rough.copy()
    if swing.mass_ratio_relative_sigma < 1 / SWING_SIGMAS:
        values[Column.LIGHTNESS] = -np.log(swing.mass_ratio)
    if swing.rate_squared > SWING_SIGMAS * swing.rate_squared_sigma:
        values[Column.SWING] = np.log(swing.rate_squared) / 2
    return within_limits(values)


def stages(count: int) -> list[int]:
    """Numbers of collisions that are fitted one after the other; the last is all of them."""
    rising = [min(FIRST_COLLISIONS, count)]
    while rising[-1] < count:
        rising.append(min(rising[-1] * GROWTH, count))
    return rising

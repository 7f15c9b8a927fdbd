"""Rival counts: the best fit of each number of collisions to one track.

What is not seen from the beginning on is scanned, and from the best count found so far the search
climbs to its neighbours. These fits are coarse: what is nearer than a floor is as good, and the
restitution is the same at all collisions.

What the best of them leaves unexplained is larger than the noise of single frames and hangs
together over several: compression, shading and a model that is not the world see to that. Where
collisions are close, a track's own estimate of its noise is too large. So the noise is that of the
residuals about the best fit, and only then are the counts weighed, each with every scatter of the
restitution.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from count_video.motion.descent import NEARLY
from count_video.motion.observations import Observations
from count_video.motion.parameters import (
    FIRST_DEVIATION,
    Column,
    Prior,
    within_limits,
)
from count_video.motion.pendulums import follow
from count_video.motion.priors import CLEAR_FRAMES, SCATTERS
from count_video.motion.solving import Fit, Noise, Question, fine_fit, noise_of, solve
from count_video.motion.starting import MOST_COLLISIONS, scan
from count_video.records import Floats

FLOORS_PX = (6.0, 0.6)
"""Until all counts are compared, anything nearer than this is as good; the first far from the
solution, where only large residuals should pull."""
STARTS = 5
"""Numbers of collisions that are fitted from the first scan."""
SEEN_SHARE = 0.5
"""The number seen is tried if it is more than this share of the scan's best count."""
HOPELESS = 150.0
"""A count whose loss exceeds the best by so much needs no further fit."""
PAIR = 2
"""A pair more or less changes little of how the burst ends; single ones come last."""
LONG_STEPS = 32
"""The first neighbours of a count are this part of it away, in pairs, if that is more than one."""


@dataclass(frozen=True)
class Rivals:
    """The best coarse fit so far of each number of collisions."""

    observed: Observations
    prior: Prior
    """Of the parameters without deviations."""
    most: int = MOST_COLLISIONS
    """More collisions are not tried."""
    fits: dict[int, Fit] = field(default_factory=dict)

    @property
    def best(self) -> Fit:
        """The fit with the least loss."""
        return min(self.fits.values(), key=loss_of)

    @property
    def bearable(self) -> float:
        """Loss above which a count is out of the question."""
        return self.best.loss + HOPELESS if self.fits else np.inf

    def add(self, count: int, start: Floats, floors_px: tuple[float, ...] = FLOORS_PX) -> None:
        """Fit a count from a start, shape (columns, ...), within one floor after the other."""
        fit = self.fitted(count, start, floors_px)
        self.fits[count] = min(fit, self.fits.get(count, fit), key=loss_of)

    def fitted(self, count: int, start: Floats, floors_px: tuple[float, ...]) -> Fit:
        """Fit a count without scatter of the restitution."""
        observed, start = self.observed, start[:FIRST_DEVIATION]
        for floor_px in floors_px[:-1]:
            noise = noise_of(observed, start, count, floor_px)
            question = Question(observed, noise, self.prior, count)
            start = solve(question, start, enough=NEARLY).values
        start = self._led_to_the_last(count, start)
        noise = noise_of(observed, start, count, floors_px[-1])
        return solve(Question(observed, noise, self.prior, count), start, self.bearable)

    def _led_to_the_last(self, count: int, start: Floats) -> Floats:
        """Improve a start in which the last collision does not come about in time.

        That one is often slow and easily missed, and what does not happen has no derivative to
        follow. So the frames before it are fitted first, with the collisions before it.
        """
        observed = self.observed
        last = follow(start[None], count, observed.start).time[0, -1]
        before = observed.at(observed.frame < observed.last - CLEAR_FRAMES)
        if last <= observed.times(start)[-1] or len(before.frame) < 2 or count < 2:
            return start
        noise = noise_of(before, start, count - 1, FLOORS_PX[-1])
        question = Question(before, noise, self.prior, count - 1)
        return solve(question, start, self.bearable, NEARLY).values

    def scan(self, rough: Floats, seen: int) -> None:
        """Fit the number that was seen, and the counts that a scan likes best."""
        rows = scan(self.observed, rough, self.prior)
        counts = [int(count) for count in rows[:, -2] if 0 < count <= self.most]
        likeliest = list(dict.fromkeys(counts))[:STARTS]
        wanted = [seen] if not likeliest or seen > SEEN_SHARE * likeliest[0] else []
        for count in dict.fromkeys(wanted + likeliest):
            nearest = int(np.argmin(np.abs(rows[:, -2] - count)))
            self.add(count, rows[nearest])

    def climb(self) -> None:
        """Fit the neighbours of the best count while one is better.

        A neighbour that was fitted from elsewhere to no avail is fitted again from the best.
        """
        step = PAIR * max(1, self.best.count // LONG_STEPS)
        while step:
            before = self.best
            for count in (before.count - step, before.count + step):
                known = self.fits.get(count)
                if 0 < count <= self.most and (not known or known.loss > self.bearable):
                    self.add(count, neighbouring(before, count))
            if self.best is before:
                # Half as far, in whole pairs; at last a single one.
                step = step // 2 // PAIR * PAIR if step > PAIR else step - 1
            elif before.count > 2 * LONG_STEPS:
                step *= 2  # in long bursts the way may be long
            else:
                step = max(step, PAIR)


def loss_of(fit: Fit) -> float:
    """Key by which fits of one noise are compared."""
    return fit.loss


def neighbouring(fit: Fit, count: int) -> Floats:
    """Turn a fit into a start, shape (columns without deviations,), for another count.

    One collision fewer or more is the burst's end cut or gone on. For pairs, the number of
    collisions grows as the root of the mass ratio. With that changed, and each loss so that their
    sum stays, what goes before and what comes after the thick of it is still where it was seen.
    """
    values = fit.values[:FIRST_DEVIATION].copy()
    if (count - fit.count) % PAIR:
        return values
    values[Column.LIGHTNESS] -= 2 * np.log(count / fit.count)
    contacts = [Column.BODIES, Column.BOUNCE]
    values[contacts] = 1 - (1 - values[contacts]) * fit.count / count
    return within_limits(values)


# ---- with scatter of the restitution -------------------------------------------------------------

IMPROBABLE = 10.0
"""Counts more than a pair from those whose evidence is smaller by less than this, as a logarithm,
are none."""
MOST_RIVALS = 16
"""Counts on either side of the best that are weighed: where so many are likely, none is known."""
RESIDUALS_AT_LEAST = 20
"""Fewer do not show how large they are."""
CLIPPED_SIGMAS = 6.0
"""Larger residuals count as this: the tracker was misled."""


def residual_noise(rivals: Rivals, coarse: Fit) -> tuple[Fit, Noise]:
    """Fit a count finely, and widen the noise to what is left over; returns the fit with it.

    The restitution may scatter as much as it ever does, or its scatter would be taken for noise.
    """
    observed, count = rivals.observed, coarse.count
    noise = noise_of(observed, coarse.values, count)
    fit = fine_fit(Question(observed, noise, rivals.prior, count), coarse.values)
    noise = noise_of(observed, fit.values, count)
    ball, heavy = np.split(fit.left_px, 2)
    spread = _spread(ball / noise.ball), _spread(heavy / noise.heavy)
    return fit, Noise(noise.ball * spread[0], noise.heavy * spread[1])


def _spread(residuals: Floats) -> float:
    """Factor on the noise for residuals that are larger or smaller than it."""
    kept = residuals[np.isfinite(residuals)]
    if len(kept) < RESIDUALS_AT_LEAST:
        return 1.0
    return float(np.sqrt(np.mean(np.clip(kept, -CLIPPED_SIGMAS, CLIPPED_SIGMAS) ** 2)))


def scattered(question: Question, start: Floats, bearable: float = np.inf) -> list[Fit]:
    """Fit a count with each scatter of the restitution, from the values of a fit."""
    fits: list[Fit] = []
    for scatter in SCATTERS[::-1]:
        fits.append(fine_fit(question, start, scatter, bearable))
        start = fits[-1].values
        if fits[-1].loss > bearable:
            break
    return fits


def weigh(rivals: Rivals, start: Fit, noise: Noise) -> list[Fit]:
    """Fit each count that comes into question with each scatter; it begins with the ``start``.

    Each is fitted from its coarse fit where that is of use, or from the fit of its neighbour or, as
    the kind of the last collision is mostly seen, of the one a pair away, until all that are next
    to likely ones are.
    """
    starts = {count: fit for count, fit in rivals.fits.items() if fit.loss < rivals.bearable}
    question = Question(rivals.observed, noise, rivals.prior, start.count)
    fits = scattered(question, start.values)
    while (count := _next_to_likely(fits, start.count)) is not None:
        bearable = min(fit.loss for fit in fits) + HOPELESS
        begin = starts.get(count)
        if begin is None:
            near = [fit for fit in fits if fit.loss < bearable]
            nearest = min(near, key=lambda f: ((f.count - count) % PAIR, abs(f.count - count)))
            begin = rivals.fitted(count, neighbouring(nearest, count), FLOORS_PX[-1:])
        fits += scattered(replace(question, count=count), begin.values, bearable)
    return [fit for fit in fits if np.isfinite(fit.evidence)]


def _next_to_likely(fits: Sequence[Fit], first: int) -> int | None:
    """Find a count, as near to the first as possible, that is to be weighed as well."""
    highest, known = max(fit.evidence for fit in fits), {fit.count for fit in fits}
    likely = {fit.count for fit in fits if fit.evidence > highest - IMPROBABLE}
    near = {count + step for count in likely for step in (-PAIR, -1, 1, PAIR)} - known
    allowed = [count for count in near if count > 0 and abs(count - first) <= MOST_RIVALS]
    return min(allowed, key=lambda count: (abs(count - first), count), default=None)

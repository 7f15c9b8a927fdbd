"""Rival counts: the best fit of each number of collisions to one track.

The calm beginning, of which every collision is seen, is fitted first, and its times lead the fit.
What is not seen is scanned from there, and from the best count found so far the search climbs to
its neighbours. These fits are coarse: what is nearer than a floor is as good, and the restitution
of rivals is the same at all collisions.

By what the best of them leaves unexplained the counts are then weighed, with a scatter of the
restitution: where collisions are close, a track's own estimate of its noise is too large.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from operator import attrgetter

import numpy as np

from count_video.motion.descent import NEARLY
from count_video.motion.observations import Observations
from count_video.motion.parameters import (
    FIRST_DEVIATION,
    Column,
    Prior,
    within_limits,
)
from count_video.motion.priors import CLEAR_FRAMES, DAMPING, SCATTERS, SPEED
from count_video.motion.solving import (
    Fit,
    Question,
    solve,
    with_each_scatter,
)
from count_video.motion.starting import LONGEST_STEP, MOST_COLLISIONS, scan
from count_video.records import Floats
from count_video.signals import MEDIAN_TO_SIGMA

FLOORS_PX = (6.0, 0.6)
"""Until all counts are compared, anything nearer than this is as good; the first far from the
solution, where only large residuals should pull."""
FIRST_COLLISIONS = 4
"""So many collisions of a calm beginning are fitted first, and each time twice as many: they
foresee the others' times to a small part of a collision."""
LIGHTNESS_SIGMA = 0.5
"""The logarithm of the rough lightness of the ball is known to this. A few collisions hardly show
it where the heavy body is not seen."""
TIME_SIGMA = 0.25
"""Frames by which the times of calm collisions may be wrong where they lead a fit to its place."""
HOPELESS = 150.0
"""A count whose loss exceeds the best by so much needs no further fit."""
BETTER = 0.25
"""Fall of the loss by which a neighbour is better: coarse fits come down to about as much."""
BY_LOSS = attrgetter("loss")
"""Key by which fits of one noise are compared."""
PAIR = 2
"""A pair more or less changes little of how the burst ends; single ones come last."""
IMPROBABLE = 10.0
"""Counts more than a pair from those whose evidence is smaller by less than this, as a logarithm,
are none."""
UNLIKELY = 30.0
"""Loss above that of the likeliest count, with as much scatter as ever, by which a count is none
of them."""
MOST_RIVALS = 16
"""Counts on either side of the best that are weighed: where so many are likely, none is known."""
CLIPPED_SIGMAS = 6.0
"""Larger residuals count as this: the tracker was misled."""
BLOCK_FRAMES, BLOCKS_AT_LEAST = 8, 3
"""Errors that last show in the means of so many residuals; fewer blocks show nothing."""


@dataclass(frozen=True)
class Rivals:
    """The best coarse fit so far of each number of collisions."""

    observed: Observations
    prior: Prior
    """Of the parameters without deviations."""
    fits: dict[int, Fit] = field(default_factory=dict)

    @property
    def best(self) -> Fit:
        """The fit with the least loss."""
        return min(self.fits.values(), key=BY_LOSS)

    @property
    def bearable(self) -> float:
        """Loss above which a count is out of the question."""
        return self.best.loss + HOPELESS if self.fits else np.inf

    def grow(self, start: Floats) -> Fit:
        """Fit the calm beginning, from its first collisions on each time twice as many."""
        count, calm = FIRST_COLLISIONS, self.observed.calm
        while count < calm:
            start = self.led(count, start).values
            count *= 2
        return self.led(calm, start)

    def led(self, count: int, start: Floats) -> Fit:
        """Fit so many first collisions, led by the times that the frames show of them.

        Their restitution scatters; of rivals it does not, for with it long bursts resemble each
        other.
        """
        known, ends = self.prior, np.append(self.observed.burst - CLEAR_FRAMES, np.inf)
        if not self.observed.shows_heavy:
            lightness = float(start[Column.LIGHTNESS])
            known = known.with_value(Column.LIGHTNESS, lightness, LIGHTNESS_SIGMA)
        some = replace(self.observed.at(self.observed.frame < ends[count]), calm=count)
        asked = Question(some, some.noise_px(), known, count, SCATTERS[-2], TIME_SIGMA)
        for floor_px in FLOORS_PX:
            fit = self._within(floor_px, asked, start)
            start = fit.values
        return fit

    def scan(self, start: Floats) -> None:
        """Fit the counts that a scan from a start, shape (columns,), likes best."""
        for count, values in scan(self.observed, start, self.prior):
            self.add(count, values)

    def climb(self, calm: Floats | None = None) -> None:
        """Fit the neighbours of the best count while one is better, those far away before pairs.

        Better is one by more than fits are brought down to: from one pair to the next the loss may
        fall by less where no frame shows the burst, and over many pairs by much. One collision more
        or fewer at the end makes the motion there another one: such a neighbour is also fitted from
        the ``calm`` beginning, and before others where that was fitted well.
        """
        tried: set[tuple[int, int]] = set()
        if calm is not None:
            self._step(1, calm, tried)
        self._step(_longest_step(self.best.count), calm, tried)

    def _step(self, step: int, calm: Floats | None, tried: set[tuple[int, int]]) -> None:
        """Fit neighbours that are so far away, or farther where one is better, or else nearer.

        Each is fitted from the best, also if it was ``tried`` from another count before.
        """
        side = -1
        while step:
            before = self.best
            for turned in (side, -side):
                count = before.count + turned * step
                if 0 < count <= MOST_COLLISIONS and (before.count, count) not in tried:
                    tried.add((before.count, count))
                    fit = self.add(count, neighbouring(before, count))
                    if fit.reached < count:
                        # Not so: the same motion, cut or gone on at its end, may be nearer.
                        self.add(count, before.values)
                    if step % PAIR and calm is not None:
                        self.add(count, calm)
                    if count == before.count + 1:
                        self._add_touching(before)
                if self.best.loss < before.loss - BETTER:
                    side = turned
                    step = min(2 * step, _longest_step(before.count))
                    break
            else:
                # A quarter as far, in whole pairs; at last a single one.
                step = max(PAIR, _whole_pairs(step // 4)) if step > PAIR else step - 1

    def _add_touching(self, before: Fit) -> None:
        """Fit one collision more where the ball turns next to the wall: it may have struck it.

        With the wall nearer by as much, that collision comes about.
        """
        near_px, nearer = _nearest_px(before), before.values.copy()
        if 0.0 < near_px < FLOORS_PX[-1]:
            nearer[Column.WALL] += 2 * near_px
            self.add(before.count + 1, nearer)

    def add(self, count: int, start: Floats) -> Fit:
        """Fit a count from a start, shape (columns, ...), with each floor."""
        fit = self._fitted(count, start)
        reached = fit.reached
        if 0 < reached < count and reached not in self.fits:
            # The same motion without the collisions that do not come about.
            self._fitted(reached, fit.values)
        return fit

    def _fitted(self, count: int, start: Floats) -> Fit:
        asked = Question(self.observed, self.observed.noise_px(), self.prior, count)
        for floor_px in FLOORS_PX:
            fit = self._within(floor_px, asked, start)
            start = self._led_to_the_last(fit).values
        self.fits[count] = min(fit, self.fits.get(count, fit), key=BY_LOSS)
        return fit

    def _within(self, floor_px: float, asked: Question, start: Floats) -> Fit:
        """Fit what is asked, where anything within a floor is as good."""
        asked = replace(asked, noise_px=asked.observed.noise_px(floor_px))
        return solve(asked, start, self.bearable, NEARLY)

    def _led_to_the_last(self, fit: Fit) -> Fit:
        """Improve a fit in which the last collision does not come about in time.

        That one is often slow and easily missed. So the frames before it are fitted first, with the
        collisions before it.
        """
        observed, count = self.observed, fit.count - 1
        before = observed.at(observed.frame < observed.burst[-1] - CLEAR_FRAMES)
        if fit.reached > count or len(before.frame) < 2 or not count:
            return fit
        asked = replace(fit.question, observed=before, count=count)
        return self._within(FLOORS_PX[-1], asked, fit.values)


def _longest_step(count: int) -> int:
    """Between neighbours, in whole pairs."""
    return max(_whole_pairs(count // LONGEST_STEP), PAIR)


def _whole_pairs(count: int) -> int:
    return count // PAIR * PAIR


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


def _nearest_px(fit: Fit) -> float:
    """How near the ball comes to the wall after the last collision; infinite if it is not shown."""
    observed = fit.observed
    later = observed.times(fit.values) > fit.paths.time[0, -1] + CLEAR_FRAMES
    place = (observed.places_px - fit.left_px)[: len(later)][later]
    return float(np.nanmin(place - fit.values[Column.WALL], initial=np.inf))


# ---- with scatter of the restitution -------------------------------------------------------------


def with_residual_noise(observed: Observations, fit: Fit) -> Fit:
    """Fit a count finely, and widen the noise to what is left over.

    The restitution may scatter as much as it ever does, or its scatter would be taken for noise.
    """
    noise_px = observed.noise_px()
    known = fit.question.known.with_value(Column.DAMPING, *DAMPING)
    known = known.with_value(Column.SPEED, *SPEED)
    question = Question(observed, noise_px, known, fit.count, SCATTERS[-1])
    fit = solve(question, fit.values, enough=NEARLY)
    left = fit.left_px.reshape(2, -1) / noise_px[:, None]
    lasting = np.array([_lasting(one) for one in left])
    noise_px = noise_px * [_spread(one) for one in left] * lasting
    return Fit(replace(question, noise_px=noise_px, lasting=lasting), fit.values)


def _spread(residuals: Floats) -> float:
    """Factor on the noise for residuals that are larger or smaller than it; 1 if there are none."""
    if np.isnan(residuals).all():
        return 1.0
    return float(np.sqrt(np.nanmean(np.clip(residuals, -CLIPPED_SIGMAS, CLIPPED_SIGMAS) ** 2)))


def _lasting(residuals: Floats) -> float:
    """Factor on the noise for residuals that hang together over some frames; 1 for white ones.

    The mean of n white residuals has an n-th of their variance (batch means). Where the means of
    blocks have more, so many times fewer residuals are independent of each other, as where a camera
    moves that no scenery shows: each of them counts that much less beside what was known before.
    """
    known = residuals[np.isfinite(residuals)]
    blocks = len(known) // BLOCK_FRAMES
    limit = CLIPPED_SIGMAS * MEDIAN_TO_SIGMA * float(np.median(np.abs(known))) if blocks else 0.0
    if blocks < BLOCKS_AT_LEAST or limit == 0.0:
        return 1.0
    used = np.clip(known, -limit, limit)[: blocks * BLOCK_FRAMES].reshape(blocks, BLOCK_FRAMES)
    inflation = BLOCK_FRAMES * np.mean(used.mean(axis=1) ** 2) / np.mean(used**2)
    return float(np.sqrt(max(1.0, inflation)))


def weigh(rivals: Rivals, question: Question, fits: list[Fit], bearable: float) -> list[Fit]:
    """Fit each count that comes into question beside the likeliest, up to a bearable loss.

    Each is fitted from its coarse fit where that is of use, or from the fit of its neighbour or, as
    the kind of the last collision is mostly seen, of the one a pair away, until all that are next
    to likely ones are.
    """
    first = fits[0].count
    tried = {first}
    while (count := _next_to_likely(fits, tried, first)) is not None:
        tried.add(count)
        coarse = rivals.fits.get(count)
        if coarse is None:
            near = [rivals.fits[fit.count] for fit in fits]
            nearest = min(near, key=lambda f: ((f.count - count) % PAIR, abs(f.count - count)))
            coarse = rivals.add(count, neighbouring(nearest, count))
        if coarse.loss < rivals.bearable:
            fits = fits + with_each_scatter(replace(question, count=count), coarse.values, bearable)
    return fits


def _next_to_likely(fits: Sequence[Fit], tried: set[int], first: int) -> int | None:
    """Find a count, as near to the first as possible, that is to be weighed as well."""
    highest = max(fit.evidence for fit in fits)
    likely = {fit.count for fit in fits if fit.evidence > highest - IMPROBABLE}
    near = {count + step for count in likely for step in (-PAIR, -1, 1, PAIR)} - tried
    allowed = [
        count
        for count in near
        if 0 < count <= MOST_COLLISIONS and abs(count - first) <= MOST_RIVALS
    ]
    return min(allowed, key=lambda count: (abs(count - first), count), default=None)

"""Rival counts: the best fit of each number of collisions to one track.

A burst is fitted from its beginning on: the first few collisions, then more and more of them. Where
the first collisions are seen, they give wall, contact and losses well enough to foresee the next
few, and these give them better. So no fit ever starts more than a small part of a collision from
where it ends, and nothing has to be searched for. What is not seen is scanned, and from the best
count found so far the search climbs to its neighbours.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from count_video.motion.descent import NEARLY
from count_video.motion.observations import Observations, until
from count_video.motion.parameters import (
    FIRST_DEVIATION,
    Column,
    Prior,
    deviations_of,
    with_deviations,
    within_limits,
)
from count_video.motion.priors import CLEAR_FRAMES, SCATTERS
from count_video.motion.solving import Noise, Question, Solution, modelled, noise_of, solve
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


@dataclass
class Rivals:
    """The best fit so far of each number of collisions.

    Without a ``noise`` the fits are coarse: what is nearer than a floor is as good, and the
    restitution is the same at all collisions. With one it scatters as much as it ever does.
    """

    observed: Observations
    prior: Prior
    """Of the parameters without deviations."""
    most: int = MOST_COLLISIONS
    """More collisions are not tried."""
    noise: Noise | None = None
    fits: dict[int, Solution] = field(default_factory=dict)

    @property
    def best(self) -> Solution:
        """The fit with the least loss."""
        return min(self.fits.values(), key=_loss_of)

    @property
    def bearable(self) -> float:
        """Loss above which a count is out of the question."""
        return self.best.loss + HOPELESS if self.fits else np.inf

    def by_loss(self) -> list[Solution]:
        """Return the fits that are not out of the question, best first."""
        likely = [fit for fit in self.fits.values() if fit.loss < self.bearable]
        return sorted(likely, key=_loss_of)

    def add(self, count: int, start: Floats, floors_px: tuple[float, ...] = FLOORS_PX) -> None:
        """Fit a count from a start, shape (columns, ...); coarse fits come to one floor by one."""
        observed, prior, bearable = self.observed, self.prior, self.bearable
        if self.noise is None:
            fit = coarse_fit(observed, prior, start, count, floors_px, bearable)
        else:
            question = Question(observed, self.noise, prior, count)
            fit = fine_fit(question, start, SCATTERS[-1], bearable)
        self.fits[count] = min(fit, self.fits.get(count, fit), key=_loss_of)

    def scan(self, rough: Floats, seen: int) -> None:
        """Fit the number that was seen, and the counts that a scan likes best."""
        rows = scan(self.observed, rough, self.prior)
        counts = [int(count) for count in rows[:, -2] if 0 < count <= self.most]
        likeliest = list(dict.fromkeys(counts))[:STARTS]
        wanted = [seen] if not likeliest or seen > SEEN_SHARE * likeliest[0] else []
        for count in dict.fromkeys(wanted + likeliest):
            nearest = int(np.argmin(np.abs(rows[:, -2] - count)))
            self.add(count, rows[nearest, :FIRST_DEVIATION])

    def climb(self, least: int = 1) -> None:
        """Fit the neighbours of the best count, at last the ``least`` away, while one is better.

        A neighbour that was fitted from elsewhere to no avail is fitted again from the best.
        """
        step = PAIR * max(1, self.best.count // LONG_STEPS)
        while step >= least:
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


def _loss_of(solution: Solution) -> float:
    return solution.loss


def coarse_fit(
    observed: Observations,
    prior: Prior,
    start: Floats,
    count: int,
    floors_px: tuple[float, ...] = FLOORS_PX[-1:],
    bearable: float = np.inf,
) -> Solution:
    """Fit a count without scatter of the restitution, within one floor after the other."""
    for floor_px in floors_px[:-1]:
        noise = noise_of(observed, start, count, floor_px)
        start = solve(Question(observed, noise, prior, count), start, enough=NEARLY).values
    start = _led_to_the_last(observed, prior, start, count, bearable)
    noise = noise_of(observed, start, count, floors_px[-1])
    return solve(Question(observed, noise, prior, count), start, bearable)


def _led_to_the_last(
    observed: Observations, prior: Prior, start: Floats, count: int, bearable: float
) -> Floats:
    """Improve a start in which the last collision does not come about in time.

    That one is often slow and easily missed, and what does not happen has no derivative to follow.
    So the frames before it are fitted first, with the collisions before it.
    """
    paths, _ = modelled(observed, start[None], count)
    before = until(observed, observed.last - CLEAR_FRAMES)
    in_time = paths.time[0, -1] <= observed.times(start[None])[0, -1]
    if in_time or len(before.frame) < 2 or count < 2:
        return start
    noise = noise_of(before, start, count - 1, FLOORS_PX[-1])
    return solve(Question(before, noise, prior, count - 1), start, bearable, NEARLY).values


def fine_fit(
    question: Question, start: Floats, scatter: float, bearable: float = np.inf
) -> Solution:
    """Fit with scatter of the restitution, from the values of a coarse fit or another fine one."""
    count = question.count
    columns = FIRST_DEVIATION + deviations_of(count)
    start = np.concatenate([start, np.zeros(columns)])
    start = start[:columns]  # a fine fit brings deviations of its own
    start[Column.SKIP] = round(start[Column.SKIP])
    full = with_deviations(question.prior, count, scatter).with_value(Column.SKIP, 0.0, 0.0)
    return solve(replace(question, prior=full), start, bearable)


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

r"""Where frames may be left out of a burst: a test of every place, by the fit without any.

With the residuals r of a fit over their standard deviations, its Jacobian J and Hessian H, and the
velocities c of all places after a frame, a time s that passes unseen after that frame lets the loss
fall by

    (c' r)^2 / 2 (c' c - c' J H^-1 J' c)     for     s = -c' r / (c' c - c' J H^-1 J' c),

in the first order (Rao's score test). Where that outweighs what is expected of frames left out,
fits with them there decide, in which the restitution scatters, for which they might be mistaken.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from count_video.motion.observations import Observations, left_out_after
from count_video.motion.parameters import Column, Prior, with_deviations
from count_video.motion.priors import LEFT_OUT, SCATTERS
from count_video.motion.rivals import FLOORS_PX, PAIR, Rivals
from count_video.motion.solving import Fit, Linearised, Noise, Question, Solution, noise_of
from count_video.motion.time_base import LeftOut
from count_video.motion.time_hypotheses import SIDE_FRAMES
from count_video.records import Floats

MOST_FRAMES = 24
"""So many frames may be left out of a burst: more hold most of it."""
COUNTS = 3
"""Of each hypothesis so many counts are fitted with a scatter of the restitution."""
PLACES = 2
"""So many places are fitted closely, ..."""
APART_FRAMES = 3.0
"""... which are so far apart, ..."""
ROUNDS = 3
"""... and so often others by the best fit until then."""


@dataclass(frozen=True)
class _Hypothesis:
    """Frames left out at one place, or none."""

    coarse: Rivals

    @cached_property
    def best(self) -> Solution:
        """The best fit with whole frames left out, and restitutions that scatter."""
        observed, best = self.coarse.observed, self.coarse.best
        noise = noise_of(observed, best.values, best.count, FLOORS_PX[-1])
        fine = replace(self.coarse, noise=noise, fits={})
        for fit in self.coarse.by_loss()[:COUNTS]:
            fine.add(fit.count, fit.values)
        fine.climb(least=PAIR)
        return fine.best


def with_frames_left_out(coarse: Rivals, rough: Floats, seen: int, gap: LeftOut | None) -> Rivals:
    """Let frames be left out where that explains the track better, and fit the counts anew.

    Where some are known to be left out, in the ``gap``, their number is free.
    """
    observed = coarse.observed
    price = _price(observed)
    best = _Hypothesis(coarse)
    if gap is not None:
        start = rough.copy()
        start[Column.SKIP] = -gap.frames
        none = replace(coarse, observed=left_out_after(observed, gap.after), fits={})
        none.scan(start, seen)
        none.climb()
        some = _skipping(coarse, none.observed, coarse.best, -gap.frames)
        likelier = min(_Hypothesis(some), best, key=lambda one: one.best.loss)
        evened = _Hypothesis(none).best.loss < likelier.best.loss + price
        return none if evened else likelier.coarse
    tried: set[float] = set()
    for _ in range(ROUNDS):
        before = best
        for frame, skip in (*_beside(best.coarse), *_suspected(best.coarse)):
            if frame not in tried:
                tried.add(frame)
                there = left_out_after(observed, frame)
                some = _skipping(coarse, there, before.coarse.best, skip)
                dearer = 0.0 if best.coarse is not coarse else price
                other = _Hypothesis(some)
                skips = other.best.values[Column.SKIP] > 0
                if skips and other.best.loss + dearer < best.best.loss:
                    best = other
        if best is before:
            break
    return best.coarse


def _skipping(even: Rivals, observed: Observations, start: Solution, skip: float) -> Rivals:
    """Fit with frames left out, from so many of them on."""
    free = even.prior.with_value(Column.SKIP, 0.0, np.inf)
    rivals = replace(even, observed=observed, prior=free, fits={})
    values = start.values[: len(free.mean)].copy()
    values[Column.SKIP] = skip
    rivals.add(start.count, values)
    rivals.climb()
    return rivals


def lacks_frames(observed: Observations, noise: Noise, prior: Prior, fit: Solution) -> bool:
    """Whether frames left out somewhere would explain the track better, in first order."""
    full = with_deviations(prior, fit.count, SCATTERS[-1])
    skip, gain = _scores(
        observed, Fit(Question(observed, noise, full, fit.count), fit.values).linearised
    )
    return float(gain[skip > 0].max(initial=0.0)) > _price(observed)


def _price(observed: Observations) -> float:
    """By how much a fit with frames left out must be better: their prior, place and number."""
    return float(np.log(len(observed.frame) * MOST_FRAMES / LEFT_OUT))


def _beside(coarse: Rivals) -> list[tuple[float, float]]:
    """Where near their place the frames that are left out explain the track best, and how many."""
    observed, best = coarse.observed, coarse.best
    if not observed.after.any():
        return []
    noise = noise_of(observed, best.values, best.count, FLOORS_PX[-1])
    frames = observed.origin + observed.frame
    near = frames[np.abs(frames - frames[observed.after == 0][-1]) <= SIDE_FRAMES].tolist()
    asked = [Question(left_out_after(observed, at), noise, coarse.prior, best.count) for at in near]
    losses = [Fit(question, best.values).loss for question in asked]
    return [(near[int(np.argmin(losses))], float(best.values[Column.SKIP]))]


def _suspected(coarse: Rivals) -> list[tuple[float, float]]:
    """Frames after which time seems to be missing and how much, the clearest first."""
    observed, best = coarse.observed, coarse.best
    noise = noise_of(observed, best.values, best.count, FLOORS_PX[-1])
    even = coarse.prior.with_value(Column.SKIP, 0.0, 0.0)
    question = Question(observed, noise, even, best.count)
    skip, gain = _scores(observed, Fit(question, best.values).linearised)
    frames = observed.origin + observed.frame
    found: list[tuple[float, float]] = []
    for row in np.argsort(-gain):
        if gain[row] < _price(observed) or len(found) == PLACES:
            break
        if skip[row] > 0 and all(abs(frames[row] - f) > APART_FRAMES for f, _ in found):
            found.append((float(frames[row]), float(skip[row])))
    return found


def _scores(observed: Observations, fit: Linearised) -> tuple[Floats, Floats]:
    """Time missing after each frame but the last, and by how much the loss falls with it."""
    rows = np.tile(np.arange(len(observed.frame)), 2)
    moved = (rows[:, None] > rows[: len(observed.frame) - 1]) * fit.velocity[:, None]
    shared = fit.jacobian.T @ moved
    inverse = np.linalg.pinv(fit.hessian, hermitian=True)
    slope = moved.T @ fit.data - shared.T @ (inverse @ fit.gradient)
    alone = (moved**2).sum(axis=0)
    curve = alone - (shared * (inverse @ shared)).sum(axis=0)
    known = curve > 1e-6 * alone
    safe = np.where(known, curve, 1.0)
    return np.where(known, -slope / safe, 0.0), np.where(known, slope**2 / safe / 2, 0.0)

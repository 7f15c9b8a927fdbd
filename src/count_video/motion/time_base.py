r"""Where frames may be left out of a burst: a test of every place, by the fit without any.

With the residuals r of a fit over their standard deviations, its Jacobian J and Hessian H, and the
velocities c of all places after a frame, a time s that passes unseen after that frame lets the loss
fall by

    (c' r)^2 / 2 (c' c - c' J H^-1 J' c)     for     s = -c' r / (c' c - c' J H^-1 J' c),

in the first order (Rao's score test). Where that outweighs what is expected of frames left out, a
fit with them there decides.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from count_video.motion.left_out import SIDE_FRAMES, LeftOut
from count_video.motion.observations import Observations, left_out_after
from count_video.motion.parameters import Column, Prior
from count_video.motion.priors import LEFT_OUT, SCATTERS
from count_video.motion.rivals import (
    FLOORS_PX,
    MOST_TRIED,
    PAIR,
    coarse_fits,
    fine_fit,
    neighbouring,
    with_deviations,
)
from count_video.motion.solving import Fit, Linearised, Noise, Question, Solution, noise_of
from count_video.motion.starting import MOST_COLLISIONS
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


def with_frames_left_out(
    observed: Observations,
    rough: Floats,
    prior: Prior,
    coarse: list[Solution],
    seen: int,
    gap: LeftOut | None,
) -> tuple[Observations, list[Solution]]:
    """Let frames be left out where that explains the track better, and fit the counts anew.

    Where some are known to be left out, in the ``gap``, their number is free.
    """
    price = _price(observed)
    free = prior.with_value(Column.SKIP, 0.0, np.inf)
    best = _Hypothesis(observed, coarse, _scattering(observed, prior, coarse))
    if gap is not None:
        other, start = left_out_after(observed, gap.after), rough.copy()
        start[Column.SKIP] = -gap.frames
        none = _hypothesis(other, start, prior, seen)
        some = _hypothesis(other, start, free, seen, coarse[0])
        some = min(some, best, key=lambda one: one.loss)
        likelier = none if none.loss < some.loss + price else some
        return other, likelier.coarse
    tried: set[float] = set()
    for _ in range(ROUNDS):
        before = best
        for frame, skip in (*_beside(best, prior), *_suspected(best, prior)):
            if frame in tried:
                continue
            tried.add(frame)
            start = before.coarse[0].values.copy()
            start[Column.SKIP] = skip
            begin = replace(before.coarse[0], values=start)
            some = _hypothesis(left_out_after(observed, frame), rough, free, seen, begin)
            dearer = 0.0 if best.observed.after.any() else price
            if some.best.values[Column.SKIP] > 0 and some.loss + dearer < best.loss:
                best = some
        if best is before:
            break
    return best.observed, best.coarse


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


@dataclass(frozen=True)
class _Hypothesis:
    observed: Observations
    coarse: list[Solution]
    best: Solution
    """With whole frames left out, and restitutions that scatter."""

    @property
    def loss(self) -> float:
        return self.best.loss


def _hypothesis(
    observed: Observations,
    rough: Floats,
    prior: Prior,
    seen: int,
    start: Solution | None = None,
) -> _Hypothesis:
    coarse = coarse_fits(observed, rough, prior, seen, start)
    return _Hypothesis(observed, coarse, _scattering(observed, prior, coarse))


def _scattering(observed: Observations, prior: Prior, coarse: list[Solution]) -> Solution:
    """Let the restitution scatter, which frames left out might be mistaken for."""
    noise = noise_of(observed, coarse[0].values, coarse[0].count, FLOORS_PX[-1])
    fits = {
        one.count: fine_fit(observed, noise, prior, one, SCATTERS[-1]) for one in coarse[:COUNTS]
    }
    while True:
        best = min(fits.values(), key=lambda fit: fit.loss)
        pairs = best.count - PAIR, best.count + PAIR
        near = [n for n in pairs if 0 < n <= MOST_COLLISIONS and n not in fits]
        if not near or len(fits) > MOST_TRIED:
            return best
        for count in near:
            start = replace(best, count=count, values=neighbouring(best, count))
            fits[count] = fine_fit(observed, noise, prior, start, SCATTERS[-1])


def _beside(hypothesis: _Hypothesis, prior: Prior) -> list[tuple[float, float]]:
    """Where near their place the frames that are left out explain the track best, and how many."""
    observed, best = hypothesis.observed, hypothesis.coarse[0]
    if not observed.after.any():
        return []
    noise = noise_of(observed, best.values, best.count, FLOORS_PX[-1])
    frames = observed.origin + observed.frame
    near = frames[np.abs(frames - frames[observed.after == 0][-1]) <= SIDE_FRAMES].tolist()
    losses = [
        Fit(Question(left_out_after(observed, frame), noise, prior, best.count), best.values).loss
        for frame in near
    ]
    return [(near[int(np.argmin(losses))], float(best.values[Column.SKIP]))]


def _suspected(hypothesis: _Hypothesis, prior: Prior) -> list[tuple[float, float]]:
    """Frames after which time seems to be missing and how much, the clearest first.

    By chance the largest of n such gains is about log n.
    """
    observed, best = hypothesis.observed, hypothesis.coarse[0]
    noise = noise_of(observed, best.values, best.count, FLOORS_PX[-1])
    skip, gain = _scores(
        observed, Fit(Question(observed, noise, prior, best.count), best.values).linearised
    )
    frames = observed.origin + observed.frame
    found: list[tuple[float, float]] = []
    for row in np.argsort(-gain):
        if gain[row] < np.log(len(gain)) or len(found) == PLACES:
            break
        if skip[row] > 0 and all(abs(frames[row] - f) > APART_FRAMES for f, _ in found):
            found.append((float(frames[row]), float(skip[row])))
    return found


def _scores(observed: Observations, fit: Linearised) -> tuple[Floats, Floats]:
    """Time missing after each frame but the last, and by how much the loss falls with it."""
    rows = np.arange(len(observed.frame))
    after = (rows[:, None] > rows[None, :-1])[fit.row]
    moved = after * fit.velocity[:, None]
    weighted = fit.jacobian * fit.weights[:, None]
    shared = weighted.T @ moved
    inverse = np.linalg.pinv(fit.hessian, hermitian=True)
    slope = moved.T @ (fit.weights * fit.data) - shared.T @ (inverse @ fit.gradient)
    alone = (moved**2 * fit.weights[:, None]).sum(axis=0)
    curve = alone - np.einsum("pr,pq,qr->r", shared, inverse, shared)
    known = curve > 1e-6 * alone
    safe = np.where(known, curve, 1.0)
    return np.where(known, -slope / safe, 0.0), np.where(known, slope**2 / safe / 2, 0.0)

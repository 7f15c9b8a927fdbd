r"""Where frames may be left out of a burst: a test of every place, by the fit without any.

With the residuals r of a fit over their standard deviations, its Jacobian J and Hessian H, and the
velocities c of all places after a frame, a time s that passes unseen after that frame lets the loss
fall by

    (c' r)^2 / 2 (c' c - c' J H^-1 J' c)     for     s = -c' r / (c' c - c' J H^-1 J' c),

in the first order (Rao's score test). Where that outweighs what is expected of frames left out,
fits with them there decide, in which the restitution scatters, for which they might be mistaken.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from count_video.motion.observations import Observations
from count_video.motion.parameters import Column, with_deviations
from count_video.motion.priors import LEFT_OUT, SCATTERS
from count_video.motion.rivals import FLOORS_PX, Rivals, loss_of
from count_video.motion.solving import Fit, Noise, Question, fine_fit, noise_of
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


def with_frames_left_out(coarse: Rivals, rough: Floats, seen: int, gap: LeftOut | None) -> Rivals:
    """Let frames be left out where that explains the track better, and fit the counts anew.

    Where some are known to be left out, in the ``gap``, their number is free.
    """
    price = _price(coarse.observed)
    if gap is not None:
        start = rough.copy()
        start[Column.SKIP] = -gap.frames
        there = coarse.observed.left_out_after(gap.after)
        none = replace(coarse, observed=there, fits={})
        none.scan(start, seen)
        none.climb()
        priced = ((none, 0.0), (coarse, price), (_skipping(coarse, there, -gap.frames), price))
        return min(priced, key=lambda one: _with_scatter(one[0]).loss + one[1])[0]
    best, fit, tried = coarse, None, set[float]()
    for _ in range(ROUNDS):
        before = best
        for frame, skip in (*_beside(before), *_suspected(before)):
            if frame in tried:
                continue
            tried.add(frame)
            fit = fit or _with_scatter(coarse)
            some = _skipping(before, coarse.observed.left_out_after(frame), skip)
            other, dearer = _with_scatter(some), price if best is coarse else 0.0
            if other.values[Column.SKIP] > 0 and other.loss + dearer < fit.loss:
                best, fit = some, other
        if best is before:
            break
    return best


def _skipping(even: Rivals, observed: Observations, skip: float) -> Rivals:
    """Fit with frames left out, from the best count and so many of them on."""
    values = even.best.values.copy()
    values[Column.SKIP] = skip
    free = even.prior.with_value(Column.SKIP, 0.0, np.inf)
    rivals = replace(even, observed=observed, prior=free, fits={})
    rivals.add(even.best.count, values)
    rivals.climb()
    return rivals


def _with_scatter(rivals: Rivals) -> Fit:
    """Fit the best counts with whole frames left out, and restitutions that scatter."""
    noise = _noise(rivals)
    best = sorted(rivals.fits.values(), key=loss_of)[:COUNTS]
    questions = [Question(rivals.observed, noise, rivals.prior, fit.count) for fit in best]
    fits = [fine_fit(*pair) for pair in zip(questions, (f.values for f in best), strict=True)]
    return min(fits, key=loss_of)


def _noise(rivals: Rivals) -> Noise:
    return noise_of(rivals.observed, rivals.best.values, rivals.best.count, FLOORS_PX[-1])


def lacks_frames(rivals: Rivals, fit: Fit, noise: Noise) -> bool:
    """Whether frames left out somewhere would explain the track better, in first order."""
    full = with_deviations(rivals.prior, fit.count, SCATTERS[-1])
    question = Question(rivals.observed, noise, full, fit.count)
    skip, gain = _scores(Fit(question, fit.values))
    return float(gain[skip > 0].max(initial=0.0)) > _price(rivals.observed)


def _price(observed: Observations) -> float:
    """By how much a fit with frames left out must be better: their prior, place and number."""
    return float(np.log(len(observed.frame) * MOST_FRAMES / LEFT_OUT))


def _beside(rivals: Rivals) -> list[tuple[float, float]]:
    """Where near their place the frames that are left out explain the track best, and how many."""
    observed, best = rivals.observed, rivals.best
    if not observed.after.any():
        return []
    frames = observed.origin + observed.frame
    near = frames[np.abs(frames - frames[observed.after == 0][-1]) <= SIDE_FRAMES].tolist()
    asked = Question(observed, _noise(rivals), rivals.prior, best.count)
    moved = [replace(asked, observed=observed.left_out_after(at)) for at in near]
    losses = [Fit(question, best.values).loss for question in moved]
    return [(near[int(np.argmin(losses))], float(best.values[Column.SKIP]))]


def _suspected(rivals: Rivals) -> list[tuple[float, float]]:
    """Frames after which time seems to be missing and how much, the clearest first."""
    observed, best = rivals.observed, rivals.best
    even = rivals.prior.with_value(Column.SKIP, 0.0, 0.0)
    skip, gain = _scores(Fit(Question(observed, _noise(rivals), even, best.count), best.values))
    frames = observed.origin + observed.frame
    found: list[tuple[float, float]] = []
    for row in np.argsort(-gain):
        if gain[row] < _price(observed) or len(found) == PLACES:
            break
        if skip[row] > 0 and all(abs(frames[row] - f) > APART_FRAMES for f, _ in found):
            found.append((float(frames[row]), float(skip[row])))
    return found


def _scores(fit: Fit) -> tuple[Floats, Floats]:
    """Time missing after each frame but the last, and by how much the loss falls with it."""
    linear, frames = fit.linearised, len(fit.observed.frame)
    rows = np.tile(np.arange(frames), 2)
    moved = (rows[:, None] > rows[: frames - 1]) * linear.velocity[:, None]
    shared = linear.jacobian.T @ moved
    slope = moved.T @ linear.data - shared.T @ (fit.covariance @ linear.gradient)
    alone = (moved**2).sum(axis=0)
    curve = alone - (shared * (fit.covariance @ shared)).sum(axis=0)
    known = curve > 1e-6 * alone
    safe = np.where(known, curve, 1.0)
    return np.where(known, -slope / safe, 0.0), np.where(known, slope**2 / safe / 2, 0.0)

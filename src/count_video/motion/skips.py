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

from count_video.motion.descent import NEARLY
from count_video.motion.observations import Observations
from count_video.motion.parameters import Column
from count_video.motion.priors import LEFT_OUT, SCATTERS
from count_video.motion.rivals import FLOORS_PX, Rivals
from count_video.motion.solving import Fit, Question, noise_of, solve
from count_video.motion.time_base import LeftOut
from count_video.motion.time_hypotheses import SIDE_FRAMES
from count_video.records import Floats

MOST_FRAMES = 24
"""So many frames may be left out of a burst: more hold most of it."""
ROUNDS = 3
"""So often a place is sought by the best fit until then."""


def with_frames_left_out(even: Rivals, gap: LeftOut | None, rough: Floats) -> Rivals:
    """Let frames be left out where that explains the track better, and fit the counts anew.

    Where some are known to be left out, in the ``gap``, their number is free, if that is among the
    frames of the burst.
    """
    price = _price(even.observed)
    if gap is not None and (later := even.observed.left_out_after(gap.after)).after.any():
        values = rough.copy()
        values[Column.SKIP] = -gap.frames
        there = _free(even, later)
        there.scan(values)
        there.climb()
        other, fit = _with_scatter(there), _with_scatter(even)
        dearer = price if other.values[Column.SKIP] != -gap.frames else 0.0
        return there if other.loss + dearer < fit.loss + price else even
    best, fit = even, _with_scatter(even)
    for _ in range(ROUNDS):
        suspect = _most_suspected(best, fit)
        if suspect is None:
            break
        start, frame, skip = suspect
        some = _skipping(best, start, even.observed.left_out_after(frame), skip)
        beside = _skipping(some, some.best, _placed(some), float(some.best.values[Column.SKIP]))
        some = min(some, beside, key=lambda one: one.best.loss)
        other, dearer = _with_scatter(some), price if best is even else 0.0
        if best is even and not other.values[Column.SKIP] and other.loss < fit.loss:
            # The search found what the one without frames left out had missed, and lacks none.
            even.add(other.count, other.values)
            even.climb()
            fit = _with_scatter(even)
            continue
        if not (other.values[Column.SKIP] > 0 and other.loss + dearer < fit.loss):
            break
        best, fit = some, other
    return best


def _free(even: Rivals, observed: Observations) -> Rivals:
    """Begin anew, with the number of frames that are left out free."""
    free = even.prior.with_value(Column.SKIP, 0.0, np.inf)
    return replace(even, observed=observed, prior=free, fits={})


def _most_suspected(rivals: Rivals, fit: Fit) -> tuple[Fit, float, float] | None:
    """Find the fit in which time seems to be missing most clearly, after which frame and how much.

    It is the best one, or that of another count which frames left out might make the best.
    """
    price, least = _price(fit.observed), rivals.best.loss
    others = [other for other in rivals.fits.values() if 0 < other.loss - least < price]
    found = [(*suspect, one) for one in (fit, *others) if (suspect := _suspected(one)) is not None]
    if not found:
        return None
    _, frame, skip, one = max(found, key=lambda suspect: suspect[0])
    return one, frame, skip


def _skipping(even: Rivals, fit: Fit, observed: Observations, skip: float) -> Rivals:
    """Fit with frames left out, from a fit and so many of them on."""
    values = fit.values.copy()
    values[Column.SKIP] = skip
    rivals = _free(even, observed)
    rivals.add(fit.count, values)
    rivals.climb()
    return rivals


def _placed(rivals: Rivals) -> Observations:
    """Place the frames left out near where they are, by the best fit as it is."""
    best, observed = rivals.best, rivals.observed
    frames = observed.origin + observed.frame
    near = frames[np.abs(frames - frames[observed.after == 0][-1]) <= SIDE_FRAMES].tolist()
    moved = [observed.left_out_after(at) for at in near]
    return min(moved, key=lambda one: Fit(replace(best.question, observed=one), best.values).loss)


def _with_scatter(rivals: Rivals) -> Fit:
    """Fit the best count with whole frames left out, and restitutions that scatter."""
    best = rivals.best
    noise = noise_of(rivals.observed, FLOORS_PX[-1])
    known = rivals.prior.with_value(Column.SKIP, 0.0, 0.0)
    question = Question(rivals.observed, noise, known, best.count, SCATTERS[-1])
    return solve(question, best.values, enough=NEARLY)


def _price(observed: Observations) -> float:
    """By how much a fit with frames left out must be better: their prior, place and number."""
    return float(np.log(len(observed.frame) * MOST_FRAMES / LEFT_OUT))


def _suspected(fit: Fit) -> tuple[float, float, float] | None:
    """Fall of the loss, frame after which time seems to be missing, and how much; None if none."""
    skip, gain = _scores(fit)
    row = int(np.argmax(np.where(skip > 0, gain, 0.0)))
    if gain[row] < _price(fit.observed) or not skip[row] > 0:
        return None
    frame = fit.observed.origin + fit.observed.frame[row]
    return float(gain[row]), float(frame), float(skip[row])


def _scores(fit: Fit) -> tuple[Floats, Floats]:
    """Time missing after each frame but the last, and by how much the loss falls with it."""
    linear, frames = fit.linearised, len(fit.observed.frame)
    covariance = fit.white
    rows = np.tile(np.arange(frames), 2)
    moved = (rows[:, None] > rows[: frames - 1]) * linear.velocity[:, None]
    shared = linear.jacobian.T @ moved
    slope = moved.T @ linear.data - shared.T @ (covariance @ linear.gradient)
    alone = (moved**2).sum(axis=0)
    curve = alone - (shared * (covariance @ shared)).sum(axis=0)
    known = curve > 1e-6 * alone
    safe = np.where(known, curve, 1.0)
    return np.where(known, -slope / safe, 0.0), np.where(known, slope**2 / safe / 2, 0.0)

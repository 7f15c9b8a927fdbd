"""Where frames may be left out of a burst: a test of every place, by the fit without any.

It is Rao's score test; docs/architecture.md has its formula. Where it outweighs what is expected of
frames left out, fits with them there decide.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from count_video.motion.descent import NEARLY
from count_video.motion.observations import Observations
from count_video.motion.parameters import Column
from count_video.motion.priors import LEFT_OUT, SCATTERS
from count_video.motion.rivals import FLOORS_PX, Rivals
from count_video.motion.solving import Fit, Question, solve
from count_video.records import Floats

MOST_FRAMES = 24
"""So many frames may be left out of a burst as a rule, and no more than there are."""
BESIDE_FRAMES = 8
"""Places so near to the one that is suspected are tried as well."""


def with_frames_left_out(even: Rivals) -> Rivals:
    """Let frames be left out where that explains the track better, and fit the counts anew.

    If the best fit with some left out is one with none, the search without ended elsewhere.
    """
    fit = _with_scatter(even)
    suspect = _most_suspected(even, fit)
    if suspect is None:
        return even
    start, frame, skip = suspect
    some = _skipping(even, start, even.observed.left_out_after(frame), skip)
    beside = _skipping(some, some.best, _placed(some), float(some.best.values[Column.SKIP]))
    some = min(some, beside, key=lambda one: one.best.loss)
    other = _with_scatter(some)
    skip = float(other.values[Column.SKIP])
    better = 0 <= skip <= len(even.observed.frame) and other.loss + _price(even.observed) < fit.loss
    if better and skip:
        return some
    if better:
        even.add(other.count, other.values)
        even.climb()
    return even


def _most_suspected(rivals: Rivals, fit: Fit) -> tuple[Fit, float, float] | None:
    """Find the fit that time which is missing would make the best, after which frame and how much.

    It is the best one, or that of another count which it would bring up to the best. None if it is
    worth its price nowhere.
    """
    price, least = _price(fit.observed), rivals.best.loss
    found = []
    for one in (fit, *(other for other in rivals.fits.values() if other.loss > least)):
        skip, gain = _scores(one)
        row = int(np.argmax(np.where(skip > 0, gain, 0.0)))
        behind = max(one.loss - least, 0.0)
        if skip[row] > 0 and gain[row] > max(price, behind):
            frame = one.observed.origin + one.observed.frame[row]
            found.append((float(gain[row]) - behind, float(frame), float(skip[row]), one))
    if not found:
        return None
    _, frame, skip_frames, one = max(found, key=lambda suspect: suspect[0])
    return one, frame, skip_frames


def _skipping(even: Rivals, fit: Fit, observed: Observations, skip: float) -> Rivals:
    """Fit with frames left out, from a fit and so many of them on."""
    values = fit.values.copy()
    values[Column.SKIP] = skip
    free = even.prior.with_value(Column.SKIP, 0.0, np.inf)
    rivals = replace(even, observed=observed, prior=free, fits={})
    rivals.add(fit.count, values)
    rivals.climb()
    return rivals


def _placed(rivals: Rivals) -> Observations:
    """Place the frames left out near where they are, by the best fit as it is."""
    best, observed = rivals.best, rivals.observed
    frames = observed.origin + observed.frame
    near = frames[np.abs(frames - frames[observed.after == 0][-1]) <= BESIDE_FRAMES].tolist()
    moved = [observed.left_out_after(at) for at in near]
    return min(moved, key=lambda one: Fit(replace(best.question, observed=one), best.values).loss)


def _with_scatter(rivals: Rivals) -> Fit:
    """Fit the best count with whole frames left out, and restitutions that scatter."""
    best = rivals.best
    noise_px = rivals.observed.noise_px(FLOORS_PX[-1])
    known = rivals.prior.with_value(Column.SKIP, 0.0, 0.0)
    question = Question(rivals.observed, noise_px, known, best.count, SCATTERS[-1])
    return solve(question, best.values, enough=NEARLY)


def _price(observed: Observations) -> float:
    """By how much a fit with frames left out must be better: their prior, place and number."""
    return float(np.log(len(observed.frame) * MOST_FRAMES / LEFT_OUT))


def _scores(fit: Fit) -> tuple[Floats, Floats]:
    """Time missing after each frame but the last, and by how much the loss falls with it."""
    linear, covariance = fit.linearised, fit.white
    velocity = linear.velocity[:, None]
    shared = _later(linear.jacobian * velocity)
    slope = _later(linear.data[:, None] * velocity)[:, 0] - shared @ (covariance @ fit.gradient)
    alone = _later(velocity**2)[:, 0]
    curve = alone - ((shared @ covariance) * shared).sum(axis=1)
    known = curve > 1e-6 * alone
    safe = np.where(known, curve, 1.0)
    return np.where(known, -slope / safe, 0.0), np.where(known, slope**2 / safe / 2, 0.0)


def _later(values: Floats) -> Floats:
    """Sum values of both bodies, shape (2 frames, columns), after each frame but the last."""
    each = values.reshape(2, -1, values.shape[1]).sum(axis=0)
    return np.asarray(np.cumsum(each[::-1], axis=0)[-2::-1])

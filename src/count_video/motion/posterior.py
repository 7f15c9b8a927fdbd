"""What fits give: the probability of each count, the set-up, and the collisions themselves.

Everything is a mean over all fits that come into question, each with its share: each has its own
best mass ratio, of which a single fit's uncertainty knows nothing. Their parameters are the motion
at the first collision; what a person set up by hand follows from them: the gap, the release (the
swing's amplitude before that), the gap between the bodies at rest, and the periods of the threads.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from count_video.motion.burst import TURN_AT_LEAST_PX
from count_video.motion.errors_of_places import HALF_EXPOSURE
from count_video.motion.parameters import Column, within_limits
from count_video.motion.pendulums import Paths, follow, slopes, stepped
from count_video.motion.priors import LEFT_OVER, MODEL_WRONG, UNEXPLAINED_WRONG
from count_video.motion.seen import SeenCollisions
from count_video.motion.solving import Fit
from count_video.motion.starting import MOST_COLLISIONS
from count_video.motion.time_base import TimeBase, left_out
from count_video.records import (
    Collision,
    Ending,
    EndingKind,
    Estimate,
    Floats,
    Velocities,
)


def shares_of(fits: Sequence[Fit]) -> Floats:
    """Probability of each fit of the same places, where errors last; shape (fits,), sums to 1.

    Of two whose places differ by d standard deviations, with errors of the correlations R, the
    logarithms of the likelihoods by white errors differ by a normal value of mean d'd / 2 and
    variance d'Rd. That of true likelihoods has twice its mean for a variance, so the part
    d'd / d'Rd of the difference holds, of each against the likeliest; where errors change from
    frame to frame more than white ones do, no more than all of it.
    """
    likeliest = max(fits, key=lambda fit: fit.evidence)
    apart = np.stack([fit.data - likeliest.data for fit in fits], axis=1)
    white, variance = (apart**2).sum(axis=0), (apart * likeliest.correlated(apart)).sum(axis=0)
    holds = np.divide(white, variance, out=np.ones_like(white), where=variance > white)
    shares = np.exp(holds * np.array([fit.evidence - likeliest.evidence for fit in fits]))
    return np.asarray(shares / shares.sum())


def with_more(chances: Mapping[int, float], more: Mapping[int, float]) -> dict[int, float]:
    """Add to each count as many as there may be more, or fewer, each with its probability.

    None is fewer than 0.
    """
    total: dict[int, float] = {}
    for count, chance in chances.items():
        for number, share in more.items():
            other = max(0, count + number)
            total[other] = total.get(other, 0.0) + chance * share
    return dict(sorted(total.items()))


def doubted(chances: Mapping[int, float], left_over: float = 0.0) -> dict[int, float]:
    """Leave some probability to what the model does not know: one collision more or fewer.

    It is the more, the more of the places the model leaves over, as a multiple of their noise.
    """
    usual, power = LEFT_OVER
    wrong = MODEL_WRONG * max(1.0, left_over / usual) ** power
    wrong = min(wrong, UNEXPLAINED_WRONG)
    near = {-1: wrong / 2, 0: 1 - wrong, 1: wrong / 2}
    return {number: chance for number, chance in with_more(chances, near).items() if chance >= 1e-6}


DRAWS = 200
FOLLOWED = 12
"""Collisions after the clip's end that are foreseen at first, and again where that is too few."""


def end_chances(fit: Fit) -> dict[int, float]:
    """Probability that the burst has so many collisions more than were fitted; -1 is one fewer.

    Draws from the fit's uncertainty are followed. More are those between the clip's end and the
    heavy body's turn; one that the frames would have to show is none, as the fit has decided on
    those. One fewer it is where the body had turned before the last.
    """
    rng = np.random.default_rng(0)  # the same clip gets the same answer
    widths, vectors = np.linalg.eigh(fit.covariance)
    normal = rng.normal(size=(DRAWS, len(widths)))
    drawn = fit.values + (normal * np.sqrt(np.maximum(widths, 0.0))) @ vectors.T
    count, observed = fit.count, fit.observed
    end, followed = observed.end + fit.values[Column.SKIP], 0
    going = np.ones(DRAWS, bool)
    while going.any() and count + followed < MOST_COLLISIONS:
        followed += max(FOLLOWED, followed)
        paths = follow(within_limits(drawn), count + followed, observed.start, fitted=count)
        turn, time = turns(paths), paths.time[:, count]
        late = (turn[:, count - 1] < time) & np.isfinite(time)
        more, going = np.where(late, -1, 0), ~late
        for last in range(count, count + followed):
            following = paths.time[:, last + 1]
            going &= (following > end) & (following < turn[:, last])
            more += going
    return {number: float(np.mean(more == number)) for number in sorted(set(more.tolist()))}


def turns(paths: Paths) -> Floats:
    """Give the times at which the heavy body, driven back, would turn to the wall, (sets, pieces).

    Each is that of the turn after the event that starts a piece. One that a ball of its own mass
    brought to rest is not driven back: there is no turn, the time is inf.
    """
    (rate, rest), (heavy, velocity) = paths.laws[:2, :, None], paths.states[:2]
    with np.errstate(invalid="ignore"):
        # It turns toward the wall where it is farthest from it, not where it is nearest.
        phase = np.arctan2(velocity, rate * (heavy - rest)) % (2 * np.pi)
        farthest = rest + np.hypot(heavy - rest, velocity / rate)
        driven_back = farthest - np.minimum.accumulate(heavy, axis=1) > TURN_AT_LEAST_PX
        return np.where(driven_back, paths.time + phase / rate, np.inf)


# ---- the set-up and the energies -----------------------------------------------------------------


def mixed(shares: Floats, values: Floats, variances: Floats) -> tuple[Floats, Floats]:
    """Mean and standard deviation over fits with shares that sum to 1: in each and between them.

    ``values`` and ``variances`` have shape (fits, ...), the results (...).
    """
    mean = np.tensordot(shares, values, 1)
    return mean, np.sqrt(np.tensordot(shares, variances + (values - mean) ** 2, 1))


def setup_estimates(fits: Sequence[Fit]) -> list[Estimate]:
    """Mass ratio, restitutions of the bodies and of the wall, and the fields of the set-up."""
    values = [_arranged(fit.values) for fit in fits]
    by_columns = [slopes(_arranged(stepped(fit.values))) for fit in fits]
    pairs = zip(by_columns, fits, strict=True)
    variances = [np.diag(by @ fit.covariance @ by.T) for by, fit in pairs]
    estimates = zip(*mixed(shares_of(fits), np.array(values), np.array(variances)), strict=True)
    return [Estimate(float(mean), float(sigma)) for mean, sigma in estimates]


def _arranged(values: Any) -> list[Any]:
    """Derive what is stated of a trial from parameters, shape (columns, ...)."""
    rate = np.exp(values[Column.SWING])
    from_rest = -values[Column.HEAVY_PULL] / rate**2
    period = 2.0 * np.pi / rate
    return [
        np.exp(-values[Column.LIGHTNESS]),
        values[Column.BODIES],
        values[Column.BOUNCE],
        values[Column.BALL_REST] - values[Column.WALL],
        np.sqrt(from_rest**2 + (values[Column.HEAVY_RATE] / rate) ** 2),
        values[Column.HEAVY] - from_rest - values[Column.BALL_REST],
        period,
        period * np.exp(-values[Column.BALL_SWING]),
    ]


DISSIPATED_BELOW = 0.1
"""With less than this share of the energy left, losses have ended the burst."""
AT_REST_SHARE = 0.02
"""A velocity within this share of the first one is as good as none."""


def energy_kept(fit: Fit) -> Floats:
    """Energy after each collision over that before the first, shape (events,).

    Kinetic and, on the threads, potential energy of both bodies, in units of the heavy mass.
    """
    paths = fit.paths
    after = _energy(paths, fit.values, paths.states[:, 0, 1:])
    return np.asarray(after / _energy(paths, fit.values, paths.before[:, 0, 1:2]))


def _energy(paths: Paths, values: Floats, states: Floats) -> Floats:
    rate, rest, ball_rate, _, ball_rest = paths.laws[:, 0]
    heavy, heavy_velocity, ball, ball_velocity = states
    swung, ball_swung = rate * (heavy - rest), ball_rate * (ball - ball_rest)
    light = np.exp(values[Column.LIGHTNESS]) * (ball_velocity**2 + ball_swung**2)
    return np.asarray(heavy_velocity**2 + swung**2 + light) / 2


def ending_of(fit: Fit, count: int) -> Ending:
    """How the burst ended, by its state after the last of so many collisions."""
    kept, paths = float(energy_kept(fit)[count - 1]), fit.paths
    heavy, ball = (paths.states[[1, 3], 0, count] / abs(paths.before[1, 0, 1])).tolist()
    kind: EndingKind = "pendulum"
    if kept < DISSIPATED_BELOW:
        kind = "dissipative"
    elif -AT_REST_SHARE <= ball <= heavy + AT_REST_SHARE:
        kind = "geometric"
    return Ending(kind, kept, heavy, ball)


def left_out_of(fit: Fit) -> TimeBase:
    """Give the pictures their times by a fit, which may find frames left out between two."""
    observed, frames = fit.observed, round(fit.values[Column.SKIP])
    return left_out(observed.origin + float(observed.frame[observed.after == 0][-1]), frames)


# ---- collisions ----------------------------------------------------------------------------------

UNSURE_FRAMES = 0.5
"""Standard uncertainty of what happens between two pictures where frames are left out."""


def collisions_of(fits: Sequence[Fit], found: SeenCollisions, count: int) -> tuple[Collision, ...]:
    """So many collisions of a burst by fits of one number, the likeliest first."""
    fit = fits[0]
    values, sigmas = _events(fits, count)
    base = left_out_of(fit)
    if base.notes:
        hidden = (base.time[1] < values[:, 0]) & (values[:, 0] < base.time[2])
        sigmas[hidden, 0] = np.maximum(sigmas[hidden, 0], UNSURE_FRAMES)
    else:
        hidden = np.zeros(count, dtype=bool)
    modelled = [
        base.shown(_modelled(fit.observed.sign, event, *row))
        for event, row in enumerate(zip(values, sigmas, strict=True))
    ]
    return _confirmed(
        modelled, hidden, [one for one in found.collisions[: found.burst] if one.seen]
    )


def _events(fits: Sequence[Fit], count: int) -> tuple[Floats, Floats]:
    """Time, state before and state after each event, and their sigmas; (events, 9) each."""
    values, variances = [], []
    for fit in fits:
        paths, tangents = fit.paths, fit.tangents
        by = np.hstack([tangents.time[:, None], tangents.arriving, tangents.states[1:]])[:count]
        by = np.where(np.isfinite(by), by, 0.0)
        variances.append(np.maximum(((by @ fit.covariance) * by).sum(axis=-1), 0.0))
        frames = fit.observed.origin + paths.time[:, 1:]
        values.append(np.vstack([frames, paths.before[:, 0, 1:], paths.states[:, 0, 1:]]).T[:count])
    return mixed(shares_of(fits), np.array(values), np.array(variances))


def _modelled(sign: int, event: int, values: Floats, sigmas: Floats) -> Collision:
    """One collision by the model, in whose motion all frames share."""
    # After the time come place and velocity of the heavy body and those of the ball, before and
    # after the event.
    rates = np.array([[4, 2], [8, 6]])
    velocities = np.hstack([sign * values[rates], sigmas[rates]]).tolist()
    before, after = (Velocities(*each) for each in velocities)
    return Collision(
        kind="wall" if event % 2 else "bodies",
        frame=float(values[0]),
        frame_sigma=float(sigmas[0]),
        seen=False,
        position_px=sign * float(values[7]),
        velocity_before=before,
        velocity_after=after,
    )


def _confirmed(
    modelled: Sequence[Collision], hidden: NDArray[np.bool_], seen: Sequence[Collision]
) -> tuple[Collision, ...]:
    """Let frames confirm the collisions that they show, but for those that must be ``hidden``.

    It is the one seen that is nearer to it than to its neighbours, and of its kind.
    The time is the mean of both, weighted by their precisions. Where they differ by more than their
    uncertainties, something else acted there or frames misled, and the mean is less sure by the
    Birge ratio (Birge 1932).
    """
    # What never happens lies at infinity, and may do so more than once.
    frames = np.minimum([one.frame for one in modelled], np.finfo(np.float64).max)
    apart = np.diff(frames, prepend=-np.inf, append=np.inf)
    halves = np.minimum(apart[:-1], apart[1:]) / 2
    # No frame is clear of its neighbours on either side of it: the exposures hold them all.
    hidden = hidden | (np.maximum(apart[:-1], apart[1:]) < 2 * HALF_EXPOSURE)
    confirmed = []
    for one, half, unseen in zip(modelled, halves.tolist(), hidden, strict=True):
        near = [o for o in seen if o.kind == one.kind and abs(o.frame - one.frame) <= half]
        if unseen or not near:
            confirmed.append(one)
            continue
        partner = min(near, key=lambda other: abs(other.frame - one.frame))
        off = partner.frame - one.frame
        sigma = float(np.hypot(one.frame_sigma, partner.frame_sigma))
        frame = one.frame + off * one.frame_sigma**2 / sigma**2
        # Both rest on the same frames, so that the mean is no surer than the better one.
        surest = min(one.frame_sigma, partner.frame_sigma) * max(1.0, abs(off) / sigma)
        confirmed.append(replace(one, frame=frame, frame_sigma=surest, seen=True))
    return tuple(confirmed)

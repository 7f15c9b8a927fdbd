"""Count what lies between the frames: the door of this room.

A model of the whole burst is fitted to the track for each number of collisions that comes into
question. What the frames show of the motion on both sides, what single frames caught in the thick
of it, and the bend of the heavy body's path decide between them; the theory's count does not enter.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from count_video.between.ending import chance_of_more
from count_video.between.energy import ending_of, energy_kept
from count_video.between.events import collisions_of
from count_video.between.forward import forward_fit
from count_video.between.observations import Observations, observe
from count_video.between.parameters import Column, Prior
from count_video.between.rivals import (
    SCATTERS,
    Knowledge,
    coarse_fits,
    fine_fit,
    log_evidence,
    prior_of,
    recounted,
)
from count_video.between.solving import Noise, Solution, modelled, noise_of, scaled
from count_video.between.starting import rough_values
from count_video.collisions.seen import SeenCollisions
from count_video.records import Collision, Ending, Estimate, Floats, Track

FRAMES_AT_LEAST = 20
MISFIT_SIGMAS = 8.0
"""The model does not describe a track from which it strays by more than so many sigmas, ..."""
MISFIT_SHARE = 0.005
"""... or by this share of the ball's diameter, as a root mean square."""
DOUBT = 0.02
"""Share of counts that turn out wrong for reasons outside the model."""
MOST_COLLISIONS = 120
"""Each collision has a restitution of its own in the fit: many more would take minutes."""
RIVALS = 5
"""Counts that are fitted finely."""
HOPELESS = 150.0
"""A count whose loss exceeds the best by so much needs no further look."""
NOTHING_KNOWN = Knowledge()
CORRELATED_AT_MOST = 12
"""Lag in frames up to which residuals may hang together."""


@dataclass(frozen=True)
class Between:
    """What the fitted model says of a burst."""

    count: int
    probability: dict[int, float]
    """Of each count; sums to 1."""
    collisions: tuple[Collision, ...]
    """The burst, numbered from 1; real times are not filled in."""
    mass_ratio: Estimate
    restitution_bodies: Estimate
    restitution_wall: Estimate
    energy_kept: tuple[float, ...]
    """Energy after each collision over that before the first."""
    ending: Ending
    misfit_px: float
    """Root mean square of what the model leaves unexplained of the ball's places."""


@dataclass(frozen=True)
class Misfit:
    """The model does not describe the track."""

    reason: str
    """A clause for the user."""


def count_between(
    track: Track, found: SeenCollisions, known: Knowledge = NOTHING_KNOWN
) -> Between | Misfit:
    """Fit the model to a track and count the collisions of its burst.

    Parameters
    ----------
    track
        A track of both bodies.
    found
        What its frames show; at least one collision.
    known
        What is known besides.
    """
    observed = observe(track, found)
    start = _start(observed, found, known)
    if isinstance(start, Misfit):
        return start
    rough, prior = start
    coarse = coarse_fits(observed, rough, prior, found.burst)
    if not np.isfinite(coarse[0].loss):
        return Misfit("no motion of two bodies and a wall resembles the track")
    fits, noise = _fine_fits(observed, prior, coarse[:RIVALS])
    strayed = _strayed(fits[0], observed, track)
    if strayed is not None:
        return strayed
    return _answer(found, observed, _rival_fits(observed, noise, prior, fits))


def measure_burst(
    track: Track, found: SeenCollisions, known: Knowledge = NOTHING_KNOWN
) -> Between | Misfit:
    """Fit the model to a burst whose collisions are all seen, for what it tells of the physics.

    Parameters as for ``count_between``; the count is the number seen and stays so.
    """
    observed = observe(track, found)
    start = _start(observed, found, known)
    if isinstance(start, Misfit):
        return start
    rough, prior = start
    coarse = forward_fit(observed, rough, prior, found)
    if not np.isfinite(coarse.loss):
        return Misfit("no motion of two bodies and a wall has these collisions")
    fits, noise = _fine_fits(observed, prior, [coarse])
    strayed = _strayed(fits[0], observed, track)
    if strayed is not None:
        return strayed
    fit = fine_fit(observed, noise, prior, fits[0], SCATTERS[len(SCATTERS) // 2])
    measured = _answer(found, observed, [(0.0, fit)])
    if not all(collision.seen for collision in measured.collisions):
        return Misfit("the fitted collisions are not those that were seen")
    return measured


def _start(
    observed: Observations, found: SeenCollisions, known: Knowledge
) -> tuple[Floats, Prior] | Misfit:
    """Rough parameters and the prior; a misfit where there is nothing to begin with."""
    before = int((observed.frame < -1).sum())
    if len(observed.frame) < FRAMES_AT_LEAST or before < 3:
        return Misfit("too few frames surround the collisions to fit a model of the motion to them")
    rough = rough_values(observed, found.collisions[: found.burst], known.expected_rate)
    expected = np.pi / np.exp(rough[Column.LIGHTNESS] / 2)
    if expected > MOST_COLLISIONS:
        return Misfit(
            f"some {expected:.0f} collisions are to be expected, too many to fit each "
            f"(at most {MOST_COLLISIONS})"
        )
    return rough, prior_of(rough, known)


def _strayed(solution: Solution, observed: Observations, track: Track) -> Misfit | None:
    """Say so if the model does not describe the track."""
    misfit_px = _root_mean_square(solution)
    limit = max(MISFIT_SIGMAS * observed.ball_sigma_px, MISFIT_SHARE * track.ball_diameter_px)
    if misfit_px <= limit:
        return None
    return Misfit(
        f"the modelled motion strays from the track by {misfit_px:.1f} px where "
        f"{limit:.1f} are allowed: something else than two swinging bodies and a wall took part"
    )


def _fine_fits(
    observed: Observations, prior: Prior, coarse: list[Solution]
) -> tuple[list[Solution], Noise]:
    """Fit the likeliest counts finely, best first, and widen the noise to what is left over."""
    noise = _noise_at(observed, coarse[0])
    scatter = SCATTERS[len(SCATTERS) // 2]
    fits: list[Solution] = []
    for solution in coarse:
        bearable = min((fit.loss for fit in fits), default=np.inf) + HOPELESS
        fits.append(fine_fit(observed, noise, prior, solution, scatter, bearable))
    fits.sort(key=lambda solution: solution.loss)
    best = fits[0]
    noise = _noise_at(observed, best)
    return fits, scaled(
        noise,
        _inflation(best.ball_residuals / noise.ball),
        _inflation(best.heavy_residuals / noise.heavy),
    )


def _noise_at(observed: Observations, solution: Solution) -> Noise:
    _, sampled = modelled(observed, solution.values[None], solution.count)
    return noise_of(observed, sampled)


def _inflation(residuals: np.ndarray) -> float:
    """Factor on the noise for residuals that are larger than it, or hang together."""
    kept = residuals[np.isfinite(residuals)]
    if len(kept) < FRAMES_AT_LEAST:
        return 1.0
    spread = float(np.sqrt(np.mean(np.clip(kept, -6, 6) ** 2)))
    centred = np.clip(kept, -6, 6) / max(spread, 1e-9)
    together = 1.0
    for lag in range(1, min(CORRELATED_AT_MOST, len(kept) // 4)):
        correlation = float(np.mean(centred[lag:] * centred[:-lag]))
        if correlation < 2 / np.sqrt(len(kept)):
            break
        together += 2 * correlation
    return max(1.0, spread) * float(np.sqrt(together))


def _root_mean_square(solution: Solution) -> float:
    """Of the ball's residuals, the worst fiftieth aside."""
    squares = np.sort(solution.ball_residuals[np.isfinite(solution.ball_residuals)] ** 2)
    return float(np.sqrt(squares[: max(1, int(0.98 * len(squares)))].mean()))


def _rival_fits(
    observed: Observations, noise: Noise, prior: Prior, rivals: list[Solution]
) -> list[tuple[float, Solution]]:
    """Logarithm of the evidence and the fit, for each count and each scatter."""
    best = rivals[0]
    near = [rival for rival in rivals if rival.loss < best.loss + HOPELESS]
    starts = {rival.count: rival for rival in reversed(near)}
    for count in (best.count - 1, best.count + 1):
        starts.setdefault(count, replace(best, count=count, values=recounted(best, count)))
    fits: list[tuple[float, Solution]] = []
    for start in starts.values():
        solution = start
        for scatter in SCATTERS[::-1]:
            bearable = min((fit.loss for _, fit in fits), default=np.inf) + HOPELESS
            solution = fine_fit(observed, noise, prior, solution, scatter, bearable)
            fits.append((log_evidence(solution, scatter), solution))
            if solution.loss > bearable:
                break
    return [fit for fit in fits if np.isfinite(fit[0])]


def _answer(
    found: SeenCollisions,
    observed: Observations,
    fits: list[tuple[float, Solution]],
) -> Between:
    chances = _probabilities(fits)
    count = max(chances, key=lambda number: chances[number])
    solution = max((fit for fit in fits if fit[1].count == count), key=lambda fit: fit[0])[1]
    more = 0.0 if found.burst < len(found.collisions) else chance_of_more(observed, solution)
    values, sigmas = solution.values, _sigmas(solution)
    paths, _ = modelled(observed, values[None], count)
    ratio = float(np.exp(-values[Column.LIGHTNESS]))
    return Between(
        count=count,
        probability=_doubted(_shifted(chances, count, more), count),
        collisions=collisions_of(observed, solution, found),
        mass_ratio=Estimate(ratio, ratio * float(sigmas[Column.LIGHTNESS])),
        restitution_bodies=Estimate(float(values[Column.BODIES]), float(sigmas[Column.BODIES])),
        restitution_wall=Estimate(float(values[Column.BOUNCE]), float(sigmas[Column.BOUNCE])),
        energy_kept=tuple(float(share) for share in energy_kept(paths, values)),
        ending=ending_of(paths, values),
        misfit_px=_root_mean_square(solution),
    )


def _sigmas(solution: Solution) -> Floats:
    """Give the standard uncertainties of the parameters."""
    variances = np.diag(np.linalg.pinv(solution.hessian, hermitian=True))
    return np.asarray(np.sqrt(np.maximum(variances, 0.0)))


def _probabilities(fits: list[tuple[float, Solution]]) -> dict[int, float]:
    highest = max(evidence for evidence, _ in fits)
    shares: dict[int, float] = {}
    for evidence, solution in fits:
        share = float(np.exp(evidence - highest))
        shares[solution.count] = shares.get(solution.count, 0.0) + share
    total = sum(shares.values())
    return {count: share / total for count, share in shares.items()}


def _shifted(chances: dict[int, float], count: int, more: float) -> dict[int, float]:
    """Give the chance that one more collision follows the clip's end to the next count."""
    shifted = dict(chances)
    moved = more * shifted[count]
    shifted[count] -= moved
    shifted[count + 1] = shifted.get(count + 1, 0.0) + moved
    return shifted


def _doubted(chances: dict[int, float], count: int) -> dict[int, float]:
    doubted = {number: chance * (1 - DOUBT) for number, chance in chances.items()}
    for number in (count - 1, count + 1):
        doubted[number] = doubted.get(number, 0.0) + DOUBT / 2
    kept = {number for number, chance in doubted.items() if chance >= 1e-6} | {count}
    return {number: doubted[number] for number in sorted(kept)}

"""The heavy body's path through the burst: its swing, and the steps that the ball gave it.

Single velocity steps of the heavy body drown in noise at 1:100, their sum does not. Between the
collisions it swings on its threads, x'' = -w^2 (x - x0), and momentum that the ball takes is
momentum that it gives. So its whole path is linear in five unknowns:

    x(t) = a + b t + w^2 x0 t^2 / 2 - w^2 * (second integral of x) + r * sum_i s_i * max(t - t_i, 0)

with the ball's velocity steps -s_i at the times t_i of the `bodies` collisions and r = m/M.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from count_video.motion.burst import CLEAR_VELOCITY_SIGMAS
from count_video.motion.gaps import Gaps
from count_video.records import Collision, Floats
from count_video.signals import integral, sigma_of

FRAMES_BEYOND = 60.0
"""The path is used this far before the first and after the last collision."""
POINTS_AT_LEAST = 20
"""Places, besides one for each step that is not shown."""
UNSHOWN_AT_MOST = 0.34
"""Share of the velocity steps that need not be shown."""
STRAY_AT_LEAST_PX, STRAY_SHARE, STRAY_SIGMAS = 0.5, 0.004, 3.0
"""A heavy body that was followed rightly, through collisions that are all known, strays less than
this from its path, or than this share of its way (lenses bend a straight line, converted clips
blend pictures), or than so many standard deviations of its places."""
REST_SIGMAS = 3.0
"""A body that stays this close to where it is first seen is still at rest."""
MOVES_AT_LEAST_PX = 2.0
"""What moves less all along is scenery. The heavy body comes and goes by more than the ball hangs
from it, which is more than two bodies can be distinguished by."""
CORRELATED_FRAMES = 10
"""What is left over is not white (reflections creep over polished brass): so many neighbouring
frames count as one."""


@dataclass(frozen=True)
class Swing:
    """What the heavy body's path gives."""

    mass_ratio: float
    """Heavy over light mass, from the velocity steps; not positive where these show none."""
    mass_ratio_relative_sigma: float
    """Its standard uncertainty as a share of the value."""
    rate_squared: float
    """Square of the pendulum's angular rate, in (radians per frame) squared; may come out
    negative where the swing is too short to show."""
    rate_squared_sigma: float
    stray_px: float
    """RMS by which the places stray from the path."""
    places: int
    """How many these are."""
    fits: bool
    """Whether the body moves as one that swings and collides so. If it does not, a body was
    mistaken for another or for scenery, or collisions are missing."""

    @property
    def is_clear(self) -> bool:
        """Whether the steps of its velocity show clearly, and so the mass ratio."""
        return CLEAR_VELOCITY_SIGMAS * self.mass_ratio_relative_sigma < 1


def fit_swing(
    gaps: Gaps, collisions: Sequence[Collision], reach: Sequence[float] = ()
) -> Swing | None:
    """Fit the heavy body's path; None where steps are not shown, or nothing can be solved.

    Distances are those of ``gaps``. The uncertainties hold the scatter about the path, which is
    used about the collisions and about the frame coordinates that it has to ``reach``.
    """
    bodies = [collision for collision in collisions if collision.kind == "bodies"]
    times = np.array([collision.frame for collision in bodies])
    steps = gaps.sign * np.array(
        [c.velocity_after.ball_px_frame - c.velocity_before.ball_px_frame for c in bodies]
    )
    if len(steps) == 0 or np.isnan(steps).mean() > UNSHOWN_AT_MOST:
        return None
    ends = np.array([times[0], times[-1], *reach])
    used = gaps.frame > ends.min() - FRAMES_BEYOND
    used &= gaps.frame < ends.max() + FRAMES_BEYOND
    used &= np.isfinite(gaps.heavy_px) & (gaps.frame >= _let_go(gaps, times[0]))
    frame, place = gaps.frame[used], gaps.heavy_px[used]
    if len(frame) < POINTS_AT_LEAST + np.isnan(steps).sum():
        return None
    return _solved(_law(frame, place, times, steps), place, sigma_of(gaps.heavy_px))


def _solved(law: Floats, place: Floats, noise_px: float) -> Swing | None:
    if np.linalg.matrix_rank(law) < law.shape[1]:
        return None
    inverse = np.linalg.pinv(law)
    solution = inverse @ place
    squares = float(np.sum((place - law @ solution) ** 2))
    variance = CORRELATED_FRAMES * squares / (len(place) - len(solution))
    sigma = np.sqrt(variance * (inverse**2).sum(axis=1))
    (rate_squared, share), way = solution[3:5].tolist(), float(np.ptp(place))
    stray = float(np.sqrt(squares / len(place)))
    return Swing(
        mass_ratio=1 / share if share else np.inf,
        mass_ratio_relative_sigma=float(sigma[4] / share) if share else np.inf,
        rate_squared=rate_squared,
        rate_squared_sigma=float(sigma[3]),
        stray_px=stray,
        places=len(place),
        fits=way >= MOVES_AT_LEAST_PX
        and stray < max(STRAY_AT_LEAST_PX, STRAY_SHARE * way, STRAY_SIGMAS * noise_px),
    )


def _law(frame: Floats, place: Floats, times: Floats, steps: Floats) -> Floats:
    """Columns of which the path is made, shape (n, 5 and more)."""
    clock, shown = frame - frame[0], np.isfinite(steps)
    twice = integral(frame, integral(frame, place - place.mean()))
    ramps = np.maximum(frame[:, None] - times, 0.0)
    given = -ramps[:, shown] @ steps[shown]
    law = np.stack([np.ones_like(clock), clock, clock**2, -twice, given], axis=1)
    # A step that is not shown is an unknown of its own.
    return np.hstack([law, ramps[:, ~shown]])


def _let_go(gaps: Gaps, first: float) -> float:
    """Frame from which the heavy body swings: before, a hand or a magnet may hold it at rest."""
    seen = np.isfinite(gaps.heavy_px) & (gaps.frame < first)
    if not seen.any():
        return -np.inf
    frame, place = gaps.frame[seen], gaps.heavy_px[seen]
    away = np.abs(place - place[0]) > REST_SIGMAS * sigma_of(gaps.heavy_px)
    return float(frame[np.argmax(away)]) if away.any() else -np.inf

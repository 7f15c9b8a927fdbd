"""A counted clip beside its plan: what was set up otherwise, and what that did to the count."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

from count_video.errors import UsageError
from count_video.physics.setup import Setup
from count_video.physics.simulator import simulate
from count_video.physics.theory import collision_count
from count_video.planning.request import PlanRequest
from count_video.records import (
    ComparedQuantity,
    Estimate,
    FittedSetup,
    PlanComparison,
    TrialResult,
)

DIAMETER_SIGMA_PX = 0.3
"""Standard uncertainty of the ball's width in the picture, which is the scale: on sixty rendered
clips of known truth the errors have a root mean square of 0.24 px."""


def compared(result: TrialResult, request: PlanRequest) -> TrialResult:
    """Add the comparison with a plan to a result."""
    setup = request.setup()
    planned = simulate(setup).count
    theory = collision_count(request.heavy, request.light)
    found = [] if result.setup is None else list(_found(result, result.setup, setup))
    quantities = tuple(
        ComparedQuantity(one.name, one.planned, one.found, _count(setup, [one])) for one in found
    )
    found_count = _count(setup, found) if found else None
    comparison = PlanComparison(
        planned_count=planned,
        theory=theory,
        found_count=found_count,
        quantities=quantities,
        explained_by=_explanation(result.count, (planned, theory, found_count), quantities),
    )
    return replace(result, comparison=comparison)


class _Found(NamedTuple):
    """One quantity, and the set-up with it as it was found."""

    name: str
    planned: float
    found: Estimate
    into: Callable[[Setup], Setup]


def _found(result: TrialResult, fitted: FittedSetup, setup: Setup) -> Iterator[_Found]:
    """Yield each quantity that was found, in the units of its name."""
    yield from _lengths(result, fitted, setup)
    yield from _periods(result, fitted, setup)
    ratio = setup.heavy_mass_kg / setup.light_mass_kg
    if result.mass_ratio is not None:
        estimate = Estimate(result.mass_ratio, result.mass_ratio_sigma or 0.0)
        heavy_kg = estimate.value * setup.light_mass_kg
        yield _Found("mass_ratio", ratio, estimate, lambda s: replace(s, heavy_mass_kg=heavy_kg))
    bodies, wall = result.restitution_bodies, result.restitution_wall
    if bodies is not None:
        kept = min(max(bodies.value, 0.0), 1.0)
        yield _Found(
            "restitution_bodies",
            setup.restitution_bodies,
            bodies,
            lambda s: replace(s, restitution_bodies=kept),
        )
    if wall is not None:
        back = min(max(wall.value, 0.0), 1.0)
        yield _Found(
            "restitution_wall",
            setup.restitution_wall,
            wall,
            lambda s: replace(s, restitution_wall=back),
        )


def _lengths(result: TrialResult, fitted: FittedSetup, setup: Setup) -> Iterator[_Found]:
    """Yield gap, release and the gap between the bodies, where there is a scale."""
    scale, diameter = result.millimetres_per_px, result.ball_diameter_px
    if scale is None or diameter is None:
        return
    gap, release, bodies = (
        _in_mm(one, scale, DIAMETER_SIGMA_PX / diameter)
        for one in (fitted.gap_px, fitted.release_px, fitted.bodies_gap_px)
    )
    yield _Found(
        "gap_mm", 1e3 * setup.wall_gap_m, gap, lambda s: replace(s, wall_gap_m=gap.value / 1e3)
    )
    yield _Found(
        "release_mm",
        1e3 * setup.release_m,
        release,
        lambda s: replace(s, release_m=release.value / 1e3),
    )
    yield _Found(
        "bodies_gap_mm",
        1e3 * setup.bodies_gap_m,
        bodies,
        lambda s: replace(s, bodies_gap_m=bodies.value / 1e3),
    )


def _periods(result: TrialResult, fitted: FittedSetup, setup: Setup) -> Iterator[_Found]:
    """Yield the periods of both threads, where the camera's rate is known."""
    rate = result.capture_fps
    if rate is None:
        return
    heavy, ball = (
        Estimate(one.value / rate, one.sigma / rate)
        for one in (fitted.heavy_period_frames, fitted.ball_period_frames)
    )
    gravity = setup.gravity_m_s2
    yield _Found(
        "heavy_period_s",
        2.0 * math.pi * math.sqrt(setup.heavy_thread_m / gravity),
        heavy,
        lambda s: replace(s, heavy_thread_m=_thread_m(heavy, gravity)),
    )
    yield _Found(
        "ball_period_s",
        2.0 * math.pi * math.sqrt(setup.light_thread_m / gravity),
        ball,
        lambda s: replace(s, light_thread_m=_thread_m(ball, gravity)),
    )


def _in_mm(length_px: Estimate, scale: float, relative: float) -> Estimate:
    """Turn px into mm; the uncertainty of the scale, a share of it, adds to that of the length."""
    return Estimate(
        length_px.value * scale, scale * math.hypot(length_px.sigma, relative * length_px.value)
    )


def _thread_m(period_s: Estimate, gravity_m_s2: float) -> float:
    return gravity_m_s2 * (period_s.value / (2.0 * math.pi)) ** 2


def _count(setup: Setup, found: Sequence[_Found]) -> int | None:
    """Count of a set-up with some quantities as they were found; None where that is impossible."""
    try:
        for one in found:
            setup = one.into(setup)
        return simulate(setup).count
    except UsageError:  # such as a cylinder inside the ball, by the errors of a fit
        return None


def _explanation(
    counted: int | None,
    counts: tuple[int, int, int | None],
    quantities: tuple[ComparedQuantity, ...],
) -> tuple[str, ...]:
    """Name what turns the planned count into the counted one; see ``PlanComparison``."""
    planned, theory, together = counts
    if counted is None or counted in (planned, theory):
        return ()
    alone = [one for one in quantities if one.count == counted]
    if alone:
        return tuple(one.name for one in sorted(alone, key=_surest))
    return tuple(one.name for one in quantities) if together == counted else ()


def _surest(quantity: ComparedQuantity) -> float:
    """Order by the difference in standard uncertainties, the largest first."""
    off = abs(quantity.found.value - quantity.planned)
    return -off / quantity.found.sigma if quantity.found.sigma else -math.inf

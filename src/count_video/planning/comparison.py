"""A counted clip beside what it should have counted: by its masses, its own fit, and its plan."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from count_video.errors import UsageError
from count_video.physics.setup import Setup
from count_video.physics.simulator import NO_COUNT, simulate_many
from count_video.physics.theory import collision_count
from count_video.planning.request import PlanRequest, most_collisions
from count_video.records import (
    ComparedQuantity,
    Estimate,
    FittedSetup,
    PlanComparison,
    TrialResult,
)

SIGMAS = 2.0
"""A mass ratio lies this many standard uncertainties about its value with a chance of 95 %."""
DIAMETER_SIGMA_PX = 0.3
"""Standard uncertainty of the ball's width in the picture, which is the scale: on sixty rendered
clips of known truth the errors have a root mean square of 0.24 px."""


@dataclass(frozen=True)
class Expected:
    """Counts to hold the counted number against."""

    free: tuple[int, int]
    """Fewest and most collisions of free bodies without losses, within the uncertainty of the mass
    ratio."""
    hanging: int | None
    """Count of the same bodies with the fitted threads, gaps and release; None without a fit."""
    with_losses: int | None
    """Count with the fitted restitutions as well; None where the bodies would come to rest on
    each other in ever smaller bounces, of which there is no number."""


def expected_counts(result: TrialResult) -> Expected | None:
    """Return what the result's own physics says of its count; None without a mass ratio."""
    ratio = result.mass_ratio
    if ratio is None or not (math.isfinite(ratio) and ratio > 0):
        return None
    low, high = ratio_range(result)
    free = (collision_count(low), collision_count(high))
    hung = None if result.setup is None else _as_fitted(result.setup, ratio)
    if hung is None:
        return Expected(free, None, None)
    return Expected(free, *_counts([hung, _with_losses(hung, result)], max(free)))


def ratio_range(result: TrialResult) -> tuple[float, float]:
    """Return the mass ratios that are likely, low and high; both alike where it was given."""
    ratio, sigma = result.mass_ratio or math.nan, result.mass_ratio_sigma or 0.0
    # A ratio stays above 0, however little is known of it.
    reach = min(SIGMAS * sigma, 0.5 * ratio) if math.isfinite(sigma) else 0.5 * ratio
    return ratio - reach, ratio + reach


def compared(result: TrialResult, request: PlanRequest) -> TrialResult:
    """Add the comparison with a plan to a result.

    Raises
    ------
    UsageError
        If the planned set-up has no count.
    """
    setup = request.setup()
    theory = collision_count(request.heavy, request.light)
    found = [] if result.setup is None else list(_found(result, result.setup, setup))
    as_found = _changed(setup, found) if found else None
    each = [_changed(setup, [one]) for one in found]
    planned, found_count, *counts = _counts([setup, as_found, *each], theory)
    if planned is None:
        raise UsageError("the planned bodies come to rest on each other; plan harder ones")
    quantities = tuple(
        ComparedQuantity(one.name, one.planned, one.found, count)
        for one, count in zip(found, counts, strict=True)
    )
    comparison = PlanComparison(
        planned_count=planned,
        theory=theory,
        found_count=found_count,
        quantities=quantities,
        explained_by=_explanation(result.count, (planned, theory, found_count), quantities),
    )
    return replace(result, comparison=comparison)


class _Found(NamedTuple):
    """One quantity that was planned and found, both in the unit of its name."""

    name: str
    planned: float
    found: Estimate
    field: str
    """The field of a set-up that it stands for, ..."""
    value: float
    """... and what was found in that field's unit."""


def _found(result: TrialResult, fitted: FittedSetup, setup: Setup) -> Iterator[_Found]:
    """Yield each quantity that was found: lengths with a scale, times with the camera's rate."""
    scale, diameter, rate = result.millimetres_per_px, result.ball_diameter_px, result.capture_fps
    if scale is not None and diameter is not None:
        for name, planned_m, length_px, field in (
            ("gap_mm", setup.wall_gap_m, fitted.gap_px, "wall_gap_m"),
            ("release_mm", setup.release_m, fitted.release_px, "release_m"),
            ("bodies_gap_mm", setup.bodies_gap_m, fitted.bodies_gap_px, "bodies_gap_m"),
        ):
            # The uncertainty of the scale, a share of it, adds to that of the length.
            off_px = DIAMETER_SIGMA_PX / diameter * length_px.value
            sigma = scale * math.hypot(length_px.sigma, off_px)
            length = Estimate(length_px.value * scale, sigma)
            least = 0.0 if field == "wall_gap_m" else -math.inf  # the ball hangs off the wall
            value = max(least, length.value / 1e3)
            yield _Found(name, 1e3 * planned_m, length, field, value)
    if rate is not None:
        gravity = setup.gravity_m_s2
        for name, planned_m, frames, field in (
            ("heavy_period_s", setup.heavy_thread_m, fitted.heavy_period_frames, "heavy_thread_m"),
            ("ball_period_s", setup.light_thread_m, fitted.ball_period_frames, "light_thread_m"),
        ):
            period = Estimate(frames.value / rate, frames.sigma / rate)
            planned_s = 2.0 * math.pi * math.sqrt(planned_m / gravity)
            yield _Found(name, planned_s, period, field, _thread_m(period.value, gravity))
    ratio = result.ratio
    if ratio is not None:
        light_kg = setup.light_mass_kg
        planned = setup.heavy_mass_kg / light_kg
        yield _Found("mass_ratio", planned, ratio, "heavy_mass_kg", ratio.value * light_kg)
    for name, share in (
        ("restitution_bodies", result.restitution_bodies),
        ("restitution_wall", result.restitution_wall),
    ):
        if share is not None:
            yield _Found(name, getattr(setup, name), share, name, _as_share(share.value))


def _thread_m(period_s: float, gravity_m_s2: float) -> float:
    return gravity_m_s2 * (period_s / (2.0 * math.pi)) ** 2


def _as_share(restitution: float) -> float:
    """Return a restitution as a set-up takes it; a measured one may exceed 1 a little."""
    return min(max(restitution, 0.0), 1.0)


def _changed(setup: Setup, found: Iterable[_Found]) -> Setup | None:
    """Return a set-up with some quantities as they were found; None where that is impossible."""
    try:
        return replace(setup, **{one.field: one.value for one in found})  # type: ignore[arg-type]
    except UsageError:  # such as a cylinder inside the ball, by the errors of a fit
        return None


def _counts(setups: Sequence[Setup | None], theory: int) -> list[int | None]:
    """Count of each set-up; None where there is none, or bodies come to rest on each other."""
    there = [setup for setup in setups if setup is not None]
    counts = iter(simulate_many(there, most_collisions(theory)).count.tolist())
    found = [None if setup is None else next(counts) for setup in setups]
    return [None if count == NO_COUNT else count for count in found]


def _explanation(
    counted: int | None,
    counts: tuple[int, int, int | None],
    quantities: Sequence[ComparedQuantity],
) -> tuple[str, ...]:
    """Name what turns the planned count into the counted one; see ``PlanComparison``."""
    planned, theory, together = counts
    if counted is None or counted in (planned, theory):
        return ()

    def in_sigmas(one: ComparedQuantity) -> float:
        off = abs(one.found.value - one.planned)
        return off / one.found.sigma if one.found.sigma else math.inf

    alone = [one for one in quantities if one.count == counted]
    if alone:
        return tuple(one.name for one in sorted(alone, key=in_sigmas, reverse=True))
    return tuple(one.name for one in quantities) if together == counted else ()


def _as_fitted(fitted: FittedSetup, mass_ratio: float) -> Setup | None:
    """Return the fitted set-up, lossless; None where it is none.

    The swings are small, hence linear, and no count depends on the units: a px stands for a metre
    and a frame for a second.
    """
    gravity = Setup.gravity_m_s2
    try:
        return Setup(
            heavy_mass_kg=mass_ratio,
            light_mass_kg=1.0,
            heavy_thread_m=_thread_m(fitted.heavy_period_frames.value, gravity),
            light_thread_m=_thread_m(fitted.ball_period_frames.value, gravity),
            wall_gap_m=max(0.0, fitted.gap_px.value),
            bodies_gap_m=fitted.bodies_gap_px.value,
            release_m=fitted.release_px.value,
        )
    except UsageError:  # a fit may leave a period at infinity, where no threads show
        return None


def _with_losses(lossless: Setup, result: TrialResult) -> Setup | None:
    """Return a set-up with the restitutions of a result; None where these are not known."""
    bodies, wall = result.restitution_bodies, result.restitution_wall
    if bodies is None or wall is None or not math.isfinite(bodies.value + wall.value):
        return None
    return replace(
        lossless,
        restitution_bodies=_as_share(bodies.value),
        restitution_wall=_as_share(wall.value),
    )

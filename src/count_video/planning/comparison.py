"""A counted clip beside what it should have counted: by its masses, its own fit, and its plan."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from count_video.errors import UsageError
from count_video.physics.setup import Setup
from count_video.physics.simulator import NO_COUNT, simulate_many
from count_video.physics.theory import collision_count
from count_video.planning.request import MOST_RATIO, PlanRequest, most_collisions
from count_video.records import ComparedQuantity, Estimate, FittedSetup, PlanComparison, TrialResult

DIAMETER_SIGMA_PX = 0.3
"""Standard uncertainty of the ball's width in the picture, which is the scale: on sixty rendered
clips of known truth the errors have a root mean square of 0.24 px."""
Changes = Mapping[str, float]
"""Fields of a set-up with other values."""


@dataclass(frozen=True)
class Expected:
    """Counts to hold the counted number against."""

    free: tuple[int, int]
    """Fewest and most collisions of free bodies without losses, within the uncertainty of the mass
    ratio."""
    hanging: int | None
    """Count of the same bodies with the fitted threads, gaps and release; None without a fit, or
    for masses of a ratio that cannot be planned either."""
    with_losses: int | None
    """Count with the fitted restitutions as well; None where the bodies would come to rest on
    each other in ever smaller bounces, of which there is no number."""


def expected_counts(result: TrialResult) -> Expected | None:
    """Return what the result's own physics says of its count; None without a mass ratio."""
    ratio = result.mass_ratio
    if ratio is None or not (math.isfinite(ratio) and ratio > 0):
        return None
    low, high = ratio_range(Estimate(ratio, result.mass_ratio_sigma or 0.0))
    free = (collision_count(low), collision_count(high))
    if ratio < 1.0 <= high:
        ratio = 1.0  # the cylinder is no lighter than the ball, which would drive it back at once
    fitted = result.setup if ratio <= MOST_RATIO else None
    hung = None if fitted is None else _as_fitted(fitted, ratio)
    lossy, (bodies, wall) = None, (result.restitution_bodies, result.restitution_wall)
    if hung and bodies and wall and math.isfinite(bodies.value + wall.value):
        lossy = _changed(hung, _losses(bodies, "bodies") | _losses(wall, "wall"))
    return Expected(free, *_counts([hung, lossy], free[1]))


def ratio_range(ratio: Estimate) -> tuple[float, float]:
    """Return the mass ratios that are likely, low and high: 95 %, or both alike if it was given."""
    half = 0.5 * ratio.value  # a ratio stays above 0, however little is known of it
    reach = min(2.0 * ratio.sigma, half) if math.isfinite(ratio.sigma) else half
    return ratio.value - reach, ratio.value + reach


def compared(result: TrialResult, request: PlanRequest) -> TrialResult:
    """Add the comparison with a plan to a result; UsageError if the planned set-up has no count."""
    setup = request.setup()
    theory = collision_count(request.heavy, request.light)
    found = [] if result.setup is None else list(_found(result, result.setup, setup))
    each = [changes for *_, changes in found]
    together = {name: value for changes in each for name, value in changes.items()}
    setups = [_changed(setup, changes) for changes in ({}, together, *each)]
    planned, found_count, *counts = _counts(setups, theory)
    if planned is None:
        raise UsageError("the planned bodies come to rest on each other; plan harder ones")
    quantities = tuple(
        ComparedQuantity(name, value, estimate, count)
        for (name, value, estimate, _), count in zip(found, counts, strict=True)
    )
    explained_by: tuple[str, ...] = ()
    if result.count not in (None, planned, theory):
        alone = [one for one in quantities if one.count == result.count]
        ordered = sorted(alone, key=_in_sigmas, reverse=True)
        if not alone and found_count == result.count:
            ordered = list(quantities)
        explained_by = tuple(one.name for one in ordered)
    comparison = PlanComparison(
        planned, theory, found_count if found else None, quantities, explained_by
    )
    return replace(result, comparison=comparison)


def _in_sigmas(one: ComparedQuantity) -> float:
    off = abs(one.found.value - one.planned)
    return off / one.found.sigma if one.found.sigma else math.inf


def _found(
    result: TrialResult, fitted: FittedSetup, setup: Setup
) -> Iterator[tuple[str, float, Estimate, Changes]]:
    """Yield the name of each quantity that was found, as planned, as found, and as set-up.

    Lengths are known with a scale, times with the camera's rate.
    """
    scale, diameter, rate = result.millimetres_per_px, result.ball_diameter_px, result.capture_fps
    if scale is not None and diameter is not None:
        for name, field, least in (
            ("gap", "wall_gap_m", 0.0),  # the ball hangs off the wall
            ("release", "release_m", -math.inf),
            ("bodies_gap", "bodies_gap_m", -math.inf),
        ):
            length_px: Estimate = getattr(fitted, f"{name}_px")
            # The uncertainty of the scale, a share of it, adds to that of the length.
            off_px = DIAMETER_SIGMA_PX / diameter * length_px.value
            sigma = scale * math.hypot(length_px.sigma, off_px)
            length = Estimate(length_px.value * scale, sigma)
            planned = 1e3 * getattr(setup, field)
            yield f"{name}_mm", planned, length, {field: max(least, length.value / 1e3)}
    if rate is not None:
        for body, field in (("heavy", "heavy_thread_m"), ("ball", "light_thread_m")):
            frames: Estimate = getattr(fitted, f"{body}_period_frames")
            period = Estimate(frames.value / rate, frames.sigma / rate)
            planned = 2.0 * math.pi * math.sqrt(getattr(setup, field) / setup.gravity_m_s2)
            thread = {field: _thread_m(period.value, setup.gravity_m_s2)}
            yield f"{body}_period_s", planned, period, thread
    ratio = result.ratio
    if ratio is not None:
        yield "mass_ratio", setup.heavy_mass_kg, ratio, {"heavy_mass_kg": ratio.value}
    for pair in ("bodies", "wall"):
        name, share = f"restitution_{pair}", getattr(result, f"restitution_{pair}")
        if share is not None:
            yield name, getattr(setup, name), share, _losses(share, pair)


def _losses(restitution: Estimate, pair: str) -> dict[str, float]:
    """Restitution as a set-up takes it; a measured one may exceed 1 a little."""
    return {f"restitution_{pair}": min(max(restitution.value, 0.0), 1.0)}


def _thread_m(period_s: float, gravity_m_s2: float) -> float:
    return gravity_m_s2 * (period_s / (2.0 * math.pi)) ** 2


def _changed(setup: Setup, changes: Changes) -> Setup | None:
    """Return a set-up with other values; None where that is impossible.

    Such as a cylinder inside the ball, by the errors of a fit.
    """
    try:
        return replace(setup, **changes)  # type: ignore[arg-type]
    except UsageError:
        return None


def _counts(setups: Sequence[Setup | None], theory: int) -> list[int | None]:
    """Count of each set-up; None where there is none, or bodies come to rest on each other."""
    there = [setup for setup in setups if setup is not None]
    counts = iter(simulate_many(there, most_collisions(theory)).count.tolist())
    found = [None if setup is None else next(counts) for setup in setups]
    return [None if count == NO_COUNT else count for count in found]


def _as_fitted(fitted: FittedSetup, mass_ratio: float) -> Setup | None:
    """Return the fitted set-up, lossless; None where a period is infinite: no threads show.

    The swings are small, hence linear, and no count depends on the units: a px stands for a metre
    and a frame for a second.
    """
    return _changed(
        Setup(),
        {
            "heavy_mass_kg": mass_ratio,
            "light_mass_kg": 1.0,
            "heavy_thread_m": _thread_m(fitted.heavy_period_frames.value, Setup.gravity_m_s2),
            "light_thread_m": _thread_m(fitted.ball_period_frames.value, Setup.gravity_m_s2),
            "wall_gap_m": max(0.0, fitted.gap_px.value),
            "bodies_gap_m": fitted.bodies_gap_px.value,
            "release_m": fitted.release_px.value,
        },
    )

"""What a plan and a counted clip say of each other, for a person."""

from __future__ import annotations

from collections.abc import Sequence

from count_video.records import ComparedQuantity, PlanComparison

NAMES = {
    "gap_mm": ("gap", "mm"),
    "release_mm": ("release", "mm"),
    "bodies_gap_mm": ("gap between the bodies", "mm"),
    "heavy_period_s": ("period of the cylinder", "s"),
    "ball_period_s": ("period of the ball", "s"),
    "mass_ratio": ("mass ratio", ""),
    "restitution_bodies": ("restitution, bodies", ""),
    "restitution_wall": ("restitution, wall", ""),
}
"""What the quantities are called, and their units."""
_DECIMALS = {"mm": 1, "s": 3, "": 3}
DIFFERENT_SIGMAS = 2.0
"""A difference of more standard uncertainties than this is marked."""


def comparison_sentence(comparison: PlanComparison, count: int | None) -> str:
    """Say what was planned, what was found, and what explains the difference."""
    text = f"{comparison.planned_count} collisions, theory {comparison.theory}"
    if count is None:
        return f"{text}; the clip is not counted"
    if not comparison.quantities:
        return f"{text}; the frames do not show the set-up"
    if comparison.found_count is not None:
        text += f"; the set-up that was found gives {comparison.found_count}"
    return f"{text}; {_reason(comparison, count)}"


def _reason(comparison: PlanComparison, count: int) -> str:
    names = [NAMES[name][0] for name in comparison.explained_by]
    if count == comparison.planned_count:
        if count == comparison.theory:
            return "it came out as planned"
        return f"{count} is what was planned: the swing and the losses differ from the theory"
    if len(names) == len(comparison.quantities) and len(names) > 1:
        return f"all differences together make it {count}, none alone does"
    if names:
        return f"the {_listed(names)} alone makes it {count}"
    if count == comparison.theory:
        return "it came out as the theory has it"
    return f"no single difference explains {count}"


def _listed(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} or {names[-1]}"


def comparison_lines(comparison: PlanComparison) -> list[str]:
    """Write the table of quantities; no line where nothing was found."""
    if not comparison.quantities:
        return []
    head = f"  {'set-up':<28}{'planned':>11}{'found':>11}{'+-':>9}{'alone gives':>13}"
    return [head, *(_line(one) for one in comparison.quantities)]


def _line(one: ComparedQuantity) -> str:
    name, unit = NAMES[one.name]
    decimals = _DECIMALS[unit]
    planned, found, sigma = (
        f"{value:.{decimals}f}" for value in (one.planned, one.found.value, one.found.sigma)
    )
    label = f"{name}, {unit}" if unit else name
    alone = "-" if one.count is None else str(one.count)
    off = abs(one.found.value - one.planned) > DIFFERENT_SIGMAS * one.found.sigma
    mark = " *" if off else ""
    return f"  {label:<28}{planned:>11}{found:>11}{sigma:>9}{alone:>13}{mark}"

"""Tables of plain text: the collisions, and a plan beside what a clip shows of it.

A column is a heading and a width; a cell is text already. Columns in which no row has anything
to say (times without a capture rate, a heavy body that is not there) are left out.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from count_video.records import Collision, ComparedQuantity, PlanComparison

NOT_KNOWN = "-"


@dataclass(frozen=True)
class _Column:
    group: str
    """Heading shared with the columns beside it; empty for none."""
    heading: str
    width: int
    """Least number of characters, the gap before the column included."""
    cell: Callable[[Collision], str]
    align: str = ">"
    """``>`` for numbers, ``<`` for words."""


def collision_lines(collisions: Sequence[Collision], count: int | None) -> list[str]:
    """Lay the collisions out in rows; those after number ``count`` follow under a line of words."""
    columns = [column for column in _COLUMNS if _says_something(column, collisions)]
    lines = _headings(columns)
    for previous, collision in enumerate(collisions):
        if previous == count:
            lines.append("  after the heavy body turned back:")
        lines.append(_row(columns, [column.cell(collision) for column in columns]))
    if not all(collision.seen for collision in collisions):
        lines.append("  * inferred between frames")
    return lines


def _headings(columns: Sequence[_Column]) -> list[str]:
    # A group's name stands over its first column and runs on over the others of the group.
    groups = ""
    end = 0
    for place, column in enumerate(columns):
        if column.group and (place == 0 or columns[place - 1].group != column.group):
            groups = groups.ljust(end + 4) + column.group
        end += column.width
    heading_row = _row(columns, [column.heading for column in columns])
    return [groups, heading_row] if groups else [heading_row]


def _row(columns: Sequence[_Column], cells: Sequence[str]) -> str:
    paired = zip(columns, cells, strict=True)
    # A cell wider than its column keeps its gap: the row grows, the numbers never touch.
    return "".join(f" {cell:{c.align}{c.width - 1}}" for c, cell in paired).rstrip()


def _says_something(column: _Column, collisions: Sequence[Collision]) -> bool:
    return any(column.cell(collision) != NOT_KNOWN for collision in collisions)


def _fixed(value: float | None, decimals: int) -> str:
    if value is None or not math.isfinite(value):
        return NOT_KNOWN
    return f"{value:.{decimals}f}"


_COLUMNS = (
    _Column("", "no.", 6, lambda c: str(c.number)),
    _Column("", " kind", 9, lambda c: f" {c.kind}" if c.seen else f" {c.kind}*", "<"),
    _Column("", "frame", 10, lambda c: _fixed(c.frame, 2)),
    _Column("", "time/s", 10, lambda c: _fixed(c.time_s, 5)),
    _Column("", "ball/px", 9, lambda c: _fixed(c.position_px, 1)),
    _Column("ball px/frame", "before", 9, lambda c: _fixed(c.velocity_before.ball_px_frame, 3)),
    _Column("ball px/frame", "after", 9, lambda c: _fixed(c.velocity_after.ball_px_frame, 3)),
    _Column("heavy px/frame", "before", 9, lambda c: _fixed(c.velocity_before.heavy_px_frame, 3)),
    _Column("heavy px/frame", "after", 9, lambda c: _fixed(c.velocity_after.heavy_px_frame, 3)),
)

# ---- a plan and what was found ------------------------------------------------------------------

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

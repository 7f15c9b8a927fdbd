"""The collisions as a table of plain text.

A column is a heading and a width; a cell is text already. Columns in which no row has anything
to say (times without a capture rate, a heavy body that is not there) are left out.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from count_video.records import Collision

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

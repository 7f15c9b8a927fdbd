"""docs/accuracy.md's table of accuracy: run this file to print it anew.

python tests/counted/accuracy.py
"""

from __future__ import annotations

import sys
from pathlib import Path
from statistics import median

from counting import answer, fixture_clips, time_errors, truth_of

HEADER = ("Clip", "True count", "Counted", "Median error of a time", "Largest")
ALIGNMENT = ("---", "---:", "---:", "---:", "---:")


def resolved_clips() -> list[Path]:
    """The fixtures whose frames can show every collision."""
    return [clip for clip in fixture_clips() if truth_of(clip)["resolved"]]


def errors_frames(clip: Path) -> tuple[float, float]:
    """Median and largest distance of a collision from its true place, in frames."""
    errors = time_errors(truth_of(clip)["events"], answer(clip))
    return median(errors), max(errors)


def table() -> list[str]:
    """Lines of Markdown, a clip a line."""
    rows = [HEADER, ALIGNMENT]
    for clip in resolved_clips():
        middle, largest = errors_frames(clip)
        counts = str(truth_of(clip)["count"]), str(answer(clip)["count"])
        rows.append((f"`{clip.name}`", *counts, f"{middle:.3f} frames", f"{largest:.2f} frames"))
    return [f"| {' | '.join(row)} |" for row in rows]


if __name__ == "__main__":
    sys.stdout.write("\n".join(table()) + "\n")

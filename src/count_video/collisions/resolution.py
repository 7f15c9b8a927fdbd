"""Judge whether the frames show every collision, or some may lie between them.

Two checks on neighbouring collisions: they must be of different kinds (the ball cannot strike the
same thing twice without striking the other, unless it turned round visibly by itself), and the
frames between them must lie on the one smooth path that leads from contact to contact.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from count_video.collisions.candidates import Candidate, signal_of
from count_video.collisions.gaps import Gaps
from count_video.signals import sigma_of

RESOLVED_FRAMES = 2.5
"""From this interval on every flight of the ball holds at least one frame clear of corners."""
TURN_FRAMES = 12
"""A ball that turns round by itself between two collisions of a kind is seen for so long."""


def unresolved(candidates: Sequence[Candidate], gaps: Gaps, pace: float) -> list[str]:
    """Say which collisions may be missing; empty if the pictures show them all.

    Candidates and gaps count in pictures, of which each takes ``pace`` frames.
    """
    found = []
    for before, after in pairwise(candidates):
        if before.kind == after.kind and not _turned(before, after, gaps):
            what = "cylinder" if before.kind == "wall" else "wall"
            span = f"{before.frame * pace:.1f} and {after.frame * pace:.1f}"
            found.append(
                f"between frames {span} a collision of the ball with the {what} was missed"
            )
    shortest = shortest_interval(candidates)
    if shortest < RESOLVED_FRAMES:
        found.append(
            f"collisions follow each other within {shortest:.1f} pictures, less than the "
            f"{RESOLVED_FRAMES} that show each for certain; film at a higher rate"
        )
    return found


def shortest_interval(candidates: Sequence[Candidate]) -> float:
    """Shortest time between neighbouring collisions in frames; inf for fewer than two."""
    return min((b.frame - a.frame for a, b in pairwise(candidates)), default=float("inf"))


def _turned(before: Candidate, after: Candidate, gaps: Gaps) -> bool:
    """Whether the gap opened and closed again smoothly, over many frames."""
    signal = signal_of(before.kind, gaps)
    inside = (gaps.frame > before.frame + 1) & (gaps.frame < after.frame - 1)
    inside &= np.isfinite(signal)
    if inside.sum() < TURN_FRAMES:
        return False
    frame, values = gaps.frame[inside], signal[inside]
    smooth = np.polynomial.Polynomial.fit(frame, values, 4)
    left_over = float(np.sqrt(np.mean((values - smooth(frame)) ** 2)))
    return left_over < 4 * sigma_of(signal)

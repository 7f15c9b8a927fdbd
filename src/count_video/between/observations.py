"""What the fit is to explain: the places of both bodies around the burst, frame by frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from count_video.collisions.gaps import Gaps, gaps_of
from count_video.collisions.seen import SeenCollisions
from count_video.records import Collision, Floats, Track
from count_video.signals import sigma_of

FRAMES_BEYOND = 60.0
"""The path is used this far before the first and after the last collision seen."""
CLEAR_FRAMES = 1.0
"""And not nearer than this to a collision after the burst."""
MOST_FRAMES = 700
"""More are thinned out: in a long flight neighbouring frames tell the same."""


@dataclass(frozen=True)
class Observations:
    """Places around a burst; arrays have shape (frames,), NaN where not seen."""

    origin: float
    """Frame coordinate of the model's time 0: the first collision."""
    frame: Floats
    """Frame times, counted from the origin."""
    ball_px: Floats
    """The ball's centre, away from the wall."""
    heavy_px: Floats
    """The heavy body's face less the ball's near half: where the ball's centre is in contact."""
    ball_sigma_px: float
    """White noise of one frame."""
    heavy_sigma_px: float
    last: float
    """Time of the last collision of the burst that was seen."""
    end: float
    """Time of the last frame of the clip."""
    sign: int
    """+1 where distances grow with the position in the picture."""


def observe(track: Track, found: SeenCollisions) -> Observations:
    """Cut out of a track what belongs to the first burst.

    Raises
    ------
    ValueError
        If no collision was seen.
    """
    if not found.burst:
        raise ValueError("no collision seen: there is no burst to explain")
    gaps = gaps_of(track)
    burst = found.collisions[: found.burst]
    chosen = _chosen(gaps, burst, found.collisions[found.burst :])
    near_edge = float(np.nanmedian(gaps.heavy_px - gaps.ball_px - gaps.gap_px))
    return Observations(
        origin=burst[0].frame,
        frame=gaps.frame[chosen] - burst[0].frame,
        ball_px=gaps.ball_px[chosen],
        heavy_px=gaps.heavy_px[chosen] - near_edge,
        ball_sigma_px=sigma_of(gaps.ball_px),
        heavy_sigma_px=sigma_of(gaps.heavy_px),
        last=burst[-1].frame - burst[0].frame,
        end=float(gaps.frame[-1]) - burst[0].frame,
        sign=gaps.sign,
    )


def _chosen(gaps: Gaps, burst: Sequence[Collision], after: Sequence[Collision]) -> np.ndarray:
    first, last = burst[0].frame, burst[-1].frame
    stop = after[0].frame - CLEAR_FRAMES if after else np.inf
    inside = (gaps.frame > first - FRAMES_BEYOND) & (gaps.frame < min(stop, last + FRAMES_BEYOND))
    chosen = np.flatnonzero(inside)
    return chosen[:: -(-len(chosen) // MOST_FRAMES)] if len(chosen) else chosen

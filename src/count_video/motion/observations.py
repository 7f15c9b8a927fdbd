"""What the fit is to explain: the places of both bodies around the burst, frame by frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from count_video.motion.gaps import Gaps, gaps_of
from count_video.motion.parameters import Column, drift_shape
from count_video.motion.seen import SeenCollisions
from count_video.motion.swing import FRAMES_BEYOND
from count_video.records import Collision, Floats, Track
from count_video.signals import sigma_of

APART_FRAMES = 1.0
"""The path is not used nearer than this to a collision after the burst."""
BURSTS_BEYOND = 2.0
"""The last collision may follow the one before it only after so many times the burst until then."""
FRAMES_A_FLIGHT = 16
"""A long flight between two collisions is thinned out to so many frames: neighbouring ones say
the same."""
MOST_BUSY_FRAMES = 500
"""Where collisions lie close together all frames are kept, up to this number."""


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
    drift: Floats
    """Share of each rise in the drift of the heavy body's outline, shape (frames, DRIFTS)."""
    ball_sigma_px: float
    """White noise of one frame."""
    heavy_sigma_px: float
    last: float
    """Time of the last collision of the burst that was seen."""
    end: float
    """Time of the last frame of the clip."""
    sign: int
    """+1 where distances grow with the position in the picture."""
    after: Floats
    """1 for frames after the place where frames may be left out, 0 for the others."""

    @cached_property
    def places_px(self) -> Floats:
        """Places of ball and heavy body, one after the other, shape (2 frames,)."""
        return np.concatenate([self.ball_px, self.heavy_px])

    def times(self, sets: Floats) -> Floats:
        """Give the frames' times by the clocks of parameter sets; shape (sets, frames)."""
        return np.asarray(self.frame + sets[:, Column.SKIP, None] * self.after)


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
        drift=drift_shape(gaps.heavy_px[chosen]),
        ball_sigma_px=sigma_of(gaps.ball_px),
        heavy_sigma_px=sigma_of(gaps.heavy_px),
        last=burst[-1].frame - burst[0].frame,
        end=float(gaps.frame[-1]) - burst[0].frame,
        sign=gaps.sign,
        after=np.zeros(len(chosen)),
    )


def _chosen(gaps: Gaps, burst: Sequence[Collision], after: Sequence[Collision]) -> np.ndarray:
    """Places of the frames to explain, thinned out where nothing happens for long."""
    frames = np.array([collision.frame for collision in burst])
    beyond = frames[-1] + max(FRAMES_BEYOND, BURSTS_BEYOND * (frames[-1] - frames[0]))
    stop = min(after[0].frame - APART_FRAMES if after else np.inf, beyond)
    bounds = np.array([frames[0] - FRAMES_BEYOND, *frames, stop])
    short = np.flatnonzero(np.diff(frames) < FRAMES_A_FLIGHT) + 1
    busy = (bounds[short[0]], bounds[short[-1] + 1]) if len(short) else (np.inf, -np.inf)
    chosen: list[np.ndarray] = []
    outside = bounds[(bounds <= busy[0]) | (bounds >= busy[1])]
    for low, high in pairwise(outside):
        inside = np.flatnonzero((gaps.frame > low) & (gaps.frame <= high))
        whole = (low, high) == busy or low == bounds[0] or high == stop
        chosen.append(_thinned(inside, MOST_BUSY_FRAMES if whole else FRAMES_A_FLIGHT))
    return np.concatenate(chosen)


def _thinned(places: np.ndarray, most: int) -> np.ndarray:
    if len(places) <= most:
        return places
    return np.asarray(places[np.linspace(0, len(places) - 1, most).round().astype(int)])


def until(observed: Observations, end: float) -> Observations:
    """Keep the frames before a time."""
    return at_rows(observed, np.flatnonzero(observed.frame < end))


def at_rows(observed: Observations, rows: NDArray[np.intp]) -> Observations:
    """Keep some of the frames."""
    return replace(
        observed,
        frame=observed.frame[rows],
        ball_px=observed.ball_px[rows],
        heavy_px=observed.heavy_px[rows],
        drift=observed.drift[rows],
        after=observed.after[rows],
    )


def left_out_after(observed: Observations, frame: float) -> Observations:
    """Let frames be left out after a frame of the clip."""
    return replace(observed, after=np.where(observed.origin + observed.frame > frame, 1.0, 0.0))

"""What the fit is to explain: the places of both bodies around the burst, frame by frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from count_video.motion.contacts import BodyErrors
from count_video.motion.gaps import Gaps, gaps_of
from count_video.motion.parameters import Column
from count_video.motion.seen import RESOLVED_FRAMES, SeenCollisions
from count_video.motion.swing import FRAMES_BEYOND
from count_video.records import Collision, Floats, Track
from count_video.signals import sigma_of

APART_FRAMES = 1.0
"""The path is not used nearer than this to a collision after the burst."""
BURSTS_BEYOND = 2.0
"""So many times the burst after its last collision frames are kept as close to it: the last one
often follows late. Later ones, until what follows the burst, show one that is later still."""
FRAMES_A_FLIGHT, FRAMES_BUSY = 16, 500
"""A long flight between two collisions is thinned out to so many frames: neighbouring ones say the
same. Before and after the burst, and where its collisions lie close together, more are kept."""


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
    sigma_px: Floats
    """White noise of one frame, of ball and heavy body, shape (2,)."""
    errors: BodyErrors
    """How the errors of ball and heavy body vary together from frame to frame."""
    burst: Floats
    """Times of the collisions that were seen, shape (seen,)."""
    calm: int
    """How many of the first are sure to be: the others may have hidden ones before them."""
    end: float
    """Time until which the frames say whether one more collision follows: of the last of the clip,
    or of the last before what follows the burst."""
    sign: int
    """+1 where distances grow with the position in the picture."""
    after: Floats
    """1 for frames after the place where frames may be left out, 0 for the others."""

    @cached_property
    def shows_heavy(self) -> bool:
        """Whether the heavy body is seen at all."""
        return bool(np.isfinite(self.heavy_px).any())

    @property
    def start(self) -> float:
        """Time from which the motion is followed."""
        return float(self.frame[0]) - 1.0

    @cached_property
    def places_px(self) -> Floats:
        """Places of ball and heavy body, one after the other, shape (2 frames,)."""
        return np.concatenate([self.ball_px, self.heavy_px])

    def noise_px(self, floor_px: float = 0.0) -> Floats:
        """Noise of a frame where anything nearer than a floor is as good, shape (2,)."""
        return np.hypot(self.sigma_px, floor_px)

    @cached_property
    def correlations(self) -> tuple[Floats | None, ...]:
        """Of the errors of ball and heavy body, shape (frames, frames); None if not known."""
        return tuple(
            None if one is None else one.covariance_of(self.frame) / one.sigma_px**2
            for one in self.errors
        )

    def times(self, values: Floats) -> Floats:
        """Give the frames' times by the clocks of parameters, shape (..., columns)."""
        return np.asarray(self.frame + values[..., Column.SKIP, None] * self.after)

    def at(self, rows: NDArray[np.intp] | NDArray[np.bool_]) -> Observations:
        """Keep some of the frames."""
        of_frames = ("frame", "ball_px", "heavy_px", "after")
        return replace(self, **{name: getattr(self, name)[rows] for name in of_frames})

    def left_out_after(self, frame: float) -> Observations:
        """Let frames be left out after a frame of the clip."""
        after = np.where(self.origin + self.frame > frame, 1.0, 0.0)
        calm = min(self.calm, int((self.origin + self.burst < frame).sum()))
        return replace(self, after=after, calm=calm)


def observe(track: Track, found: SeenCollisions) -> Observations:
    """Cut out of a track what belongs to the first burst, of one collision at least."""
    gaps = gaps_of(track)
    burst = [collision.frame for collision in found.collisions[: found.burst]]
    later = [collision.frame for collision in found.collisions[found.burst :]]
    following = min(later, default=np.inf) - APART_FRAMES
    chosen, first = _chosen(gaps, burst, following), burst[0]
    return Observations(
        origin=first,
        frame=gaps.frame[chosen] - first,
        ball_px=gaps.ball_px[chosen],
        heavy_px=gaps.heavy_px[chosen] - gaps.near_edge_px,
        sigma_px=np.array([sigma_of(gaps.ball_px), sigma_of(gaps.heavy_px)]),
        errors=found.errors,
        burst=np.array(burst) - first,
        calm=calm_beginning(found.collisions[: found.burst]),
        end=float(gaps.frame[gaps.frame < following].max()) - first,
        sign=gaps.sign,
        after=np.zeros(len(chosen)),
    )


def calm_beginning(burst: Sequence[Collision]) -> int:
    """Count the collisions before the first that is not shown, or that others may precede."""
    flights = np.diff([collision.frame for collision in burst])
    unsure = [one.kind == other.kind or not other.seen for one, other in pairwise(burst)]
    missing = np.flatnonzero((flights < RESOLVED_FRAMES) | np.array(unsure, np.bool_))
    return int(missing[0]) + 1 if len(missing) else len(burst)


def _chosen(gaps: Gaps, burst: Sequence[float], following: float) -> NDArray[np.intp]:
    """Rows to explain, thinned out where nothing happens for long.

    They lie around the collisions of a burst, until the frame of what is ``following``.
    """
    stop = burst[-1] + max(FRAMES_BEYOND, BURSTS_BEYOND * (burst[-1] - burst[0]))
    bounds = [burst[0] - FRAMES_BEYOND, *burst, min(stop, following), following]
    short = np.flatnonzero(np.diff(burst) < FRAMES_A_FLIGHT) + 1
    if len(short):
        # Where collisions lie close together others may hide: all from there to there is one.
        bounds = bounds[: short[0] + 1] + bounds[short[-1] + 1 :]
    chosen = []
    for place, (low, high) in enumerate(pairwise(bounds)):
        inside = np.flatnonzero((gaps.frame > low) & (gaps.frame <= high))
        whole = place in (0, len(bounds) - 3) or (len(short) and place == short[0])
        chosen.append(inside[thinned(len(inside), FRAMES_BUSY if whole else FRAMES_A_FLIGHT)])
    return np.concatenate(chosen)


def thinned(number: int, most: int) -> NDArray[np.intp]:
    """Rows of so many, at most, that are spread evenly."""
    return np.linspace(0, number - 1, min(number, most)).round().astype(np.intp)

"""The plan: what a set-up will count, what a camera sees of it, how sure that is, what to change.

The chance that a camera's clip is counted is that of the clips of known truth that were most like
it, by how many frames lie from one collision to the next and by how many collisions there are: the
tables of docs/accuracy.md. Where no such clips were measured nothing is promised.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from count_video.errors import UsageError
from count_video.physics.simulator import Motion, simulate
from count_video.physics.theory import collision_count
from count_video.planning import variations
from count_video.planning.request import PlanRequest, most_collisions
from count_video.progress import NO_PROGRESS, Progress

BALL_AT_LEAST_PX = 20.0
"""Smaller balls are followed too coarsely, whatever the set-up."""
PICTURE_WIDTH_PX = 1920
"""Width of the picture that phones take in slow motion."""

Way = Literal["seen", "inferred", "not measured"]


@dataclass(frozen=True)
class Measured:
    """Clips of one kind and how they came out, and which clips are like them."""

    kind: str
    """What they have in common, in a few words."""
    clips: int
    exact: int
    not_counted: int
    wrong: int
    way: Way = "inferred"
    shortest_frames: float = 0.0
    """Frames from one collision to the next, where they follow each other fastest, at least."""
    counts: tuple[int, int] = (0, 1_000_000)
    """Fewest and most collisions."""
    capture_fps: float = 0.0
    """Slowest camera."""

    @property
    def chance(self) -> float:
        """Chance that the next such clip is counted exactly, by Laplace's rule of succession."""
        return (self.exact + 1) / (self.clips + 2)


RESOLVED = Measured(
    *("rendered clips whose frames show every collision", 1160, 1155, 5, 0),
    way="seen",
    shortest_frames=variations.RESOLVED_FRAMES,
)
BETWEEN = Measured(
    *("rendered clips with some collisions between the frames", 42, 42, 0, 0),
    shortest_frames=0.25,
    counts=(0, 45),
)
CLOSE = Measured(
    *("planned clips with collisions closer than a quarter of a frame", 20, 19, 1, 0),
    shortest_frames=0.08,
    counts=(0, 45),
)
LONG = Measured(
    *("clips of some 310 collisions with the masses given", 20, 20, 0, 0),
    counts=(250, 350),
    capture_fps=1000.0,
)
MEASURED = (RESOLVED, BETWEEN, CLOSE, LONG)
"""Of these the first that is like a clip is taken."""


def most_like(
    count: int, shortest_frames: float, capture_fps: float
) -> tuple[Way, Measured | None]:
    """Return how a clip would be counted, and the measured clips that were most like it."""
    for one in MEASURED:
        fits = one.counts[0] <= count <= one.counts[1] and capture_fps >= one.capture_fps
        if fits and shortest_frames >= one.shortest_frames:
            return one.way, one
    return "not measured", None


@dataclass(frozen=True)
class PlannedBurst:
    """The burst of a planned trial; times in seconds from the release."""

    count: int
    theory: int
    """Exact count of free bodies without losses."""
    bodies: int
    """Collisions between the bodies; the others are with the wall."""
    shortest_s: float
    """Shortest time from one collision to the next; inf if there are fewer than two."""
    first_s: float
    last_s: float
    turn_s: float
    """When the cylinder, driven back, turns round and the count ends."""
    swing_back_m: float
    """How far beyond its rest the cylinder swings back."""
    last_m: float
    """Distance from the wall to the ball's side that faces it, at the last collision."""
    last_speed_m_s: float
    """Speed at which the two close in on each other there."""
    smallest_hop_m: float
    """Shortest way of the ball between cylinder and wall; inf if it does not reach the wall."""
    intervals_s: tuple[float, ...]
    """Times from each collision to the next."""


@dataclass(frozen=True)
class CameraView:
    """What a camera of some rate would see."""

    capture_fps: float
    shortest_frames: float
    """Frames from one collision to the next, where they follow each other fastest."""
    close: int
    """Collisions that follow the one before by less than ``RESOLVED_FRAMES``."""
    way: Way
    measured: Measured | None
    """The clips of known truth that were most like this one; None if there are none."""
    last_px_frame: float
    """Closing speed at the last collision, in px per frame with the largest ball."""


@dataclass(frozen=True)
class Framing:
    """How large the picture must show the experiment."""

    rate_needed_fps: float
    """At this rate every collision is seen."""
    ball_at_least_px: float
    ball_at_most_px: float
    """Width of the ball if the picture shows the wall and the whole burst, and little else."""
    smallest_hop_px: float
    """The ball's shortest way between two collisions, with the largest ball."""


@dataclass(frozen=True)
class Plan:
    """What a planned set-up will count, how sure that is, and what a camera sees of it."""

    request: PlanRequest
    burst: PlannedBurst
    framing: Framing
    camera: CameraView | None
    """None where no rate was given."""
    spread: variations.Spread
    proposals: tuple[variations.Proposal, ...]
    """What to change for the theory's count with a safe margin; empty if nothing, or if nothing
    helps (``spread`` says which)."""
    table: variations.TrialTable | None
    """None where no table was asked for."""
    chart: NDArray[np.void] | None = field(repr=False)
    """None where no map was asked for."""
    motion: Motion = field(repr=False)


def make_plan(
    request: PlanRequest,
    *,
    with_table: bool = True,
    with_chart: bool = True,
    progress: Progress = NO_PROGRESS,
) -> Plan:
    """Work out a plan; a second or two, most of it for tolerances and map.

    UsageError if the bodies lose so much that they come to rest on each other.
    """
    progress.start(5, "planning")
    theory = collision_count(request.heavy, request.light)
    motion = simulate(request.setup(), most=most_collisions(theory))
    if motion.endless:
        raise UsageError(
            f"with a restitution of {request.restitution:g} and a damping of "
            f"{request.damping_per_s:g} per s the ball comes to rest between cylinder and wall in "
            "ever smaller bounces, of which there is no count; plan harder bodies, less damping or "
            "a smaller mass ratio"
        )
    burst = _planned_burst(motion, theory)
    framing = _framing(request, burst)
    progress.advance(1)
    spread = variations.spread_of(request, theory)
    progress.advance(1)
    changes = variations.proposals(request, theory, spread)
    progress.advance(1)
    table = variations.table_of(request, theory) if with_table else None
    progress.advance(1)
    chart = variations.chart_of(request, theory) if with_chart else None
    progress.advance(1)
    progress.finish()
    camera = _camera_view(request, burst, framing)
    return Plan(request, burst, framing, camera, spread, changes, table, chart, motion)


def _planned_burst(motion: Motion, theory: int) -> PlannedBurst:
    burst = motion.burst
    times = np.array([bounce.time_s for bounce in burst])
    turn_s = motion.burst_end_s
    sample = motion.sample(np.append(times, turn_s if np.isfinite(turn_s) else times[-1]))
    places = sample.ball_far_face_m[:-1]
    crossed = np.array([a.kind != b.kind for a, b in pairwise(burst)], dtype=bool)
    last = burst[-1]
    other = 0.0 if last.kind == "wall" else last.heavy_before_m_s
    return PlannedBurst(
        count=len(burst),
        theory=theory,
        bodies=sum(bounce.kind == "bodies" for bounce in burst),
        shortest_s=motion.shortest_s,
        first_s=float(times[0]),
        last_s=float(times[-1]),
        turn_s=turn_s,
        swing_back_m=float(sample.heavy_face_m[-1]) - motion.setup.heavy_rest_m,
        last_m=float(places[-1]),
        last_speed_m_s=abs(last.light_before_m_s - other),
        smallest_hop_m=float(np.abs(np.diff(places))[crossed].min(initial=np.inf)),
        intervals_s=tuple(np.diff(times).tolist()),
    )


def _framing(request: PlanRequest, burst: PlannedBurst) -> Framing:
    """Say how large the ball must and can be in the picture.

    That has the ball's way, the wall on one side and space to aim on the other: 0.8 diameters. A
    hop smaller than a pixel may be missed.
    """
    diameter_m, hop_m = request.ball_diameter_m, burst.smallest_hop_m
    px_per_m = PICTURE_WIDTH_PX / (max(request.gap_m, burst.last_m) + 1.8 * diameter_m)
    for_the_hop = diameter_m / hop_m if math.isfinite(hop_m) and hop_m else 0.0
    return Framing(
        rate_needed_fps=float(variations.rate_needed_fps(burst.shortest_s)),
        ball_at_least_px=max(BALL_AT_LEAST_PX, for_the_hop),
        ball_at_most_px=diameter_m * px_per_m,
        smallest_hop_px=hop_m * px_per_m,
    )


def _camera_view(request: PlanRequest, burst: PlannedBurst, framing: Framing) -> CameraView | None:
    rate = request.capture_fps
    if rate is None:
        return None
    shortest = burst.shortest_s * rate
    way, measured = most_like(burst.count, shortest, rate)
    close = sum(interval * rate < variations.RESOLVED_FRAMES for interval in burst.intervals_s)
    px_per_m = framing.ball_at_most_px / request.ball_diameter_m
    last_px_frame = burst.last_speed_m_s * px_per_m / rate
    return CameraView(rate, shortest, close, way, measured, last_px_frame)

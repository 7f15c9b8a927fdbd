"""What a camera sees of a planned trial: frames from collision to collision, and pixels."""

from __future__ import annotations

import math
from dataclasses import dataclass

from count_video.planning.burst import PlannedBurst
from count_video.planning.measured import RESOLVED_FRAMES, Measured, Way, most_like
from count_video.planning.request import PlanRequest

BALL_AT_LEAST_PX = 20.0
"""Smaller balls are followed too coarsely, whatever the set-up."""
HOP_AT_LEAST_PX = 1.0
"""A hop smaller than a pixel may be missed."""
PICTURE_WIDTH_PX = 1920
"""Width of the picture that phones take in slow motion."""
MARGIN_DIAMETERS = 0.8
"""The picture shows so much more than the way of the ball, in ball diameters: the wall on one side
and space to aim on the other."""
RATE_STEP_FPS = 10


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


def rate_needed_fps(shortest_s: float) -> float:
    """Rate at which collisions this far apart are seen one by one, in steps of ten; at least 10."""
    if shortest_s == math.inf:
        return float(RATE_STEP_FPS)
    return float(RATE_STEP_FPS * math.ceil(RESOLVED_FRAMES / shortest_s / RATE_STEP_FPS))


def framing_of(request: PlanRequest, burst: PlannedBurst) -> Framing:
    """Say how large the ball must and can be in the picture."""
    diameter_m = request.ball_diameter_m
    view_m = max(request.gap_m, burst.last_m) + (1.0 + MARGIN_DIAMETERS) * diameter_m
    px_per_m = PICTURE_WIDTH_PX / view_m
    hop_m = burst.smallest_hop_m
    for_the_hop = HOP_AT_LEAST_PX * diameter_m / hop_m if math.isfinite(hop_m) and hop_m else 0.0
    return Framing(
        rate_needed_fps=rate_needed_fps(burst.shortest_s),
        ball_at_least_px=max(BALL_AT_LEAST_PX, for_the_hop),
        ball_at_most_px=diameter_m * px_per_m,
        smallest_hop_px=hop_m * px_per_m,
    )


def camera_view(request: PlanRequest, burst: PlannedBurst, framing: Framing) -> CameraView | None:
    """Judge the planned camera; None where there is none."""
    rate = request.capture_fps
    if rate is None:
        return None
    shortest = burst.shortest_s * rate
    way, measured = most_like(burst.count, shortest, rate)
    px_per_m = framing.ball_at_most_px / request.ball_diameter_m
    return CameraView(
        capture_fps=rate,
        shortest_frames=shortest,
        close=sum(interval * rate < RESOLVED_FRAMES for interval in burst.intervals_s),
        way=way,
        measured=measured,
        last_px_frame=burst.last_speed_m_s * px_per_m / rate,
    )

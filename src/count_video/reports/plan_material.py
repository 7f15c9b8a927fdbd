"""A planned trial as if it had been filmed and counted, for the panels of measured trials.

The lines of its tracks are drawn between the frames as well, as only a plan can; the image behind
them is what the planned camera would show, frame by frame.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from count_video.physics.flights import Pendulum as Swing
from count_video.physics.simulator import Motion, Sample, SimulatedCollision
from count_video.planning.camera import PICTURE_WIDTH_PX
from count_video.planning.measured import RESOLVED_FRAMES
from count_video.planning.whole import Plan
from count_video.records import (
    BodyTrack,
    Collision,
    Floats,
    MotionLine,
    Track,
    TrialResult,
    Velocities,
)
from count_video.reports.material import Luma, Material, Pendulum, SpaceTime

IMAGE_PX = PICTURE_WIDTH_PX + 500
"""Length of the line of motion that is drawn: somewhat more than a picture holds."""
MOST_FRAMES = 6000
"""Frames of the image; a camera that takes more is drawn as one that takes these."""
POINTS_A_FRAME = 6
MOST_POINTS = 60_000
BEYOND = 0.12
"""The picture begins this share of the burst before the first collision, and ends so after it."""
WALL_DIAMETERS = 0.5
"""From the picture's border to the wall, in ball diameters."""
BACKDROP, WALL, BALL, CYLINDER = 70, 150, 225, 180
"""Brightness of what the image shows, 0 to 255."""


def planned_material(plan: Plan) -> Material:
    """Turn a plan into what the panels of a measured trial are drawn from.

    Frame 0 is the release; px are those of a picture that holds wall and burst and little else.
    """
    rate = drawn_fps(plan)
    px_per_m = plan.framing.ball_at_most_px / plan.request.ball_diameter_m
    frames = _shown_frames(plan, rate)
    points = _points(frames, [bounce.time_s * rate for bounce in plan.motion.burst])
    return Material(
        result=_result(plan, rate, px_per_m),
        track=_track(plan.motion, points, rate, px_per_m),
        space_time=SpaceTime(frames, _image(plan.motion, frames / rate, px_per_m)),
        pendulum=_pendulum(plan.motion, rate, px_per_m),
    )


def drawn_fps(plan: Plan) -> float:
    """Rate of the planned camera, or the one that is needed; less where that is too many frames."""
    camera = plan.camera
    wanted = plan.framing.rate_needed_fps if camera is None else camera.capture_fps
    burst = plan.burst
    return min(wanted, MOST_FRAMES / max(burst.last_s - burst.first_s, 1e-3))


def _shown_frames(plan: Plan, rate: float) -> Floats:
    """Whole frames from shortly before the first collision to the turn, shape (n,)."""
    burst = plan.burst
    margin_s = BEYOND * max(burst.last_s - burst.first_s, 1e-3)
    first = math.floor(max(0.0, burst.first_s - margin_s) * rate)
    return np.arange(first, math.ceil((burst.last_s + margin_s) * rate) + 1, dtype=np.float64)


def _points(frames: Floats, collisions: list[float]) -> Floats:
    """Frame coordinates at which the lines are drawn: the corners among them."""
    number = min(MOST_POINTS, POINTS_A_FRAME * len(frames))
    return np.unique(np.concatenate([np.linspace(frames[0], frames[-1], number), collisions]))


def _track(motion: Motion, points: Floats, rate: float, px_per_m: float) -> Track:
    sample = motion.sample(points / rate)
    half = motion.setup.ball_diameter_m / 2 * px_per_m
    wall = _wall_px(motion, px_per_m)
    ball = wall + px_per_m * sample.ball_far_face_m + half
    heavy = wall + px_per_m * sample.heavy_face_m
    still = np.zeros_like(points)
    return Track(
        frame=points,
        ball=BodyTrack(ball, still, -half, half),
        heavy=BodyTrack(heavy, still, 0.0, float(PICTURE_WIDTH_PX)),
        wall_side="left",
        ball_diameter_px=2 * half,
        line=MotionLine(0.0, 0.0, 0.0, upright=False),
        warnings=(),
    )


def _wall_px(motion: Motion, px_per_m: float) -> float:
    return WALL_DIAMETERS * motion.setup.ball_diameter_m * px_per_m


def _image(motion: Motion, times_s: Floats, px_per_m: float) -> Luma:
    """Draw the line of motion of each frame, shape (n, IMAGE_PX)."""
    sample: Sample = motion.sample(times_s)
    place_m = (np.arange(IMAGE_PX) - _wall_px(motion, px_per_m)) / px_per_m
    image = np.full((len(times_s), IMAGE_PX), BACKDROP, np.uint8)
    image[:, place_m < 0] = WALL
    far, near = sample.ball_far_face_m[:, None], sample.ball_near_face_m[:, None]
    image[(place_m >= far) & (place_m <= near)] = BALL
    image[place_m >= sample.heavy_face_m[:, None]] = CYLINDER
    return image


def _pendulum(motion: Motion, rate: float, px_per_m: float) -> Pendulum:
    setup = motion.setup
    swing = Swing.from_thread(setup.heavy_thread_m, setup.gravity_m_s2, 0.0, 0.0)
    centre = _wall_px(motion, px_per_m) + px_per_m * setup.heavy_rest_m
    return Pendulum((swing.natural_rad_s / rate) ** 2, centre)


def _result(plan: Plan, rate: float, px_per_m: float) -> TrialResult:
    burst = plan.motion.burst
    collisions = _collisions(plan, rate, px_per_m)
    seen = sum(collision.seen for collision in collisions)
    return TrialResult(
        clip="plan",
        status="counted",
        reason=None,
        count=len(burst),
        seen=seen,
        between_frames=len(burst) - seen,
        probability={},
        count_after_burst=0,
        collisions=collisions,
        capture_fps=rate,
        capture_fps_source="option",
        frames_decoded=None,
        frames_promised=None,
        wall_side="left",
        ball_diameter_px=plan.framing.ball_at_most_px,
        millimetres_per_px=1e3 / px_per_m,
        pi_low=None,
        pi_high=None,
        mass_ratio=plan.request.mass_ratio,
        warnings=(),
    )


def _collisions(plan: Plan, rate: float, px_per_m: float) -> tuple[Collision, ...]:
    """List the burst; a collision counts as seen if both its neighbours are far enough away."""
    burst = plan.motion.burst
    frames = [bounce.time_s * rate for bounce in burst]
    gaps = [math.inf, *(later - earlier for earlier, later in pairwise(frames)), math.inf]
    camera = plan.camera.capture_fps if plan.camera else plan.framing.rate_needed_fps
    clear = RESOLVED_FRAMES * rate / camera
    places = plan.motion.sample(np.array([bounce.time_s for bounce in burst])).ball_far_face_m
    half_m = plan.request.ball_diameter_m / 2
    wall = _wall_px(plan.motion, px_per_m)
    return tuple(
        Collision(
            number=number,
            kind=bounce.kind,
            frame=frames[number - 1],
            frame_sigma=0.0,
            time_s=bounce.time_s,
            seen=min(gaps[number - 1], gaps[number]) >= clear,
            position_px=wall + px_per_m * (float(places[number - 1]) + half_m),
            velocity_before=_velocities(bounce, px_per_m / rate, before=True),
            velocity_after=_velocities(bounce, px_per_m / rate, before=False),
        )
        for number, bounce in enumerate(burst, 1)
    )


def _velocities(bounce: SimulatedCollision, factor: float, *, before: bool) -> Velocities:
    if before:
        return Velocities(bounce.light_before_m_s * factor, bounce.heavy_before_m_s * factor)
    return Velocities(bounce.light_after_m_s * factor, bounce.heavy_after_m_s * factor)

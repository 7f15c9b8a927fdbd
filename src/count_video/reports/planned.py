"""A planned trial as if it had been filmed and counted, so that the same panels can draw it.

The lines of its tracks are drawn between the frames as well, as only a plan can; the image behind
them is what the planned camera would show, frame by frame. Frame 0 is the release; px are those of
a picture that holds wall and burst and little else.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from count_video.physics.engine import SimulatedCollision
from count_video.physics.flights import Pendulum as Swing
from count_video.planning.plan import PICTURE_WIDTH_PX, Plan
from count_video.planning.spread import RESOLVED_FRAMES
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
    """Turn a plan into what the panels of a measured trial are drawn from."""
    return _Filmed(plan).material()


@dataclass(frozen=True)
class _Filmed:
    """A plan, and the scales at which it is drawn."""

    plan: Plan

    @cached_property
    def rate(self) -> float:
        """Of the planned camera, or the one that is needed; less where that is too many frames."""
        camera, burst = self.plan.camera, self.plan.burst
        wanted = self.plan.framing.rate_needed_fps if camera is None else camera.capture_fps
        return min(wanted, MOST_FRAMES / max(burst.last_s - burst.first_s, 1e-3))

    @cached_property
    def px_per_m(self) -> float:
        return self.plan.framing.ball_at_most_px / self.plan.request.ball_diameter_m

    def px(self, metres: Floats | float) -> Floats:
        """Place in the picture, in px, of what lies so far from the wall; of the same shape."""
        wall_px = WALL_DIAMETERS * self.plan.motion.setup.ball_diameter_m * self.px_per_m
        return np.asarray(wall_px + self.px_per_m * np.asarray(metres))

    def material(self) -> Material:
        frames = self._frames()
        setup = self.plan.motion.setup
        swing = Swing.from_thread(setup.heavy_thread_m, setup.gravity_m_s2, 0.0, 0.0)
        centre_px = float(self.px(setup.heavy_rest_m))
        return Material(
            result=self._result(),
            track=self._track(frames),
            space_time=SpaceTime(frames, self._image(frames)),
            pendulum=Pendulum((swing.natural_rad_s / self.rate) ** 2, centre_px),
        )

    def _frames(self) -> Floats:
        """Whole frames from shortly before the first collision to the turn, shape (n,)."""
        burst = self.plan.burst
        margin_s = BEYOND * max(burst.last_s - burst.first_s, 1e-3)
        first = math.floor(max(0.0, burst.first_s - margin_s) * self.rate)
        end = math.ceil((burst.last_s + margin_s) * self.rate) + 1
        return np.arange(first, end, dtype=np.float64)

    def _track(self, frames: Floats) -> Track:
        """Sample the paths between the frames too, with the collisions, where they have corners."""
        motion = self.plan.motion
        number = min(MOST_POINTS, POINTS_A_FRAME * len(frames))
        even = np.linspace(frames[0], frames[-1], number)
        points = np.unique(np.append(even, [c.time_s * self.rate for c in motion.burst]))
        sample, still = motion.sample(points / self.rate), np.zeros_like(points)
        half = motion.setup.ball_diameter_m / 2 * self.px_per_m
        return Track(
            frame=points,
            ball=BodyTrack(self.px(sample.ball_far_face_m) + half, still, -half, half),
            heavy=BodyTrack(self.px(sample.heavy_face_m), still, 0.0, float(PICTURE_WIDTH_PX)),
            wall_side="left",
            ball_diameter_px=2 * half,
            line=MotionLine(0.0, 0.0, 0.0, upright=False),
            warnings=(),
        )

    def _image(self, frames: Floats) -> Luma:
        """Draw the line of motion of each frame, shape (n, IMAGE_PX)."""
        sample = self.plan.motion.sample(frames / self.rate)
        place_m = (np.arange(IMAGE_PX) - self.px(0.0)) / self.px_per_m
        image = np.full((len(frames), IMAGE_PX), BACKDROP, np.uint8)
        image[:, place_m < 0] = WALL
        far, near = sample.ball_far_face_m[:, None], sample.ball_near_face_m[:, None]
        image[(place_m >= far) & (place_m <= near)] = BALL
        image[place_m >= sample.heavy_face_m[:, None]] = CYLINDER
        return image

    def _result(self) -> TrialResult:
        collisions = self._collisions()
        seen = sum(collision.seen for collision in collisions)
        return TrialResult(
            clip="plan",
            status="counted",
            reason=None,
            count=len(collisions),
            seen=seen,
            between_frames=len(collisions) - seen,
            probability={},
            count_after_burst=0,
            collisions=collisions,
            capture_fps=self.rate,
            capture_fps_source="option",
            frames_decoded=None,
            frames_promised=None,
            wall_side="left",
            ball_diameter_px=self.plan.framing.ball_at_most_px,
            millimetres_per_px=1e3 / self.px_per_m,
            pi_low=None,
            pi_high=None,
            mass_ratio=self.plan.request.mass_ratio,
            warnings=(),
        )

    def _collisions(self) -> tuple[Collision, ...]:
        """List the burst; a collision counts as seen if both its neighbours are far enough away."""
        plan, burst = self.plan, self.plan.motion.burst
        times_s = [bounce.time_s for bounce in burst]
        gaps_s = [math.inf, *(b - a for a, b in pairwise(times_s)), math.inf]
        camera_fps = plan.camera.capture_fps if plan.camera else plan.framing.rate_needed_fps
        clear_s = RESOLVED_FRAMES / camera_fps
        far_face_m = plan.motion.sample(np.array(times_s)).ball_far_face_m
        places = self.px(far_face_m + plan.request.ball_diameter_m / 2)
        return tuple(
            Collision(
                number=number,
                kind=bounce.kind,
                frame=bounce.time_s * self.rate,
                frame_sigma=0.0,
                time_s=bounce.time_s,
                seen=min(gaps_s[number - 1], gaps_s[number]) >= clear_s,
                position_px=float(places[number - 1]),
                velocity_before=self._velocities(bounce, "before"),
                velocity_after=self._velocities(bounce, "after"),
            )
            for number, bounce in enumerate(burst, 1)
        )

    def _velocities(self, bounce: SimulatedCollision, side: str) -> Velocities:
        speeds = (getattr(bounce, f"{body}_{side}_m_s") for body in ("light", "heavy"))
        return Velocities(*(speed * self.px_per_m / self.rate for speed in speeds))

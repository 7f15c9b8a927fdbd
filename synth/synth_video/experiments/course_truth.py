"""What a clip of an experiment really shows, and its file."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from itertools import pairwise

import numpy as np

from count_video.records import CollisionKind, Floats
from synth_video.experiments.course import Course
from synth_video.projection import Projection
from synth_video.scene import NOTHING_TO_COUNT, Scene
from synth_video.schedule import Schedule
from synth_video.tripod import tripod_shift
from synth_video.truth import FRAME_CONVENTION, RESOLVED_FRAMES

VISIBLE_PX = 1.0
"""A hop that leads less far from its stop counts as rest."""


@dataclass(frozen=True)
class Hit:
    """One collision of the truth."""

    frame: float
    """Frame coordinate."""
    kind: CollisionKind


@dataclass(frozen=True)
class BodyTruth:
    """Centre of one body at the centres of the exposures, arrays of shape (n,)."""

    along_m: Floats
    up_m: Floats
    x_px: Floats
    y_px: Floats


@dataclass(frozen=True)
class ExperimentTruth:
    """Truth of one clip."""

    scene: Scene
    seed: int
    events: tuple[Hit, ...]
    """Collisions within the clip, in order."""
    sure: int
    """How many of them the frames show beyond doubt."""
    px_per_m: float
    bodies: tuple[BodyTruth, ...]

    @property
    def count(self) -> int:
        """Number of collisions."""
        return len(self.events)

    @property
    def frames(self) -> int:
        """Number of frames."""
        return len(self.bodies[0].x_px)

    @property
    def countable(self) -> bool:
        """False for an experiment that shows nothing to count."""
        return self.scene.experiment.kind not in NOTHING_TO_COUNT

    @property
    def resolved(self) -> bool:
        """True if the frames show each collision."""
        return self.sure == self.count

    @property
    def shortest_interval_frames(self) -> float:
        """Shortest time between two collisions; inf for fewer than two."""
        return min((b.frame - a.frame for a, b in pairwise(self.events)), default=float("inf"))


def truth_of_course(
    scene: Scene, seed: int, course: Course, schedule: Schedule, projection: Projection
) -> ExperimentTruth:
    """Collect the truth of a clip from what happens in it."""
    bodies = []
    shift_px = tripod_shift(scene.tripod, schedule, seed)
    for place in course.places:
        along_m, up_m = place(schedule.centre_s)
        bodies.append(BodyTruth(along_m, up_m, *projection.image(along_m, up_m, shift_px)))
    last = len(schedule.centre_s) - 0.5
    placed = ((contact, schedule.frame_coordinate(contact.time_s)) for contact in course.contacts)
    events = tuple(Hit(frame, contact.kind) for contact, frame in placed if -0.5 <= frame <= last)
    return ExperimentTruth(
        scene=scene,
        seed=seed,
        events=events,
        sure=_sure(course, schedule, projection.px_per_m, scene.camera.capture_fps),
        px_per_m=projection.px_per_m,
        bodies=tuple(bodies),
    )


def _sure(course: Course, schedule: Schedule, px_per_m: float, capture_fps: float) -> int:
    """Count the collisions that the frames show beyond doubt.

    A hop too short or too low to be seen hides the next collision, and all after it. The last
    collision is hidden where the clip ends before one sees that the body has turned.
    """
    shown = [c.time_s for c in course.contacts if c.time_s <= schedule.centre_s[-1]]
    ends_s = [*shown, float(schedule.centre_s[-1])][1:]
    for number, (start_s, end_s) in enumerate(zip(shown, ends_s, strict=True), start=1):
        way_px = _way_m(course, start_s, end_s) * px_per_m
        if end_s - start_s < RESOLVED_FRAMES / capture_fps or way_px < VISIBLE_PX:
            return number if number < len(shown) else number - 1
    return len(shown)


def _way_m(course: Course, start_s: float, end_s: float) -> float:
    """How far any of the bodies goes from where it is at the start."""
    times_s = np.linspace(start_s, end_s, 33)
    paths = (place(times_s) for place in course.places)
    ways = (np.hypot(along_m - along_m[0], up_m - up_m[0]) for along_m, up_m in paths)
    return max(float(way.max()) for way in ways)


def experiment_json(truth: ExperimentTruth) -> str:
    """Write the truth as JSON text: a line for each frame, keys always in this order."""
    scene, shortest = truth.scene, truth.shortest_interval_frames
    head = {
        "seed": truth.seed,
        "scene": asdict(scene),
        "capture_fps": scene.camera.capture_fps,
        "container_fps": scene.encoding.container_fps,
        "frame_convention": FRAME_CONVENTION,
        "expect": "counted" if truth.countable else "not_counted",
        "count": truth.count,
        "accept": list(range(truth.sure, truth.count + 1)),
        "bodies": len(truth.bodies),
        "events": [{"frame": round(e.frame, 6), "kind": e.kind} for e in truth.events],
        "resolved": truth.resolved,
        "shortest_interval_frames": round(shortest, 6) if np.isfinite(shortest) else None,
        "body_length_px": scene.setup.ball_diameter_m * truth.px_per_m,
        "px_per_m": truth.px_per_m,
    }
    lines = ",\n".join(f"  {json.dumps(row)}" for row in _frame_rows(truth))
    return f'{json.dumps(head, indent=1)[:-2]},\n "frames": [\n{lines}\n ]\n}}\n'


def _frame_rows(truth: ExperimentTruth) -> list[dict[str, object]]:
    """One dictionary a frame: every body's centre in px to 1e-5, and in metres to 1e-9."""
    return [
        {
            "frame": k,
            "bodies_px": [[round(b.x_px[k], 5), round(b.y_px[k], 5)] for b in truth.bodies],
            "bodies_m": [[round(b.along_m[k], 9), round(b.up_m[k], 9)] for b in truth.bodies],
        }
        for k in range(truth.frames)
    ]

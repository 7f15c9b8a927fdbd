"""What a synthetic clip really shows, and its file.

Truth along the line of motion is given in px of image x, as everywhere in this project, and as
image points (x, y); metres point away from the wall.
"""

from __future__ import annotations

import json
import os
from abc import ABC, abstractmethod
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import asdict, dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from count_video.errors import UsageError
from count_video.inputs import json_value, read_text
from count_video.outputs import explained, write_whole
from count_video.physics.simulator import Motion
from count_video.records import CollisionKind, Floats
from synth_video.experiments.course import Course, rise_m
from synth_video.projection import Projection, tripod_shift
from synth_video.scene import NOTHING_TO_COUNT, Scene
from synth_video.schedule import Schedule

RESOLVED_FRAMES = 2.5
"""Collisions of the burst at least this far apart are seen one by one in the frames."""
FRAME_CONVENTION = (
    "frame k is the centre of the exposure of the k-th picture, k from 0; "
    "image x right and y down in px, an integer is the centre of a pixel; "
    "metres point away from the wall's face"
)
_KEYS = (
    *("seed", "scene", "capture_fps", "container_fps", "frame_convention", "expect", "count"),
    *("count_after_burst", "accept", "bodies", "events", "events_after_burst", "resolved"),
    *("shortest_interval_frames", "mass_ratio", "ball_diameter_px", "body_length_px"),
    *("px_per_m", "wall_side"),
)
"""Keys of the file, those of trials and those of other experiments, in their order."""
_MOST_BYTES = 100_000_000
"""No truth is longer."""
_FACES = ("ball_near", "ball_far", "cylinder", "wall")


@dataclass(frozen=True)
class Event:
    """One collision of the truth."""

    frame: float
    """Frame coordinate."""
    kind: CollisionKind
    ball_px: float | None = None
    """Where the ball's centre is seen, along the line of motion (image x); None where no ball is
    between cylinder and wall."""


@dataclass(frozen=True)
class PathTruth:
    """One face or one body's centre, at the centres of the exposures; arrays of shape (n,)."""

    along_m: Floats
    """Distance from the wall."""
    up_m: Floats
    """Height over the rest line."""
    x_px: Floats
    """Image point; x is also the position along the line."""
    y_px: Floats


@dataclass(frozen=True)
class ClipTruth(ABC):
    """What is true of any clip."""

    scene: Scene
    seed: int
    events: tuple[Event, ...]
    """Collisions that count, in order."""
    px_per_m: float
    """Scale along the line of motion (of its own length, not of its image x)."""
    frames: int
    """Number of frames."""

    @property
    def count(self) -> int:
        """Number of collisions that count."""
        return len(self.events)

    @property
    def shortest_interval_frames(self) -> float:
        """Shortest time between two of them; inf for fewer than two."""
        return min((b.frame - a.frame for a, b in pairwise(self.events)), default=float("inf"))

    @property
    @abstractmethod
    def resolved(self) -> bool:
        """True if the frames show each collision."""

    @property
    @abstractmethod
    def countable(self) -> bool:
        """False for a clip that is to be refused."""

    @abstractmethod
    def figures(self) -> dict[str, object]:
        """Return what is true of this kind of clip alone, by the keys of the file."""

    @abstractmethod
    def frame_rows(self) -> Iterator[dict[str, object]]:
        """Yield what is true of each frame; px to 1e-5, metres to 1e-9."""

    def text(self) -> str:
        """Write the truth as JSON text: a line for each frame, keys always in this order."""
        scene, shortest = self.scene, self.shortest_interval_frames
        values = {
            "seed": self.seed,
            "scene": asdict(scene),
            "capture_fps": scene.camera.capture_fps,
            "container_fps": scene.encoding.container_fps,
            "frame_convention": FRAME_CONVENTION,
            "expect": "counted" if self.countable else "not_counted",
            "count": self.count,
            "events": [_event_json(event) for event in self.events],
            "resolved": self.resolved,
            "shortest_interval_frames": round(shortest, 6) if np.isfinite(shortest) else None,
            "px_per_m": self.px_per_m,
            **self.figures(),
        }
        head = json.dumps({key: values[key] for key in _KEYS if key in values}, indent=1)
        lines = ",\n".join(f"  {json.dumps(row)}" for row in self.frame_rows())
        return f'{head[:-2]},\n "frames": [\n{lines}\n ]\n}}\n'


def _event_json(event: Event) -> dict[str, object]:
    place = {} if event.ball_px is None else {"ball_px": round(event.ball_px, 5)}
    return {"frame": round(event.frame, 6), "kind": event.kind, **place}


# ---- the ball between cylinder and wall ----------------------------------------------------------


@dataclass(frozen=True)
class Truth(ClipTruth):
    """Truth of one trial; ``events`` are those of the burst, also those outside the clip."""

    events_after_burst: tuple[Event, ...]
    """Collisions after the cylinder turned back that lie within the clip."""
    ball_near: PathTruth
    ball_far: PathTruth
    cylinder: PathTruth
    wall: PathTruth

    @property
    def resolved(self) -> bool:
        """True if the frames show each collision of the burst."""
        return self.shortest_interval_frames >= RESOLVED_FRAMES

    @property
    def countable(self) -> bool:
        """True if the clip shows the whole burst; only such a clip can be counted."""
        last = self.frames - 1
        return bool(self.events) and all(0 <= event.frame <= last for event in self.events)

    @property
    def ball_diameter_px(self) -> float:
        """Diameter of the ball in the picture."""
        return self.scene.setup.ball_diameter_m * self.px_per_m

    def figures(self) -> dict[str, object]:
        """Return what is true of a trial alone, by the keys of the file."""
        setup = self.scene.setup
        return {
            "count_after_burst": len(self.events_after_burst),
            "events_after_burst": [_event_json(event) for event in self.events_after_burst],
            "mass_ratio": setup.heavy_mass_kg / setup.light_mass_kg,
            "ball_diameter_px": self.ball_diameter_px,
            "wall_side": self.scene.wall.side,
        }

    def frame_rows(self) -> Iterator[dict[str, object]]:
        """Yield where each face is in each frame."""
        faces = (getattr(self, name) for name in _FACES)
        rounded = [(f.along_m.round(9), f.x_px.round(5), f.y_px.round(5)) for f in faces]
        for k in range(self.frames):
            row: dict[str, object] = {"frame": k}
            for name, (along_m, x_px, y_px) in zip(_FACES, rounded, strict=True):
                row[f"{name}_m"] = float(along_m[k])
                row[f"{name}_px"] = float(x_px[k])
                row[f"{name}_point_px"] = [float(x_px[k]), float(y_px[k])]
            yield row


def truth_of(
    scene: Scene, seed: int, motion: Motion, schedule: Schedule, projection: Projection
) -> Truth:
    """Collect the truth of a clip from the simulated motion."""
    setup = motion.setup
    sample = motion.sample(schedule.centre_s)
    ball_up, heavy_up = np.zeros_like(sample.ball_far_face_m), np.zeros_like(sample.heavy_face_m)
    if scene.view.rising_path:
        ball_up = rise_m(setup, sample.ball_far_face_m - setup.wall_gap_m, setup.light_thread_m)
        heavy_up = rise_m(setup, sample.heavy_face_m - setup.heavy_rest_m, setup.heavy_thread_m)

    shift_px = tripod_shift(scene.tripod, schedule, seed)

    def face(along_m: Floats, up_m: Floats) -> PathTruth:
        return PathTruth(along_m, up_m, *projection.image(along_m, up_m, shift_px))

    events = _events(motion, scene, seed, schedule, projection)
    burst, last = len(motion.burst), len(schedule.centre_s) - 0.5
    return Truth(
        scene=scene,
        seed=seed,
        events=events[:burst],
        events_after_burst=tuple(e for e in events[burst:] if -0.5 <= e.frame <= last),
        px_per_m=projection.px_per_m,
        frames=len(schedule.centre_s),
        ball_near=face(sample.ball_near_face_m, ball_up),
        ball_far=face(sample.ball_far_face_m, ball_up),
        cylinder=face(sample.heavy_face_m, heavy_up),
        wall=face(*np.zeros((2, len(schedule.centre_s)))),
    )


def _events(
    motion: Motion, scene: Scene, seed: int, schedule: Schedule, projection: Projection
) -> tuple[Event, ...]:
    """All collisions of a trial, in order."""
    if not motion.collisions:
        return ()
    setup = motion.setup
    times_s = np.array([bounce.time_s for bounce in motion.collisions])
    frames = np.array([schedule.frame_coordinate(time_s) for time_s in times_s])
    ball_m = motion.sample(times_s).ball_far_face_m + setup.ball_diameter_m / 2
    up_m = np.zeros_like(ball_m)
    if scene.view.rising_path:
        rest_m = setup.wall_gap_m + setup.ball_diameter_m / 2
        up_m = rise_m(setup, ball_m - rest_m, setup.light_thread_m)
    shift = tripod_shift(scene.tripod, schedule, seed)
    there = np.stack([np.interp(frames, np.arange(len(shift)), axis) for axis in shift.T], axis=-1)
    ball_px, _ = projection.image(ball_m, up_m, there)
    return tuple(
        Event(float(frame), bounce.kind, float(place))
        for frame, bounce, place in zip(frames, motion.collisions, ball_px, strict=True)
    )


# ---- other experiments ---------------------------------------------------------------------------

VISIBLE_PX = 1.0
"""A hop that leads less far from its stop counts as rest."""


@dataclass(frozen=True)
class ExperimentTruth(ClipTruth):
    """Truth of a clip of another experiment; ``events`` are those within the clip."""

    sure: int
    """How many of them the frames show beyond doubt."""
    bodies: tuple[PathTruth, ...]

    @property
    def resolved(self) -> bool:
        """True if the frames show each collision."""
        return self.sure == self.count

    @property
    def countable(self) -> bool:
        """False for an experiment that shows nothing to count."""
        return self.scene.experiment.kind not in NOTHING_TO_COUNT

    def figures(self) -> dict[str, object]:
        """Return what is true of an experiment alone, by the keys of the file."""
        return {
            "accept": list(range(self.sure, self.count + 1)),
            "bodies": len(self.bodies),
            "body_length_px": self.scene.setup.ball_diameter_m * self.px_per_m,
        }

    def frame_rows(self) -> Iterator[dict[str, object]]:
        """Yield where every body's centre is in each frame."""
        for k in range(self.frames):
            yield {
                "frame": k,
                "bodies_px": [[round(b.x_px[k], 5), round(b.y_px[k], 5)] for b in self.bodies],
                "bodies_m": [[round(b.along_m[k], 9), round(b.up_m[k], 9)] for b in self.bodies],
            }


def truth_of_course(
    scene: Scene, seed: int, course: Course, schedule: Schedule, projection: Projection
) -> ExperimentTruth:
    """Collect the truth of a clip from what happens in it."""
    bodies = []
    shift_px = tripod_shift(scene.tripod, schedule, seed)
    for place in course.places:
        along_m, up_m = place(schedule.centre_s)
        bodies.append(PathTruth(along_m, up_m, *projection.image(along_m, up_m, shift_px)))
    last = len(schedule.centre_s) - 0.5
    placed = ((contact, schedule.frame_coordinate(contact.time_s)) for contact in course.contacts)
    events = tuple(Event(frame, contact.kind) for contact, frame in placed if -0.5 <= frame <= last)
    return ExperimentTruth(
        scene=scene,
        seed=seed,
        events=events,
        sure=_sure(course, schedule, projection.px_per_m, scene.camera.capture_fps),
        px_per_m=projection.px_per_m,
        frames=len(schedule.centre_s),
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


# ---- the file ------------------------------------------------------------------------------------


def truth_path(clip_path: Path) -> Path:
    """Where the truth of a clip is kept: ``trial.truth.json`` beside ``trial.mp4``."""
    return clip_path.with_name(f"{clip_path.stem}.truth.json")


def check_place(clip_path: Path) -> None:
    """Refuse to write over anything but a clip of this program with its truth.

    Raises
    ------
    UsageError
        If the clip or its truth is there, but not both, or that is no truth.
    """
    both = clip_path, truth_path(clip_path)
    there = [path for path in both if os.path.lexists(path)]
    if there and not (len(there) == len(both) and _is_truth(both[1])):
        raise UsageError(
            f"{there[0]}: this is no clip of this program with its truth; move it away, or give "
            "the clip another name"
        )


def _is_truth(path: Path) -> bool:
    """Whether a file is the truth of a clip."""
    with suppress(OSError, UsageError, ValueError):
        said = json_value(read_text(path, _MOST_BYTES))
        return isinstance(said, dict) and said.get("frame_convention") == FRAME_CONVENTION
    return False


def write_text(text: str, path: Path) -> None:
    """Write a file that appears under its name only when it is complete.

    Raises
    ------
    UsageError
        If the file cannot be written.
    """
    with explained(path):
        write_whole(path, text.encode("utf-8"))

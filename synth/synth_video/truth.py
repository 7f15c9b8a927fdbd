"""What a synthetic clip really shows, and its file.

Truth along the line of motion is given in px of image x, as everywhere in this project, and as
image points (x, y); metres point away from the wall.
"""

from __future__ import annotations

import json
import os
from dataclasses import asdict, dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from count_video.errors import UsageError
from count_video.physics.simulator import Motion
from count_video.records import CollisionKind, Floats
from synth_video.experiments.course import rise_m
from synth_video.projection import Projection
from synth_video.scene import Scene
from synth_video.schedule import Schedule
from synth_video.tripod import tripod_shift

RESOLVED_FRAMES = 2.5
"""Collisions of the burst at least this far apart are seen one by one in the frames."""
FRAME_CONVENTION = (
    "frame k is the centre of the exposure of the k-th picture, k from 0; "
    "image x right and y down in px, an integer is the centre of a pixel; "
    "metres point away from the wall's face"
)


@dataclass(frozen=True)
class Event:
    """One collision of the truth."""

    frame: float
    """Frame coordinate."""
    kind: CollisionKind
    ball_px: float
    """Where the ball's centre is seen, along the line of motion (image x)."""


@dataclass(frozen=True)
class FaceTruth:
    """One face, at the centres of the exposures, along the line of motion."""

    along_m: Floats
    """Distance from the wall, shape (n,)."""
    x_px: Floats
    y_px: Floats
    """Image point, shape (n,) each; x is also the position along the line."""


@dataclass(frozen=True)
class Truth:
    """Truth of one clip."""

    scene: Scene
    seed: int
    events: tuple[Event, ...]
    """Collisions of the burst, in order; also those outside the clip."""
    events_after_burst: tuple[Event, ...]
    """Collisions after the cylinder turned back that lie within the clip."""
    px_per_m: float
    """Scale along the line of motion (of its own length, not of its image x)."""
    ball_near: FaceTruth
    ball_far: FaceTruth
    cylinder: FaceTruth
    wall: FaceTruth

    @property
    def count(self) -> int:
        """Number of collisions of the burst."""
        return len(self.events)

    @property
    def frames(self) -> int:
        """Number of frames."""
        return len(self.wall.x_px)

    @property
    def shortest_interval_frames(self) -> float:
        """Shortest time between two collisions of the burst; inf for fewer than two."""
        return min((b.frame - a.frame for a, b in pairwise(self.events)), default=float("inf"))

    @property
    def resolved(self) -> bool:
        """True if the frames show each collision of the burst."""
        return self.shortest_interval_frames >= RESOLVED_FRAMES

    @property
    def whole(self) -> bool:
        """True if the clip shows the whole burst; only such a clip can be counted."""
        last = len(self.wall.x_px) - 1
        return bool(self.events) and all(0 <= event.frame <= last for event in self.events)

    @property
    def mass_ratio(self) -> float:
        """Heavy over light."""
        return self.scene.setup.heavy_mass_kg / self.scene.setup.light_mass_kg

    @property
    def ball_diameter_px(self) -> float:
        """Diameter of the ball in the picture."""
        return self.scene.setup.ball_diameter_m * self.px_per_m


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

    def face(along_m: Floats, up_m: Floats) -> FaceTruth:
        return FaceTruth(along_m, *projection.image(along_m, up_m, shift_px))

    nothing = np.zeros_like(sample.heavy_face_m)
    events = _events(motion, scene, seed, schedule, projection)
    burst, last = len(motion.burst), len(schedule.centre_s) - 0.5
    return Truth(
        scene=scene,
        seed=seed,
        events=events[:burst],
        events_after_burst=tuple(e for e in events[burst:] if -0.5 <= e.frame <= last),
        px_per_m=projection.px_per_m,
        ball_near=face(sample.ball_near_face_m, ball_up),
        ball_far=face(sample.ball_far_face_m, ball_up),
        cylinder=face(sample.heavy_face_m, heavy_up),
        wall=face(nothing, nothing),
    )


def truth_path(clip_path: Path) -> Path:
    """Where the truth of a clip is kept: ``trial.truth.json`` beside ``trial.mp4``."""
    return clip_path.with_name(f"{clip_path.stem}.truth.json")


def write_text(text: str, path: Path) -> None:
    """Write a file that appears under its name only when it is complete.

    Raises
    ------
    UsageError
        If the file cannot be written.
    """
    partial = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        partial.write_text(text, encoding="utf-8")
        os.replace(partial, path)
    except OSError as error:
        raise UsageError(f"cannot write {path}: {error.strerror}; check the folder") from error
    finally:
        partial.unlink(missing_ok=True)


def truth_json(truth: Truth) -> str:
    """Write the truth as JSON text: a line for each frame, keys always in this order."""
    scene = truth.scene
    shortest = truth.shortest_interval_frames
    head = {
        "seed": truth.seed,
        "scene": asdict(scene),
        "capture_fps": scene.camera.capture_fps,
        "container_fps": scene.encoding.container_fps,
        "frame_convention": FRAME_CONVENTION,
        "expect": "counted" if truth.whole else "not_counted",
        "count": truth.count,
        "count_after_burst": len(truth.events_after_burst),
        "events": [_event_json(event) for event in truth.events],
        "events_after_burst": [_event_json(event) for event in truth.events_after_burst],
        "resolved": truth.resolved,
        "shortest_interval_frames": round(shortest, 6) if np.isfinite(shortest) else None,
        "mass_ratio": truth.mass_ratio,
        "ball_diameter_px": truth.ball_diameter_px,
        "px_per_m": truth.px_per_m,
        "wall_side": scene.wall.side,
    }
    lines = ",\n".join(f"  {json.dumps(row)}" for row in _frame_rows(truth))
    return f'{json.dumps(head, indent=1)[:-2]},\n "frames": [\n{lines}\n ]\n}}\n'


def _event_json(event: Event) -> dict[str, object]:
    return {
        "frame": round(event.frame, 6),
        "kind": event.kind,
        "ball_px": round(event.ball_px, 5),
    }


def _frame_rows(truth: Truth) -> list[dict[str, object]]:
    """One dictionary a frame; px to 1e-5, metres to 1e-9."""
    faces = {
        "ball_near": truth.ball_near,
        "ball_far": truth.ball_far,
        "cylinder": truth.cylinder,
        "wall": truth.wall,
    }
    columns = {
        name: (np.round(f.along_m, 9), np.round(f.x_px, 5), np.round(f.y_px, 5))
        for name, f in faces.items()
    }
    rows = []
    for k in range(len(truth.wall.x_px)):
        row: dict[str, object] = {"frame": k}
        for name, (along_m, x_px, y_px) in columns.items():
            row[f"{name}_m"] = float(along_m[k])
            row[f"{name}_px"] = float(x_px[k])
            row[f"{name}_point_px"] = [float(x_px[k]), float(y_px[k])]
        rows.append(row)
    return rows


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
    pictures = np.arange(len(shift))
    there = np.stack([np.interp(frames, pictures, axis) for axis in shift.T], axis=-1)
    ball_px, _ = projection.image(ball_m, up_m, there)
    return tuple(
        Event(float(frame), bounce.kind, float(place))
        for frame, bounce, place in zip(frames, motion.collisions, ball_px, strict=True)
    )

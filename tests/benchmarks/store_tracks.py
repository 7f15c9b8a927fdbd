"""Store the tracks of clips, a small file each, to score what is inferred from them without pixels.

``python tests/benchmarks/store_tracks.py OUT CLIP...`` works through each clip and writes
``OUT/NAME.npz`` with every track that the inference was given, in order, and the truth that lies
beside the clip (``NAME.truth.json``), if there is any. A clip that has its file already is left
out, so the command can be repeated. ``stored_clip`` reads such a file.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from count_video import pipeline
from count_video.errors import CountVideoError
from count_video.records import BodyTrack, MotionLine, Track


@dataclass(frozen=True)
class StoredClip:
    """What is stored of a clip."""

    name: str
    pairs: tuple[Track, ...]
    """Tracks of two bodies that were offered, in the order in which they were tried."""
    free: tuple[Track, ...]
    """Tracks of one body, or of two without a wall, found without a pair at a wall."""
    ahead: tuple[bool, ...]
    """Of each free track and then of each pair: whether something stands ahead of the bodies."""
    answer: dict[str, Any]
    """What the pipeline answered: count, reason, seconds of processor time, the track it used."""
    truth: dict[str, Any] | None


class _Recorder:
    """Keeps the tracks that pass through the pipeline."""

    def __init__(self) -> None:
        self.pairs: list[Track] = []
        self.free: list[Track] = []
        self._pair, self._free = pipeline._with_pair, pipeline.track_free_bodies

    def __enter__(self) -> _Recorder:
        pipeline._with_pair = self._record_pair
        pipeline.track_free_bodies = self._record_free
        return self

    def __exit__(self, *_: object) -> None:
        pipeline._with_pair, pipeline.track_free_bodies = self._pair, self._free

    def _record_pair(self, footage: Any, track: Track, settings: Any) -> Any:
        self.pairs.append(track)
        return self._pair(footage, track, settings)

    def _record_free(self, *arguments: Any) -> Track:
        self.free.append(self._free(*arguments))
        return self.free[-1]


def store(clip: Path, out: Path) -> str:
    """Work through a clip and write its tracks; the line to print."""
    began = time.process_time()
    with _Recorder() as recorder:
        try:
            trial = pipeline.work_through(clip, pipeline.TrialSettings())
        except CountVideoError as error:
            return f"{clip.name}: {error}"
    seconds = time.process_time() - began
    offered = [*recorder.pairs, *recorder.free]
    used = next((n for n, track in enumerate(offered) if track is trial.track), None)
    result = trial.result
    answer = {
        "count": result.count,
        "reason": result.reason,
        "probability": {str(n): p for n, p in result.probability.items()},
        "collisions": [asdict(collision) for collision in result.collisions],
        "capture_fps": result.capture_fps,
        "frames_decoded": result.frames_decoded,
        "frames_promised": result.frames_promised,
        "warnings": list(result.warnings),
        "seconds": seconds,
        "used": used,
    }
    truth_path = clip.with_suffix(".truth.json")
    truth = json.loads(truth_path.read_text()) if truth_path.exists() else None
    about = {"pairs": len(recorder.pairs), "answer": answer, "truth": truth}
    arrays: dict[str, Any] = {"about": json.dumps(about)}
    for number, track in enumerate(offered):
        arrays |= {f"{number}.{key}": value for key, value in _as_arrays(track).items()}
    partial = out / f".{clip.stem}.npz"
    np.savez_compressed(partial, **arrays)
    os.replace(partial, out / f"{clip.stem}.npz")
    return f"{clip.name}: {len(offered)} tracks, count {result.count}, {seconds:.0f} s"


def _as_arrays(track: Track) -> dict[str, Any]:
    bodies = {"ball": track.ball, "heavy": track.heavy}
    arrays: dict[str, Any] = {"frame": track.frame}
    for name, body in bodies.items():
        if body is not None:
            arrays[f"{name}.position_px"] = body.position_px
            arrays[f"{name}.sigma_px"] = body.sigma_px
            arrays[f"{name}.edges_px"] = np.array([body.low_edge_px, body.high_edge_px])
    arrays["scalars"] = json.dumps(
        {
            "wall_side": track.wall_side,
            "ball_diameter_px": track.ball_diameter_px,
            "line": asdict(track.line),
            "warnings": list(track.warnings),
            "wall_seen": track.wall_seen,
            "by_silhouette": track.by_silhouette,
            "ball_is_round": track.ball_is_round,
        }
    )
    return arrays


def stored_clip(path: Path) -> StoredClip:
    """Read what was stored of a clip."""
    with np.load(path) as stored:
        about = json.loads(str(stored["about"]))
        numbers = sorted({int(key.split(".")[0]) for key in stored.files if key != "about"})
        tracks = [_as_track(stored, number) for number in numbers]
    pairs = about["pairs"]
    return StoredClip(
        path.stem, tuple(tracks[:pairs]), tuple(tracks[pairs:]), (), about["answer"], about["truth"]
    )


def _as_track(stored: Any, number: int) -> Track:
    scalars = json.loads(str(stored[f"{number}.scalars"]))
    bodies = {}
    for name in ("ball", "heavy"):
        if f"{number}.{name}.position_px" in stored.files:
            edges = stored[f"{number}.{name}.edges_px"]
            bodies[name] = BodyTrack(
                stored[f"{number}.{name}.position_px"],
                stored[f"{number}.{name}.sigma_px"],
                float(edges[0]),
                float(edges[1]),
            )
    line, warnings = MotionLine(**scalars.pop("line")), tuple(scalars.pop("warnings"))
    frame = stored[f"{number}.frame"]
    return Track(
        frame=frame,
        ball=bodies["ball"],
        heavy=bodies.get("heavy"),
        line=line,
        warnings=warnings,
        **scalars,
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Store the tracks of all clips named."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=Path)
    parser.add_argument("clips", type=Path, nargs="+")
    options = parser.parse_args(arguments)
    options.out.mkdir(parents=True, exist_ok=True)
    for clip in options.clips:
        if not (options.out / f"{clip.stem}.npz").exists():
            sys.stdout.write(f"{store(clip, options.out)}\n")
            sys.stdout.flush()
    return 0


if __name__ == "__main__":
    raise SystemExit(main())

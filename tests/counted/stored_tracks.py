"""Tracks of one clip of every cell of the suite, and what is counted in them without a picture.

``python tests/counted/stored_tracks.py CLIP...`` follows the bodies of rendered clips of the suite
and keeps their tracks in ``suite_tracks.npz``, beside those that are there; clips in which no
bodies can be followed are left out. Places are kept to a thousandth of a pixel or frame and
uncertainties to a hundredth of themselves, so that the file stays small.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, nullcontext
from dataclasses import asdict, dataclass, fields, replace
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from unittest.mock import patch

import numpy as np
from counting import truth_of

from count_video import pipeline
from count_video.errors import TrackingError
from count_video.records import BodyTrack, Floats, FootageInfo, FootageReport, MotionLine, Track
from count_video.reports.exports import json_object
from count_video.video.reader import open_footage
from synth_video.suite.scoring import ClipScore, score

FILE = Path(__file__).with_name("suite_tracks.npz")
STEP = 0.001
"""Of places in px, of frame coordinates, ..."""
SIGMA_STEP = 0.01
"""... and of the logarithm of uncertainties."""
NOT_SEEN = np.iinfo(np.int32).min
BODIES = ("ball", "heavy")
Integers = np.ndarray[Any, np.dtype[np.int32]]


@dataclass(frozen=True)
class StoredClip:
    """What is kept of a clip."""

    track: Track
    info: FootageInfo
    report: FootageReport
    truth: dict[str, Any]


def counted(stored: StoredClip) -> ClipScore:
    """Count the collisions in a stored track as in a clip, and compare them with the truth."""
    with _tracking_gives(stored):
        result = pipeline.work_through(stored.info.path, pipeline.TrialSettings()).result
    return score(stored.info.path.stem, stored.truth, json_object(result))


@contextmanager
def _tracking_gives(stored: StoredClip) -> Iterator[None]:
    footage = SimpleNamespace(info=stored.info, report=lambda: stored.report)
    view = SimpleNamespace(footage=footage)
    seen = SimpleNamespace(view=view, movers=None, frames=None, whole=True)
    alone = stored.track.heavy is None

    def without_pair(*_: object, **__: object) -> list[Track]:
        if not alone and stored.track.wall_seen:
            raise TrackingError("two bodies were stored")
        return [stored.track]

    replaced = {
        "open_footage": lambda *_, **__: nullcontext(footage),
        "observe": lambda *_, **__: nullcontext(seen),
        "stands_beyond": lambda *_: (False, False),
        "moves_beside": lambda *_: False,
        "pair_tracks": lambda *_, **__: [] if alone else [stored.track],
        "single_tracks": without_pair,
    }
    with patch.multiple(pipeline, **replaced):
        yield


@cache
def on_file() -> Mapping[str, StoredClip]:
    """Read what is stored, by the clip's name."""
    with np.load(FILE) as stored:
        about: dict[str, Any] = json.loads(str(stored["about"]))
        return {name: _unpacked(name, one, stored[name]) for name, one in about.items()}


def put_on_file(clips: Mapping[str, StoredClip]) -> None:
    """Store clips by their names."""
    about = {name: _about(clip) for name, clip in clips.items()}
    rows = {name: _packed(clip.track) for name, clip in clips.items()}
    np.savez_compressed(FILE, about=np.array(json.dumps(about)), **rows)


def follow(clip: Path) -> StoredClip | None:
    """Count a clip and keep its track; None where no bodies can be followed."""
    worked = pipeline.work_through(clip, pipeline.TrialSettings())
    if worked.track is None or worked.result.frames_decoded is None:
        return None
    found, truth = worked.result, truth_of(clip)
    report = FootageReport(worked.result.frames_decoded, found.frames_promised, ())
    events = [{"frame": round(one["frame"], 3), "kind": one["kind"]} for one in truth["events"]]
    kept = {key: truth[key] for key in ("count", "expect", "accept") if key in truth}
    with open_footage(clip) as footage:
        info = footage.info
    return StoredClip(worked.track, info, report, kept | {"events": events})


def _about(clip: StoredClip) -> dict[str, Any]:
    track = replace(clip.track, shift_px=None)  # nothing that is counted depends on it
    about = asdict(track)
    del about["frame"]
    for name in BODIES:
        body = getattr(track, name)
        about[name] = None if body is None else [body.low_edge_px, body.high_edge_px]
    info = asdict(clip.info) | {"path": clip.info.path.name}
    return {"track": about, "info": info, "report": asdict(clip.report), "truth": clip.truth}


def _packed(track: Track) -> Integers:
    """Rows of integers: frames, and of each body its places and their uncertainties."""
    bodies = [body for body in (track.ball, track.heavy) if body is not None]
    rows = [_steps(track.frame, STEP)]
    for body in bodies:
        rows += [_steps(body.position_px, STEP), _steps(np.log(body.sigma_px), SIGMA_STEP)]
    return np.array(rows)


def _unpacked(name: str, about: dict[str, Any], rows: Integers) -> StoredClip:
    track = _known(Track, about["track"])
    bodies = (
        BodyTrack(_values(rows[k], STEP), np.exp(_values(rows[k + 1], SIGMA_STEP)), *track[body])
        for k, body in zip((1, 3), BODIES, strict=True)
        if track[body] is not None
    )
    track |= {"frame": _values(rows[0], STEP), "line": MotionLine(**track["line"])}
    track |= {"warnings": tuple(track["warnings"])} | dict(zip(BODIES, bodies, strict=False))
    info = FootageInfo(**_known(FootageInfo, about["info"]) | {"path": Path(f"{name}.mp4")})
    report = FootageReport(**_known(FootageReport, about["report"]) | {"warnings": ()})
    return StoredClip(Track(**track), info, report, about["truth"])


def _known(record: type, stored: dict[str, Any]) -> dict[str, Any]:
    """Return of what is stored the fields that a record has today."""
    return {field.name: stored[field.name] for field in fields(record) if field.name in stored}


def _steps(values: Floats, step: float) -> Integers:
    """Differences in whole steps, which take little space."""
    seen = np.isfinite(values)
    steps = np.full(len(values), NOT_SEEN, np.int32)
    steps[seen] = np.diff(np.rint(values[seen] / step), prepend=0.0)
    return steps


def _values(steps: Integers, step: float) -> Floats:
    seen = steps != NOT_SEEN
    values = np.full(len(steps), np.nan)
    values[seen] = np.cumsum(steps[seen], dtype=np.int64) * step
    return values


def main(clips: list[Path]) -> None:
    """Follow clips and store them beside those on file."""
    clips_on_file = dict(on_file()) if FILE.exists() else {}
    for clip in clips:
        followed = follow(clip)
        sys.stdout.write(f"{clip.stem}: {'followed' if followed else 'left out'}\n")
        if followed is not None:
            clips_on_file[clip.stem] = followed
    put_on_file(dict(sorted(clips_on_file.items())))


if __name__ == "__main__":
    main([Path(name) for name in sys.argv[1:]])

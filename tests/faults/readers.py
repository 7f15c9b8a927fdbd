"""What reads files from outside, each with a sound file to begin from."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from count_video.answers import Followed
from count_video.batch.executor import tool_version
from count_video.batch.manifest import Job, read_manifest
from count_video.batch.results import ResultStore, packed, unpacked
from count_video.corrections import reviewed
from count_video.errors import CountVideoError
from count_video.outputs import OutputFolder
from count_video.pipeline import TrialSettings
from count_video.planning.request import PLAN_VERSION, PlanRequest, read_request, request_object
from count_video.records import TrialResult
from count_video.reports.exports import json_line
from count_video.settings import EvidenceSettings
from count_video.video.reader import open_footage
from count_video.video.writer import WriteOptions, write_clip

FRAMES = 12
FRAMES_READ = 60
_UNEVEN_S = tuple(0.03 * k + 0.007 * (k % 3) for k in range(FRAMES))


@dataclass(frozen=True)
class Reader:
    """One way in."""

    file: str
    """Name that the file must have."""
    sound: Callable[[Path], None]
    """Writes a sound file."""
    read: Callable[[Path], object]
    """Reads a file; raises nothing but ``CountVideoError`` (or ValueError for a kept result)."""


def _clip(codec: str, pixel_format: str = "yuv420p", **more: Any) -> Callable[[Path], None]:
    def write(path: Path) -> None:
        ramp = np.add.outer(np.arange(48), np.arange(64))
        pictures = ((ramp + 9 * k).astype(np.uint8) for k in range(FRAMES))
        tags = {"com.android.capture.fps": "240.000000", "title": "a title"}
        options = WriteOptions(codec=codec, pixel_format=pixel_format, metadata=tags, **more)
        write_clip(path, pictures, options)

    return write


def _read_clip(path: Path) -> None:
    with open_footage(path) as footage:
        for _ in islice(footage.frames(), FRAMES_READ):
            pass
        footage.report()


def _write_manifest(path: Path) -> None:
    path.write_text(
        "clip,name,region,masses,wall,capture_fps,start,end,ball_diameter_mm\n"
        'a.mp4,first,"1,2,30,40",1050 10.5,left,960,3,9,20\n'
        '"sub/b, c.mp4",,,,,,,,\n',
        "utf-8",
    )


def _write_corrections(path: Path) -> None:
    entry = {"action": "missed", "kind": "wall", "frame": 30, "number": None}
    fields = {"corrections_version": 1, "clip": "clip.mp4", "tool_count": None}
    path.write_text(json.dumps(fields | {"reviewed_count": 1, "corrections": [entry]}), "utf-8")


def _read_corrections(path: Path) -> None:
    reviewed(
        replace(TrialResult("clip.mp4", "not_counted", "nothing moves"), frames_decoded=100), path
    )


def _write_plan(path: Path) -> None:
    request = request_object(PlanRequest(1050, 10.5, capture_fps=240.0))
    path.write_text(json.dumps({"plan_version": PLAN_VERSION, "request": request}), "utf-8")


def _write_result(path: Path) -> None:
    path.write_text(packed(TrialResult("clip.mp4", "not_counted", "nothing moves")), "utf-8")


def _read_result(path: Path) -> None:
    try:
        unpacked(TrialResult, path.read_text("utf-8", "replace"))
    except ValueError:  # what the store takes for no result
        return


def _write_record(path: Path) -> None:
    lines = [{"name": "clip.html", "clip": "0" * 64}, {"name": "clip.png", "clip": "0" * 64}]
    path.parent.mkdir(exist_ok=True)
    path.write_text("\n".join(map(json.dumps, lines)) + "\n", "utf-8")


def _read_record(path: Path) -> None:
    OutputFolder(path.parents[1]).written()


def _write_kept(path: Path) -> None:
    path.parent.mkdir(exist_ok=True)
    result = TrialResult("clip.mp4", "not_counted", "nothing moves")
    (path.parents[1] / "clip.json").write_text(f"{json_line(result)}\n", "utf-8")
    options = json.dumps(asdict(TrialSettings()), default=str, sort_keys=True)
    kept = {"clip": "0", "tool": tool_version(), "options": options, "signature": []}
    kept |= {"read": True, "evidence": {"clip.html": [1, 2]}}
    path.write_text(f"{json.dumps(kept)}\n{packed(Followed(result))}\n", "utf-8")


def _read_kept(path: Path) -> None:
    job = Job("clip", "clip.mp4", TrialSettings(), pages=EvidenceSettings(path.parents[1]))
    store = ResultStore(OutputFolder(path.parents[1]), fresh=False)
    store.recall(job)


def _write_followed(path: Path) -> None:
    path.write_text(packed(Followed(TrialResult("clip.mp4", "not_counted", "nothing moves"), None)))


def _read_followed(path: Path) -> None:
    try:
        unpacked(Followed, path.read_text("utf-8", "replace"))
    except ValueError:  # then the clip is counted again
        return


CONTAINERS: Mapping[str, Reader] = {
    "mp4": Reader("clip.mp4", _clip("libx264"), _read_clip),
    "mov": Reader("clip.mov", _clip("mjpeg"), _read_clip),
    "mkv": Reader("clip.mkv", _clip("ffv1"), _read_clip),
    "avi": Reader("clip.avi", _clip("mjpeg"), _read_clip),
    "webm": Reader("clip.webm", _clip("libvpx"), _read_clip),
    "ts": Reader("clip.ts", _clip("libx264"), _read_clip),
    # as phones write them: a modern codec, the index last, a turned picture, uneven times
    "hevc": Reader("clip.mov", _clip("libx265", index_first=False, rotation_deg=90), _read_clip),
    "uneven": Reader(
        "clip.mp4", _clip("libx264", frame_times_s=_UNEVEN_S, more={"bf": "2"}), _read_clip
    ),
    "vp9": Reader("clip.mkv", _clip("libvpx-vp9"), _read_clip),
    "av1": Reader("clip.mp4", _clip("libsvtav1"), _read_clip),
    "mpeg4": Reader("clip.avi", _clip("mpeg4"), _read_clip),
    "png": Reader("clip.mov", _clip("png", "gray"), _read_clip),
}
READERS: Mapping[str, Reader] = CONTAINERS | {
    "manifest": Reader("clips.csv", _write_manifest, lambda p: read_manifest(p, TrialSettings())),
    "corrections": Reader("clip.json", _write_corrections, _read_corrections),
    "plan": Reader("plan.json", _write_plan, read_request),
    "result": Reader("result.json", _write_result, _read_result),
    "record": Reader(".count-video/written", _write_record, _read_record),
    "kept": Reader(".count-video/clip.jsonl", _write_kept, _read_kept),
    "followed": Reader("followed.json", _write_followed, _read_followed),
}


def refusal(reader: Reader, path: Path) -> str:
    """Read a file; return the one line that it is refused with, empty if it is not."""
    try:
        reader.read(path)
    except CountVideoError as error:
        return str(error)
    return ""

"""The evidence for one clip: pictures, annotated clip, tables and page, next to its count.

The clip is decoded a second time, once for everything: each frame is drawn into the annotated
clip and leaves its line in the space-time image and its cut-outs at the contacts on the page.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from typing import Literal

import numpy as np

from count_video.corrections import reviewed
from count_video.errors import UsageError
from count_video.footage.reader import open_footage
from count_video.footage.writer import WriteOptions, write_clip
from count_video.inputs import content_digest
from count_video.motion.swing import Swing
from count_video.outputs import OutputFolder, open_outputs, output_name, write_whole
from count_video.planning.comparison import compared
from count_video.planning.stored import read_request
from count_video.progress import NO_PROGRESS, Progress, counted_off
from count_video.records import Floats, Track, TrialResult
from count_video.reports.annotated_clip import AnnotatedClip
from count_video.reports.csv_files import collisions_csv, track_csv
from count_video.reports.drawing import picture_bytes
from count_video.reports.levelling import FRAMES_ENOUGH, levelled
from count_video.reports.material import Material, Pendulum
from count_video.reports.pace import frame_times_s
from count_video.reports.page import Footage, Picture, clip_page
from count_video.reports.picture import trial_figure
from count_video.reports.printable import printable
from count_video.reports.thumbnail import thumbnail_jpeg
from count_video.reports.touching import touching
from count_video.trial import Trial, TrialSettings, work_through

PictureFormat = Literal["png", "svg"]
MEDIA_TYPES: dict[PictureFormat, str] = {"png": "image/png", "svg": "image/svg+xml"}
_SUFFIXES = ("html", "annotated.mp4", "strip.jpg", "track.csv", "collisions.csv")
CRF = 23
"""Quality of the annotated clip: lines and letters stay clean, a page holds it easily."""


@dataclass(frozen=True)
class EvidenceSettings:
    """Where the evidence goes and what it looks like."""

    folder: Path
    """Made if it is not there."""
    picture_format: PictureFormat = "png"
    corrections: Path | None = None
    """File of a person's corrections to lay over the result."""
    plan_file: Path | None = None
    """File of the plan to hold the result against."""
    name: str | None = None
    """What the files are named after; None for the clip's name without its suffix."""


def count_with_evidence(
    path: Path,
    settings: TrialSettings,
    evidence: EvidenceSettings,
    progress: Progress = NO_PROGRESS,
) -> TrialResult:
    """Count a clip as ``trial.count_clip`` does and write its evidence beside the answer.

    Files are named after the clip: for ``trial7.mp4`` they are ``trial7.html``, ``trial7.png``
    (or ``.svg``), ``trial7.strip.jpg``, ``trial7.annotated.mp4``, ``trial7.track.csv`` and
    ``trial7.collisions.csv``. Where no bodies could be followed there is the page alone. Each
    appears when it is complete.

    Raises
    ------
    FootageError
        If the file cannot be read as footage.
    UsageError
        If a setting does not fit the clip, the corrections are not for it, or the evidence cannot
        be written.
    """
    return make_evidence(path, settings, evidence, progress).result


@dataclass(frozen=True)
class Evidence:
    """What came of a clip."""

    result: TrialResult
    files: tuple[str, ...]
    """Names of the files that show it, in the folder of the evidence."""


def make_evidence(
    path: Path,
    settings: TrialSettings,
    evidence: EvidenceSettings,
    progress: Progress = NO_PROGRESS,
) -> Evidence:
    """Do what :func:`count_with_evidence` does, and say which files there are."""
    plan = None if evidence.plan_file is None else read_request(evidence.plan_file)
    outputs = open_outputs(evidence.folder)
    content = content_digest(path) if path.is_file() else ""
    files = _Files(outputs, evidence.name or output_name(path.stem), content)
    files.check((*_SUFFIXES, evidence.picture_format))
    trial = work_through(path, settings, progress)
    result = trial.result
    if evidence.corrections is not None:
        result = reviewed(result, evidence.corrections)
    if plan is not None:
        result = compared(result, plan)
    if trial.track is None:
        files.write("html", clip_page(result, None, None).encode("utf-8"))
    else:
        track = _shown_track(trial.info.path, trial.track, result)
        _write_all(trial, track, result, (files, evidence.picture_format), progress)
    return Evidence(result, tuple(files.written))


def shows_another_clip(folder: Path, path: Path) -> bool:
    """Return whether a folder holds the evidence of another clip of this name.

    Raises
    ------
    OSError, UsageError
        If the clip cannot be read.
    """
    page = f"{output_name(path.stem)}.html"
    clip = OutputFolder(folder).written().get(page)
    return bool(clip) and (folder / page).exists() and clip != content_digest(path)


def with_evidence(
    evidence: EvidenceSettings,
) -> Callable[[Path, TrialSettings, Progress], TrialResult]:
    """Make a function that counts a clip and writes its evidence."""

    def count(path: Path, settings: TrialSettings, progress: Progress) -> TrialResult:
        return count_with_evidence(path, settings, evidence, progress)

    return count


@dataclass(frozen=True)
class _Files:
    """The files of one clip."""

    outputs: OutputFolder
    name: str
    clip: str
    """Digest of the clip."""
    written: list[str] = field(default_factory=list)
    """Names of those that are there, or on their way."""

    def check(self, suffixes: Iterable[str]) -> None:
        """Raise UsageError if files are in the way that this program did not write."""
        for suffix in suffixes:
            self.outputs.check(f"{self.name}.{suffix}")

    def claim(self, suffix: str) -> Path:
        """Return where a file may be written."""
        # Not with_suffix: a name may hold dots.
        name = f"{self.name}.{suffix}"
        try:
            self.outputs.claim(name, self.clip)
        except OSError as error:
            raise _unwritable(self.outputs.folder / name, error) from error
        self.written.append(name)
        return self.outputs.folder / name

    def write(self, suffix: str, data: bytes) -> None:
        """Let a file appear under its name when it is complete."""
        target = self.claim(suffix)
        try:
            write_whole(target, data)
        except OSError as error:
            raise _unwritable(target, error) from error


def _unwritable(path: Path, error: OSError) -> UsageError:
    reason = error.strerror or "it failed"
    return UsageError(f"cannot write {printable(str(path))}: {reason}; give another folder")


def _write_all(
    trial: Trial,
    track: Track,
    result: TrialResult,
    into: tuple[_Files, PictureFormat],
    progress: Progress,
) -> None:
    files, picture_format = into
    files.write("track.csv", track_csv(track, result).encode("utf-8"))
    files.write("collisions.csv", collisions_csv(result).encode("utf-8"))
    clip = AnnotatedClip(result, track, (trial.info.height_px, trial.info.width_px))
    shown_s = frame_times_s(
        track.frame, [c.frame for c in result.collisions], trial.info.container_fps
    )
    annotated = files.claim("annotated.mp4")
    _write_clip(annotated, trial, clip, shown_s, progress)
    material = _material(trial, track, result, clip)
    picture = picture_bytes(trial_figure(material), picture_format)
    files.write(picture_format, picture)
    files.write("strip.jpg", thumbnail_jpeg(material))
    cuts = clip.contact_frames.found
    footage = Footage(annotated.read_bytes(), track.frame, shown_s, cuts, files.clip)
    page = clip_page(result, footage, Picture(picture, MEDIA_TYPES[picture_format]))
    files.write("html", page.encode("utf-8"))


def _shown_track(path: Path, track: Track, result: TrialResult) -> Track:
    """Put the outlines where they are seen to be; the motion is that of the track."""
    with open_footage(path) as footage:
        frames = list(islice(footage.frames(int(track.frame[0])), FRAMES_ENOUGH))
    return levelled(touching(track, result.collisions), frames)


def _write_clip(
    path: Path, trial: Trial, clip: AnnotatedClip, shown_s: Floats, progress: Progress
) -> None:
    first, last = int(clip.track.frame[0]), int(clip.track.frame[-1])
    progress.start(last + 1 - first, "drawing")
    options = WriteOptions(frame_times_s=shown_s.tolist(), crf=CRF)
    with open_footage(trial.info.path) as footage:
        frames = counted_off(footage.frames(first, last + 1), progress)
        write_clip(path, clip.pictures(frames), options)


def _material(
    trial: Trial,
    track: Track,
    result: TrialResult,
    clip: AnnotatedClip,
) -> Material:
    swing = None if trial.found is None else trial.found.swing
    return Material(
        result=result,
        track=track,
        space_time=clip.space_time(),
        pendulum=None if swing is None else _pendulum(swing, trial.track, track),
    )


def _pendulum(swing: Swing, measured: Track | None, shown: Track) -> Pendulum | None:
    """Give the swing of the heavy body's face as it is shown: shifted as the face is."""
    if measured is None or measured.heavy is None or shown.heavy is None:
        return None
    shift = float(np.nanmedian(shown.heavy.position_px - measured.heavy.position_px))
    outward = 1 if shown.wall_side == "left" else -1
    return Pendulum(swing.rate_squared, swing.centre_px + outward * shift)

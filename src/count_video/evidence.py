"""The evidence for one clip: pictures, annotated clip, tables and page, next to its count.

The clip is decoded a second time, once for everything: each frame is drawn into the annotated
clip and leaves its line in the space-time image and its cut-outs at the contacts on the page.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

from matplotlib.figure import Figure

from count_video.followed import Followed
from count_video.footage.reader import open_footage
from count_video.footage.writer import WriteOptions, write_clip
from count_video.inputs import content_digest
from count_video.outputs import (
    OutputFolder,
    explained,
    held,
    open_outputs,
    output_name,
    write_whole,
)
from count_video.process import DRAWING_BYTES, check_memory
from count_video.progress import NO_PROGRESS, Progress, counted_off
from count_video.records import Track
from count_video.reports.clip import AnnotatedClip, Pixels, layout_of
from count_video.reports.drawing import MEDIA_TYPES, picture_bytes
from count_video.reports.figure import (
    PANELS,
    panel_figures,
    thumbnail_jpeg,
    time_panels,
    trial_figure,
)
from count_video.reports.json_object import json_line
from count_video.reports.material import Material, Pendulum, touching
from count_video.reports.pace import frame_times_s
from count_video.reports.page import Footage, Picture, clip_page
from count_video.reports.presenter import Gif, presenter_layout
from count_video.reports.tables import collisions_array, table_csv, track_array
from count_video.settings import EvidenceSettings

_PRESENTER = ("presenter.mp4", "presenter.gif")
_SUFFIXES = ("html", "annotated.mp4", "strip.jpg", "track.csv", "collisions.csv")
CRF = 23
"""Quality of the annotated clip: lines and letters stay clean, a page holds it easily."""


def check_evidence(path: Path, evidence: EvidenceSettings) -> None:
    """Make the folder if needed and refuse it before a long count if files are in the way.

    Raises
    ------
    UsageError
        The folder cannot be made, or a file in it was not written by this program.
    """
    _opened(path, evidence, "json")


def draw_evidence(
    found: Followed,
    evidence: EvidenceSettings,
    progress: Progress = NO_PROGRESS,
    *,
    with_json: bool = False,
) -> tuple[str, ...]:
    """Write the evidence of a clip that was counted; return the names of the files.

    Files are named after the clip: for ``trial7.mp4`` they are ``trial7.html``, ``trial7.png``
    (or ``.svg``) and one for each of its panels, ``trial7.strip.jpg``, ``trial7.annotated.mp4``,
    ``trial7.track.csv`` and ``trial7.collisions.csv``. Where no bodies could be followed there is
    the page alone. Each appears when it is complete.

    Parameters
    ----------
    with_json
        Write the answer as ``trial7.json`` as well.

    Raises
    ------
    FootageError
        If the file cannot be read as footage any more.
    UsageError
        If the evidence cannot be written.
    """
    check_memory(DRAWING_BYTES)
    files = _opened(found.path, evidence)
    # Two clips of one name that are drawn at the same time would leave files of both.
    with held(files.outputs.hidden / f"{files.name}.lock", wait=True):
        if with_json:
            files.write("json", f"{json_line(found.result)}\n".encode("ascii"))
        if found.track is None:
            files.write("html", clip_page(found.result, None, None).encode("utf-8"))
        else:
            _write_all(found, found.track, files, progress)
    return tuple(files.written)


def draw_trial(found: Followed) -> Figure | None:
    """Draw the picture of a counted clip, which is decoded once more; None if nothing moved."""
    if found.track is None:
        return None
    clip, pendulum, _ = _clip_of(found, found.track)
    with open_footage(found.path) as footage:
        deque(clip.pictures(footage.frames(*_ends(clip.track))), maxlen=0)  # keeps the lines
    return trial_figure(Material(found.result, clip.track, clip.space_time(), pendulum))


def _opened(path: Path, evidence: EvidenceSettings, *more: str) -> _Files:
    """Open the folder for a clip.

    ``more`` are endings of files that will be written besides those of the evidence.

    Raises
    ------
    UsageError
        A file in the folder is not this program's own.
    """
    name, kind = evidence.name or output_name(path.stem), evidence.picture_format
    # The pictures are all panels on a sheet, and each alone.
    suffixes = [*_SUFFIXES, kind, *(f"{panel}.{kind}" for panel in PANELS), *more]
    suffixes += _PRESENTER if evidence.presenter else ()
    names = [f"{name}.{suffix}" for suffix in suffixes]
    outputs = open_outputs(evidence.folder, names, evidence.csv_dialect)
    return _Files(outputs, evidence, name, content_digest(path) if path.is_file() else "")


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


@dataclass(frozen=True)
class _Files:
    """The files of one clip."""

    outputs: OutputFolder
    wanted: EvidenceSettings
    name: str
    clip: str
    """Digest of the clip."""
    written: list[str] = field(default_factory=list)
    """Names of those that are there, or on their way."""

    def claim(self, suffix: str) -> Path:
        """Return where a file may be written."""
        # Not with_suffix: a name may hold dots.
        target = self.outputs.folder / f"{self.name}.{suffix}"
        with explained(target):
            self.outputs.claim(target.name, self.clip)
        self.written.append(target.name)
        return target

    def write(self, suffix: str, data: bytes) -> None:
        """Let a file appear under its name when it is complete."""
        target = self.claim(suffix)
        with explained(target):
            write_whole(target, self.outputs.as_written(target.name, data))


def _write_all(found: Followed, measured: Track, files: _Files, progress: Progress) -> None:
    result, kind = found.result, files.wanted.picture_format
    clip, pendulum, size = _clip_of(found, measured)
    track_csv = table_csv(track_array(clip.track, result), frame=".0f")
    files.write("track.csv", track_csv.encode("ascii"))
    files.write("collisions.csv", table_csv(collisions_array(result)).encode("ascii"))
    annotated = files.claim("annotated.mp4")
    _write_clip(found.path, annotated, clip, progress)
    material = Material(result, clip.track, clip.space_time(), pendulum)
    sheet = trial_figure(material)
    picture = picture_bytes(sheet, kind)
    files.write(kind, picture)
    for panel, figure in panel_figures(material).items():
        files.write(f"{panel}.{kind}", picture_bytes(figure, kind))
    files.write("strip.jpg", thumbnail_jpeg(material))
    shown = Footage(annotated.read_bytes(), clip.track.frame, clip.shown_s, clip.cuts, files.clip)
    drawn = Picture(picture, MEDIA_TYPES[kind], time_panels(sheet))
    files.write("html", clip_page(result, shown, drawn).encode("utf-8"))
    if files.wanted.presenter is not None:
        wall, most = measured.wall_side, result.burst_size
        layout = presenter_layout(files.wanted.presenter, *size, wall, most)
        talk, gif = AnnotatedClip(result, clip.track, layout, clip.shown_s), Gif(clip.shown_s)
        _write_clip(found.path, files.claim("presenter.mp4"), talk, progress, gif.keeping)
        files.write("presenter.gif", gif.data())


def _write_clip(
    path: Path,
    target: Path,
    clip: AnnotatedClip,
    progress: Progress,
    passing: Callable[[Iterator[Pixels]], Iterator[Pixels]] = iter,
) -> None:
    """Draw a clip while its footage is decoded; ``passing`` hands its pictures on."""
    first, end = _ends(clip.track)
    progress.start(end - first, "drawing")
    options = WriteOptions(frame_times_s=clip.shown_s.tolist(), crf=CRF)
    with open_footage(path) as footage:
        frames = counted_off(footage.frames(first, end), progress)
        write_clip(target, passing(clip.pictures(frames)), options)


def _clip_of(
    found: Followed, measured: Track
) -> tuple[AnnotatedClip, Pendulum | None, tuple[int, int]]:
    """Prepare the drawing of a clip, with the heavy body's face where the ball touches it.

    Returned are the drawing, the swing of that face, and width and height of the footage.
    """
    with open_footage(found.path) as footage:
        info = footage.info
    collisions, size = found.result.collisions, (info.width_px, info.height_px)
    track, pendulum = touching(measured, collisions, found.pendulum)
    shown_s = frame_times_s(track.frame, [c.frame for c in collisions], info.container_fps)
    return AnnotatedClip(found.result, track, layout_of(*size), shown_s), pendulum, size


def _ends(track: Track) -> tuple[int, int]:
    """First frame of a track, and the one after its last."""
    return int(track.frame[0]), int(track.frame[-1]) + 1

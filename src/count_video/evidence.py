"""The evidence for one clip: pictures, annotated clip, tables and page, next to its count.

The clip is decoded a second time, once for everything: each frame is drawn into the annotated
clip and leaves its line in the space-time image and its cut-outs at the contacts on the page.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

from matplotlib.figure import Figure

from count_video.answers import Followed
from count_video.inputs import content_digest
from count_video.outputs import OutputFolder, explained, held, open_outputs, output_name
from count_video.process import DRAWING_BYTES, check_memory
from count_video.progress import NO_PROGRESS, Progress, counted_off
from count_video.records import Floats, Frame, Track
from count_video.reports.clip import Gif, frame_times_s, layout_of, pictures, presented
from count_video.reports.drawing import MEDIA_TYPES, picture_bytes
from count_video.reports.exports import collisions_array, json_line, table_csv, track_array
from count_video.reports.figure import panel_figures, thumbnail_jpeg, time_panels, trial_figure
from count_video.reports.material import Material
from count_video.reports.page import PageMedia, clip_page, data_address
from count_video.reports.panels import PANELS
from count_video.settings import EvidenceSettings
from count_video.video.reader import Footage, open_footage
from count_video.video.writer import WriteOptions, write_clip


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
    ``trial7.track.csv`` and ``trial7.collisions.csv``, and with ``with_json`` the answer as
    ``trial7.json``. Where no bodies could be followed there is the page alone. Each appears when it
    is complete.

    Raises
    ------
    FootageError
        If the file cannot be read as footage any more.
    UsageError
        If the evidence cannot be written.
    """
    check_memory(DRAWING_BYTES)
    files = open_files(found.path, evidence)
    # Two clips of one name that are drawn at the same time would leave files of both.
    with held(files.outputs.hidden / f"{files.name}.lock", wait=True):
        if with_json:
            files.write("json", f"{json_line(found.result)}\n".encode("ascii"))
        material = _material(found)
        if material is None:
            files.write("html", clip_page(found.result).encode("utf-8"))
        else:
            _write_all(found.path, material, files, progress)
    return tuple(files.written)


def draw_trial(found: Followed) -> Figure | None:
    """Draw the picture of a counted clip, which is decoded once more; None if nothing moved."""
    material = _material(found)
    if material is None:
        return None
    with open_footage(found.path) as footage:
        deque(material.keeping(_rows(footage, material.track, NO_PROGRESS)), maxlen=0)
    return trial_figure(material)


def _material(found: Followed) -> Material | None:
    """Return what is drawn of a clip, with the heavy body's face where the ball touches it."""
    if found.track is None:
        return None
    return Material(found.result, found.track).touching()


def _rows(footage: Footage, track: Track, progress: Progress) -> Iterator[tuple[Frame, int]]:
    """Decode the frames of a track, each with its row."""
    rows = {int(index): row for row, index in enumerate(track.frame)}
    first, end = int(track.frame[0]), int(track.frame[-1]) + 1
    progress.start(end - first, "drawing")
    for frame in counted_off(footage.frames(first, end), progress):
        if frame.index in rows:
            yield frame, rows[frame.index]


@dataclass(frozen=True)
class _Files:
    """The files of one clip."""

    outputs: OutputFolder
    wanted: EvidenceSettings
    name: str
    path: Path
    """The clip."""
    written: list[str] = field(default_factory=list)
    """Names of those that are there, or on their way."""

    @cached_property
    def clip(self) -> str:
        """Digest of the clip."""
        return content_digest(self.path) if self.path.is_file() else ""

    def claim(self, suffix: str) -> Path:
        """Return where a file may be written."""
        # Not with_suffix: a name may hold dots.
        target, clip = self.outputs.folder / f"{self.name}.{suffix}", self.clip
        with explained(target):
            self.outputs.claim(target.name, clip)
        self.written.append(target.name)
        return target

    def write(self, suffix: str, data: bytes) -> None:
        """Let a file appear under its name when it is complete."""
        name = f"{self.name}.{suffix}"
        self.outputs.write_all([(name, data)], self.clip)
        self.written.append(name)


def open_files(path: Path, evidence: EvidenceSettings, *more: str) -> _Files:
    """Open the folder for the evidence, made if needed, and for files with ``more`` endings.

    UsageError if that fails, or if one of these files is there and not written by this program.
    """
    name, kind = evidence.name or output_name(path.stem), evidence.picture_format
    suffixes = ["html", "annotated.mp4", "strip.jpg", "track.csv", "collisions.csv", kind, *more]
    suffixes += [f"{panel}.{kind}" for panel in PANELS]
    suffixes += ["presenter.mp4", "presenter.gif"] if evidence.presenter else []
    names = [f"{name}.{suffix}" for suffix in suffixes]
    outputs = open_outputs(evidence.folder, names)
    return _Files(outputs, evidence, name, path)


def _write_all(path: Path, material: Material, files: _Files, progress: Progress) -> None:
    result, track = material.result, material.track
    dialect, rows = files.wanted.csv_dialect, track_array(track, result)
    files.write("track.csv", table_csv(rows, dialect, frame=".0f").encode("ascii"))
    files.write("collisions.csv", table_csv(collisions_array(result), dialect).encode("ascii"))
    annotated, shape = files.claim("annotated.mp4"), files.wanted.presenter
    with open_footage(path) as footage:
        info, collisions = footage.info, [c.frame for c in result.collisions]
        size = (info.width_px, info.height_px)
        shown_s = frame_times_s(track.frame, collisions, info.container_fps)
        # Lines and letters stay clean at this quality, and a page holds it easily.
        options = WriteOptions(frame_times_s=shown_s.tolist(), crf=23)
        frames = material.keeping(_rows(footage, track, progress))
        write_clip(annotated, pictures(material, layout_of(*size), shown_s, frames), options)
    _write_pictures(material, shown_s, annotated, files)
    if shape is not None:
        gif = Gif(shown_s)
        with open_footage(path) as footage:
            drawn = pictures(material, layout_of(*size), shown_s, _rows(footage, track, progress))
            talk = gif.keeping(presented(drawn, material, shape))
            write_clip(files.claim("presenter.mp4"), talk, options)
        files.write("presenter.gif", gif.data())


def _write_pictures(material: Material, shown_s: Floats, annotated: Path, files: _Files) -> None:
    """Write what is drawn once all frames are known, and the page that shows all."""
    kind, figure = files.wanted.picture_format, trial_figure(material)
    picture = picture_bytes(figure, kind)
    files.write(kind, picture)
    for panel, alone in panel_figures(material).items():
        files.write(f"{panel}.{kind}", picture_bytes(alone, kind))
    files.write("strip.jpg", thumbnail_jpeg(material))
    media = PageMedia(
        mp4=annotated.read_bytes(),
        frame=material.track.frame,
        shown_s=shown_s,
        cuts=material.cuts,
        clip_sha256=files.clip,
        picture=data_address(picture, MEDIA_TYPES[kind]),
        panels=time_panels(figure),
    )
    files.write("html", clip_page(material.result, media).encode("utf-8"))

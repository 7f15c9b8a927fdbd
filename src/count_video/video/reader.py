"""Open footage and stream its frames: every picture is read here."""

from __future__ import annotations

import math
from collections.abc import Generator, Iterable, Iterator
from contextlib import closing, suppress
from itertools import chain, groupby, islice
from pathlib import Path

import numpy as np

from count_video.errors import FootageError, UsageError
from count_video.inputs import CAPTURE_RATE
from count_video.records import Floats, FootageInfo, FootageReport, Frame, Indices
from count_video.video.completeness import Promise, promise_of, shortcomings
from count_video.video.decoding import Reading, Tally, reading_of
from count_video.video.opening import MOST_FRAMES, MOST_PIXELS, check_size
from count_video.video.pictures import chroma_of, luma_of
from count_video.video.repeats import LONGEST_RUN, Picture, mark_repeats

UNEVEN_SHARE = 0.5
"""Time stamps are uneven if a step between them differs by this share of the usual one."""
CAPTURE_RATE_TAG = "com.android.capture.fps"
"""States the capture rate. Android's recorders write it; the container's own rate is then the rate
of playing. Apple's high-speed films have no such tag: straight from the camera they play at the
capture rate, but a shared copy is slowed down and does not say so."""


class Footage:
    """A clip that streams; a context manager that ends the stream and releases the file.

    One stream of frames at a time: a new call of :meth:`frames` ends the one before.
    """

    def __init__(self, info: FootageInfo, promise: Promise, opened: Reading) -> None:
        self.info = info
        self._promise = promise
        self._opened: Reading | None = opened
        """The pass that showed the first picture, until the first stream goes on with it."""
        self._tally = Tally()
        self._stream: Generator[Frame, None, None] | None = None
        self._copies: list[bool] = []
        """Whether each frame so far is a copy."""

    def __enter__(self) -> Footage:
        return self

    def __exit__(self, *_: object) -> None:
        for one in (self._stream, self._opened):
            if one is not None:
                one.close()

    def frames(
        self, start: int = 0, end: int | None = None, *, colour: bool = False
    ) -> Iterator[Frame]:
        """Stream frames ``start`` to ``end`` (exclusive), each as soon as the next is decoded.

        Frames before ``start`` are decoded, so that indices are exact, but not yielded. Their
        ``colour`` comes with them only if it is asked for. FootageError if the size of the picture
        changes on the way, or there are too many frames.
        """
        if self._stream is not None:
            self._stream.close()
        self._stream = self._frames(start, end, colour)
        return self._stream

    def report(self) -> FootageReport:
        """Return what became of the file, as far as it was decoded."""
        tally, found = self._tally, list(shortcomings(self._promise, self._tally))
        warnings = [one.sentence for one in found]
        # A long run is a still picture, as it should be while nothing moves.
        runs = (len(list(run)) for copy, run in groupby(self._copies) if copy)
        between = sum(run for run in runs if run <= LONGEST_RUN)
        if between > 2:
            warnings.append(
                f"{between} of {tally.pictures} frames repeat the one before them and are set "
                "aside: an encoder left them as they were, or the clip was converted to a higher "
                "frame rate than it was filmed at"
            )
        return FootageReport(
            frames_decoded=tally.pictures,
            frames_promised=self._promise.frames,
            warnings=tuple(warnings),
            # By what misses most of them.
            frames_missing=round(max([0, *(one.lost for one in found if math.isfinite(one.lost))])),
        )

    def stamped(self, frames: Indices) -> Floats | None:
        """Give time stamps of frames that were decoded, in usual steps; None if these are even.

        The first of n frames, shape (n,), is at its own number.
        """
        times = np.array(self._tally.times_s)[frames]
        steps = np.diff(times) / np.diff(frames)
        if len(steps) == 0 or not (steps > 0).all():
            return None
        usual = float(np.median(steps))
        if np.abs(steps - usual).max() < UNEVEN_SHARE * usual:
            return None
        return np.asarray(frames[0] + (times - times[0]) / usual, np.float64)

    def _frames(self, start: int, end: int | None, colour: bool) -> Generator[Frame, None, None]:
        turns = self.info.rotation_deg // 90
        opened, self._opened = self._opened, None
        # A pass alone holds what it reads: a decoder keeps its pictures until it is forgotten.
        with closing(opened or reading_of(self.info.path)) as reading:
            del opened
            self._tally, self._copies = reading.tally, []
            marked = mark_repeats(self._pictures(reading, end, colour))
            for index, ((luma, chroma), copy) in enumerate(marked):
                self._copies.append(copy)
                if index >= start:
                    upright = None if chroma is None else np.rot90(chroma, turns, axes=(1, 2))
                    yield Frame(index, np.rot90(luma, turns), copy, upright)

    def _pictures(self, reading: Reading, end: int | None, colour: bool) -> Iterator[Picture]:
        """Yield every picture, with ``colour`` if asked for, as long as they keep their size."""
        first = None
        for index, picture in enumerate(islice(reading.pictures, end)):
            luma = luma_of(picture)
            first = first or luma.shape
            if luma.shape != first:
                raise FootageError(
                    f"{self.info.path}: the picture size changes at frame {index} from "
                    f"{first[1]} x {first[0]} to {luma.shape[1]} x {luma.shape[0]} px; "
                    "cut the clip there and count the parts"
                )
            if index >= MOST_FRAMES:
                raise FootageError(
                    f"{self.info.path}: more than {MOST_FRAMES} frames; give a part of the clip "
                    "with start and end"
                )
            yield luma, chroma_of(picture) if colour else None


def open_footage(path: Path, *, capture_fps: float | None = None) -> Footage:
    """Look into a clip and at its first picture; FootageError if the file is no footage.

    ``capture_fps`` are the camera's frames per second of real time, if the user knows them.
    """
    reading = reading_of(path)
    try:
        return Footage(*_described(path, reading, capture_fps), reading)
    except BaseException:
        reading.close()
        raise


def _described(
    path: Path, reading: Reading, capture_fps: float | None
) -> tuple[FootageInfo, Promise]:
    """Say what a clip is by its container and its first picture, and what it promises."""
    first = reading.first()
    if first is None:
        raise FootageError(
            f"{path}: not one picture could be decoded (packets refused: "
            f"{len(reading.tally.refused)}, coded as {reading.stream.codec_context.name}); "
            "the file is damaged or cut, its pictures are too large (more than "
            f"{MOST_PIXELS // 1_000_000} million pixels), or FFmpeg cannot decode their kind, "
            "as animated WebP: copy it again from the camera, or convert it to MP4"
        )
    check_size(path, first.width, first.height)
    promise, rate = promise_of(path, reading), reading.stream.average_rate
    tags = chain(reading.container.metadata.items(), reading.stream.metadata.items())
    stated_fps, turns = stated_rate(tags), round(first.rotation / 90) % 4
    width_px, height_px = (first.width, first.height)[:: -1 if turns % 2 else 1]
    info = FootageInfo(
        path=path,
        width_px=width_px,
        height_px=height_px,
        rotation_deg=90 * turns,
        frames_promised=promise.frames,
        container_fps=float(rate) if rate else None,
        capture_fps=capture_fps or stated_fps,
        capture_fps_source="option" if capture_fps else "metadata" if stated_fps else "unknown",
    )
    return info, promise


def stated_rate(tags: Iterable[tuple[str, str]]) -> float | None:
    """Return the capture rate that tags of a file (name and value) state; None if they do not.

    Case does not matter (Matroska writes names in capitals), and values that no camera has count as
    absent.
    """
    for name, text in tags:
        if name.lower() == CAPTURE_RATE_TAG:
            with suppress(UsageError):
                return CAPTURE_RATE(text.strip())
    return None

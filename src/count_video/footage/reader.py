"""Open footage and stream its frames: every picture is read here."""

from __future__ import annotations

from collections import deque
from collections.abc import Generator, Iterator
from itertools import chain, islice
from pathlib import Path
from types import TracebackType

import av

from count_video.errors import FootageError, UsageError
from count_video.footage.capture_rate import capture_rate, check_capture_rate
from count_video.footage.completeness import Promise, complaints, frames_missing, promise_of
from count_video.footage.decoding import Reading, seconds
from count_video.footage.opening import MOST_FRAMES, MOST_PIXELS, check_size
from count_video.footage.pictures import Luma, luma_of, quarter_turns, upright
from count_video.footage.repeats import LONGEST_RUN, mark_repeats
from count_video.records import FootageInfo, FootageReport, Frame

__all__ = ["Footage", "open_footage"]

REPEATS_WORTH_A_WORD = 3
"""Fewer copies between real frames are set aside without a word."""


class Footage:
    """A clip that streams; a context manager that holds the file open.

    One stream of frames at a time: a new call of :meth:`frames` ends the one before.
    """

    def __init__(self, info: FootageInfo, promise: Promise, reading: Reading) -> None:
        self.info = info
        self._promise = promise
        self._opened: Reading | None = reading
        """For the first pass, which shows the picture that was decoded at once too."""
        self._tally = reading.tally
        self._stream: Generator[Frame, None, None] | None = None
        self._repeats = _RepeatCount()

    def __enter__(self) -> Footage:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """End the stream of frames, if there is one, and release the file."""
        if self._stream is not None:
            self._stream.close()
        if self._opened is not None:
            self._opened.close()

    def frames(self, start: int = 0, end: int | None = None) -> Iterator[Frame]:
        """Stream frames ``start`` to ``end`` (exclusive), each as soon as the next is decoded.

        Frames before ``start`` are decoded, so that indices are exact, but not yielded.

        Raises
        ------
        FootageError
            If the size of the picture changes on the way, or there are too many frames.
        UsageError
            If ``start`` or ``end`` is negative.
        """
        if start < 0 or (end is not None and end < 0):
            raise UsageError(f"frames {start} to {end}: frames count from 0; give no negative one")
        if self._stream is not None:
            self._stream.close()
        # A pass alone holds what it reads: a decoder keeps its pictures until it is forgotten.
        reading, self._opened = self._opened or Reading(self.info.path), None
        self._tally, self._repeats = reading.tally, _RepeatCount()
        self._stream = self._frames(reading, self._repeats, start, end)
        return self._stream

    def report(self) -> FootageReport:
        """Return what became of the file, as far as it was decoded."""
        tally = self._tally
        warnings = [*complaints(self._promise, tally), *self._repeats.complaints(tally.pictures)]
        return FootageReport(
            frames_decoded=tally.pictures,
            frames_promised=self._promise.frames,
            frames_repeated=self._repeats.all,
            decode_errors=tally.errors,
            warnings=tuple(warnings),
            frames_missing=frames_missing(self._promise, tally),
        )

    def _frames(
        self, reading: Reading, repeats: _RepeatCount, start: int, end: int | None
    ) -> Generator[Frame, None, None]:
        turns = self.info.rotation_deg // 90
        # Whether a frame is a copy is known when the next one is there: it waits here till then.
        waiting: deque[tuple[float, Luma]] = deque()
        try:
            copies = mark_repeats(self._lumas(reading, end, waiting))
            for index, copy in enumerate(copies):
                repeats.add(copy)
                time_s, luma = waiting.popleft()
                if index >= start:
                    yield Frame(index, time_s, upright(luma, turns), copy)
        finally:
            reading.close()

    def _lumas(
        self, reading: Reading, end: int | None, waiting: deque[tuple[float, Luma]]
    ) -> Iterator[Luma]:
        """Yield the luma of every picture, as long as these keep their size."""
        first = None
        for index, picture in enumerate(islice(reading, end)):
            luma = luma_of(picture)
            first = luma.shape if first is None else first
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
            waiting.append((seconds(picture.pts, reading.stream.time_base), luma))
            yield luma


class _RepeatCount:
    """Copies among the frames so far."""

    def __init__(self) -> None:
        self.all = 0
        self._between = 0
        self._run = 0

    def add(self, copy: bool) -> None:
        """Count a frame."""
        if copy:
            self.all += 1
            self._run += 1
            return
        self._between, self._run = self._so_far(), 0

    def complaints(self, frames: int) -> Iterator[str]:
        """Yield a sentence if copies come between real frames."""
        if self._so_far() >= REPEATS_WORTH_A_WORD:
            yield (
                f"{self._so_far()} of {frames} frames repeat the one before them and are set "
                "aside: the clip was converted to a higher frame rate than it was filmed at"
            )

    def _so_far(self) -> int:
        # A long run is a still picture, as it should be while nothing moves.
        return self._between + (self._run if self._run <= LONGEST_RUN else 0)


def open_footage(path: Path, *, capture_fps: float | None = None) -> Footage:
    """Open a clip and decode its first picture.

    Parameters
    ----------
    path
        The file.
    capture_fps
        The camera's frames per second of real time, if the user knows them.

    Raises
    ------
    FootageError
        If the file is no footage; the message is one line for the user.
    UsageError
        If no camera has the rate ``capture_fps``.
    """
    check_capture_rate(capture_fps)
    path = Path(path)
    reading = Reading(path)
    try:
        first = reading.first()
        if first is None:
            raise FootageError(
                f"{path}: not one picture could be decoded (packets refused: "
                f"{reading.tally.errors}, coded as {reading.stream.codec_context.name}); the file "
                "is damaged or cut, its pictures are too large (more than "
                f"{MOST_PIXELS // 1_000_000} million pixels), or FFmpeg cannot decode their kind, "
                "as animated WebP: copy it again from the camera, or convert it to MP4"
            )
        check_size(path, first.width, first.height)
        promise = promise_of(path, reading)
        return Footage(_info(path, reading, first, promise, capture_fps), promise, reading)
    except BaseException:
        reading.close()
        raise


def _info(
    path: Path, reading: Reading, first: av.VideoFrame, promise: Promise, option: float | None
) -> FootageInfo:
    turns = quarter_turns(first)
    sides = (first.width, first.height)
    width_px, height_px = sides if turns % 2 == 0 else sides[::-1]
    rate = reading.stream.average_rate
    tags = chain(reading.container.metadata.items(), reading.stream.metadata.items())
    capture_fps, source = capture_rate(option, tags)
    return FootageInfo(
        path=path,
        codec=reading.stream.codec_context.name,
        pixel_format=first.format.name,
        width_px=width_px,
        height_px=height_px,
        rotation_deg=90 * turns,
        frames_promised=promise.frames,
        container_fps=float(rate) if rate else None,
        capture_fps=capture_fps,
        capture_fps_source=source,
    )

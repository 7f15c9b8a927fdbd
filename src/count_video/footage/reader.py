"""Open footage and stream its frames: the door through which every picture comes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import islice
from pathlib import Path
from types import TracebackType

from count_video.errors import FootageError
from count_video.footage.capture_rate import capture_rate
from count_video.footage.decoding import DecodeTally, decode, footage_time_s
from count_video.footage.opening import choose_stream, open_container
from count_video.footage.pictures import luma_of, quarter_turns, upright
from count_video.footage.repeats import repeats
from count_video.records import FootageInfo, FootageReport, Frame


class Footage:
    """A clip that streams; use it as a context manager."""

    def __init__(self, info: FootageInfo) -> None:
        self.info = info
        self._tally = DecodeTally()
        self._decoded = 0
        self._repeated = 0

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
        """Release the file."""

    def frames(self, start: int = 0, end: int | None = None) -> Iterator[Frame]:
        """Yield frames ``start`` to ``end`` (exclusive) as they are decoded."""
        self._tally = tally = DecodeTally()
        self._decoded = self._repeated = 0
        previous = None
        with open_container(self.info.path) as container:
            stream = choose_stream(self.info.path, container)
            stream.thread_type = "AUTO"
            for index, picture in enumerate(islice(decode(container, stream, tally), end)):
                self._decoded = index + 1
                if index < start - 1:
                    continue
                luma = luma_of(picture)
                copy = repeats(luma, previous)
                self._repeated += copy
                previous = luma
                if index >= start:
                    shown = upright(luma, quarter_turns(picture))
                    yield Frame(index, footage_time_s(picture), shown, copy)

    def report(self) -> FootageReport:
        """Return what became of the file so far."""
        return FootageReport(
            self._decoded, self.info.frames_promised, self._repeated, self._tally.errors, ()
        )


def open_footage(path: Path, *, capture_fps: float | None = None) -> Footage:
    """Open a clip and decode its first picture.

    Raises
    ------
    FootageError
        If the file is no footage.
    UsageError
        If ``capture_fps`` is no positive number.
    """
    path = Path(path)
    rate, source = capture_rate(capture_fps, {})
    with open_container(path) as container:
        stream = choose_stream(path, container)
        if capture_fps is None:
            rate, source = capture_rate(None, container.metadata)
        first = next(decode(container, stream, DecodeTally()), None)
        if first is None:
            raise FootageError(f"{path}: no picture can be decoded; the file is damaged")
        turns = quarter_turns(first)
        width, height = (
            (first.width, first.height) if turns % 2 == 0 else (first.height, first.width)
        )
        return Footage(
            FootageInfo(
                path=path,
                codec=stream.codec_context.name,
                pixel_format=first.format.name,
                width_px=width,
                height_px=height,
                rotation_deg=90 * turns,
                frames_promised=stream.frames or None,
                container_fps=float(stream.average_rate) if stream.average_rate else None,
                capture_fps=rate,
                capture_fps_source=source,
            )
        )


def pilot_frames(
    path: Path, *, budget: int, start: int = 0, end: int | None = None
) -> list[list[Frame]]:
    """Return runs of consecutive frames spread over the clip, ``budget`` frames at most."""
    with open_footage(path) as footage:
        stop = start + budget if end is None else min(end, start + budget)
        # The decoder's buffers are given back: these frames outlive the stream.
        return [[replace(frame, luma=frame.luma.copy()) for frame in footage.frames(start, stop)]]

"""Packet by packet from container to pictures; a bad packet costs its picture, not the rest."""

from __future__ import annotations

import math
import os
from collections import deque
from collections.abc import Generator, Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import chain
from pathlib import Path

import av
import av.error
from av.container import InputContainer

from count_video.errors import FootageError, MachineError
from count_video.inputs import THREADS, checked
from count_video.process import check_memory, usable_cores
from count_video.video.opening import choose_stream, open_container, plain_words

JUMP_SHARE = 1.7
"""A step between time stamps so many times the usual one is a jump: a picture was left out."""
THREADS_VARIABLE = "COUNT_VIDEO_THREADS"
"""Environment variable that says how many threads may decode a clip. Processes that share the
cores between them, one clip each, set it to 1."""


@dataclass(frozen=True)
class Jump:
    """A step between time stamps that is longer than usual."""

    step_s: float
    share: float
    """How many times the usual step it is."""
    after: int
    """Index of the picture before it."""


@dataclass
class Tally:
    """What happened while decoding, as it goes."""

    tick_s: Fraction | None = None
    """Unit of the time stamps."""
    pictures: int = 0
    """How many were decoded so far."""
    refused: list[int] = field(default_factory=list)
    """For every packet that the decoder refused, how many pictures had come by then."""
    damaged: list[int] = field(default_factory=list)
    """Indices of the pictures that the decoder gave but calls damaged."""
    jumps: list[Jump] = field(default_factory=list)
    cut_off: bool = False
    """True if the file ends within a packet."""
    broke_off: str | None = None
    """Why reading failed before the end of the file; None if it did not."""
    exhausted: bool = False
    """True once the file was decoded to its end."""
    times_s: list[float] = field(default_factory=list)
    """Footage time of each picture so far; NaN without a time stamp."""
    lasts_s: float = 0.0
    """How long that picture is said to last; 0 if nothing is said."""
    _steps_s: deque[float] = field(default_factory=lambda: deque(maxlen=15))

    @property
    def time_s(self) -> float:
        """Footage time of the last picture so far; NaN without a time stamp."""
        return self.times_s[-1] if self.times_s else math.nan

    @property
    def usual_step_s(self) -> float:
        """Median of the last steps between time stamps; infinite before there are any."""
        return sorted(self._steps_s)[len(self._steps_s) // 2] if self._steps_s else math.inf

    def add(self, picture: av.VideoFrame) -> None:
        """Count a picture and check its time stamp."""
        if picture.is_corrupt:
            self.damaged.append(self.pictures)
        now_s = math.nan if picture.pts is None else self._seconds(picture.pts)
        step_s = now_s - self.time_s
        share = step_s / self.usual_step_s
        if share > JUMP_SHARE:
            self.jumps.append(Jump(step_s, share, self.pictures - 1))
        if step_s > 0:
            self._steps_s.append(step_s)
        self.times_s.append(now_s)
        self.lasts_s = self._seconds(picture.duration or 0)
        self.pictures += 1

    def _seconds(self, ticks: int) -> float:
        if self.tick_s is None:
            return math.nan
        # The quotient of two ints is rounded once, however long they are.
        return ticks * self.tick_s.numerator / self.tick_s.denominator


class Reading:
    """One pass through a file: the open container, its film, the pictures and their tally."""

    def __init__(self, container: InputContainer, stream: av.VideoStream) -> None:
        self.container, self.stream = container, stream
        self.tally = Tally(stream.time_base)
        self._decoding = self._decoded()
        self.pictures: Iterator[av.VideoFrame] = self._decoding
        """In the order of display; what fails is counted. MachineError if the decoder cannot be
        opened for want of threads, MemoryError if there is no memory for a picture."""

    def first(self) -> av.VideoFrame | None:
        """Decode the first picture, which stays the first of all; None if there is none."""
        picture = next(self.pictures, None)
        self.pictures = chain(() if picture is None else [picture], self._decoding)
        return picture

    def close(self) -> None:
        """End the pass and release the file, and the pictures that the decoder keeps."""
        self.pictures = iter(())
        self._decoding.close()
        self.container.close()

    def packets(self) -> Iterator[av.Packet[av.VideoStream]]:
        """Yield what the file holds of the film; empty packets repeat a picture, and are left out.

        At the end of the file PyAV adds an empty packet for every stream, also for those that
        turned up on the way, as in a damaged transport stream, which it does not know: that is an
        IndexError.
        """
        for packet in self.container.demux(self.stream):
            if packet.size > 0:
                yield packet
            elif packet.pts is None and packet.dts is None:
                return

    def _decoded(self) -> Generator[av.VideoFrame, None, None]:
        tally = self.tally
        for packet in self._whole_packets():
            try:
                pictures = self.stream.decode(packet)
            except av.error.FFmpegError as error:
                if isinstance(error, BlockingIOError) and not tally.pictures and not tally.refused:
                    raise MachineError(
                        "the system lets no more threads decode this clip; close other programs, "
                        f"or set {THREADS_VARIABLE}=1"
                    ) from error
                check_memory()
                tally.refused.append(tally.pictures)
                continue
            for picture in pictures:
                tally.add(picture)
                yield picture
        tally.exhausted = True

    def _whole_packets(self) -> Iterator[av.Packet[av.VideoStream] | None]:
        """Yield packets and at last None, upon which a decoder gives its last pictures."""
        waiting = None
        try:
            for packet in self.packets():
                if waiting is not None:
                    yield waiting
                waiting = packet
        except av.error.FFmpegError as error:
            check_memory()
            self.tally.broke_off = plain_words(error)
        if waiting is not None and waiting.is_corrupt:
            # A decoder would paint over the missing part of the packet, or complain when it is
            # asked for its last pictures and keep those to itself.
            self.tally.cut_off = True
        elif waiting is not None:
            yield waiting
        yield None


def reading_of(path: Path) -> Reading:
    """Begin a pass through a file; raises as ``open_container`` and ``choose_stream`` do."""
    cores = usable_cores()
    allowed = checked(THREADS_VARIABLE, os.environ.get(THREADS_VARIABLE, cores), THREADS)
    container = open_container(path)
    try:
        stream = choose_stream(path, container)
    except FootageError:
        container.close()
        raise
    # With threads several large pictures are decoded at once, while the caller uses one. All
    # threads together hold some 50 million pixels at most. Pictures below 2 million pixels are
    # decoded by one thread: handing them over costs up to as much again.
    context = stream.codec_context
    pixels = max(1, context.width * context.height)
    threads = max(1, min(allowed, cores, 50_000_000 // pixels))
    stream.thread_type = "AUTO" if threads > 1 and pixels > 2_000_000 else "NONE"
    context.thread_count = threads
    return Reading(container, stream)

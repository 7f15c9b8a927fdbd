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

from count_video.errors import FootageError, MachineError, UsageError
from count_video.footage.opening import choose_stream, open_container
from count_video.inputs import THREADS
from count_video.process import check_memory

JUMP_SHARE = 1.7
"""A step between time stamps so many times the usual one is a jump: a picture was left out."""
STEPS_KEPT = 15
"""Steps of which the median is the usual one."""
PIXELS_HELD = 50_000_000
"""Threads decode a picture each; together they hold about so many pixels at most."""
PIXELS_FOR_THREADS = 2_000_000
"""Smaller pictures are decoded by one thread: handing them over costs up to as much again."""

THREADS_VARIABLE = "COUNT_VIDEO_THREADS"
"""Environment variable that says how many threads may decode a clip. Processes that share the
cores between them, one clip each, set it to 1."""


def decoder_threads() -> int:
    """Return how many threads may decode at a time: as many as cores, or fewer if so allowed.

    Raises
    ------
    UsageError
        The environment variable is not a whole number above 0.
    """
    cores = os.cpu_count() or 1
    allowed = os.environ.get(THREADS_VARIABLE)
    if allowed is None:
        return cores
    try:
        return min(THREADS(allowed), cores)
    except UsageError as error:
        raise UsageError(f"{THREADS_VARIABLE}: {error}") from error


@dataclass
class Tally:
    """What happened while decoding, counted as it goes."""

    pictures: int = 0
    """Pictures decoded so far."""
    errors: int = 0
    """Packets that the decoder refused."""
    first_error: int | None = None
    """How many pictures had come when the first packet was refused."""
    cut_off: bool = False
    """True if the file ends within a packet."""
    damaged: int = 0
    """Pictures that the decoder gave but calls damaged."""
    first_damaged: int | None = None
    """Index of the first damaged picture."""
    broke_off: str | None = None
    """Why reading failed before the end of the file; None if it did not."""
    time_s: float = math.nan
    """Footage time of the last picture so far; NaN without time stamps."""
    lasts_s: float = 0.0
    """How long that picture is said to last; 0 if nothing is said."""
    jumps: int = 0
    """Steps between time stamps that are longer than usual."""
    widest_jump_s: float = 0.0
    """The longest of them."""
    widest_jump_share: float = 0.0
    """How many times the usual step that one is."""
    widest_jump_after: int = 0
    """Index of the picture before it."""
    exhausted: bool = False
    """True once the file was decoded to its end."""
    tick_s: Fraction | None = None
    """Unit of the time stamps."""
    _steps: deque[float] = field(default_factory=lambda: deque(maxlen=STEPS_KEPT))

    @property
    def usual_step_s(self) -> float:
        """Median of the last steps between time stamps; infinite before there are any."""
        return sorted(self._steps)[len(self._steps) // 2] if self._steps else math.inf

    def refuse(self) -> None:
        """Count a packet that gave no picture."""
        self.errors += 1
        if self.first_error is None:
            self.first_error = self.pictures

    def add(self, picture: av.VideoFrame) -> None:
        """Count a picture and check its time stamp."""
        if picture.is_corrupt:
            self.damaged += 1
            if self.first_damaged is None:
                self.first_damaged = self.pictures
        now_s = seconds(picture.pts, self.tick_s)
        step_s = now_s - self.time_s
        share = step_s / self.usual_step_s
        if share > JUMP_SHARE:
            self.jumps += 1
            if share > self.widest_jump_share:
                self.widest_jump_s, self.widest_jump_share = step_s, share
                self.widest_jump_after = self.pictures - 1
        if step_s > 0:
            self._steps.append(step_s)
        self.time_s = now_s
        self.lasts_s = seconds(picture.duration or 0, self.tick_s)
        self.pictures += 1


class Reading:
    """One pass through a file: the open container, its film, the pictures and their tally."""

    def __init__(self, path: Path, *, threads: bool = True) -> None:
        at_most = decoder_threads()
        self.container = open_container(path)
        try:
            self.stream = choose_stream(path, self.container)
        except FootageError:
            self.container.close()
            raise
        # With threads several large pictures are decoded at once, while the caller uses one.
        context = self.stream.codec_context
        pixels = max(1, context.width * context.height)
        at_most = max(1, min(at_most, PIXELS_HELD // pixels))
        many = threads and at_most > 1 and pixels > PIXELS_FOR_THREADS
        self.stream.thread_type = "AUTO" if many else "NONE"
        context.thread_count = at_most
        self.tally = Tally(tick_s=self.stream.time_base)
        self._rest = decode(self.container, self.stream, self.tally)
        self._first: av.VideoFrame | None = None

    def first(self) -> av.VideoFrame | None:
        """Return the first picture, None if there is none, and keep it for the pass."""
        if self._first is None:
            self._first = next(self._rest, None)
        return self._first

    def __iter__(self) -> Iterator[av.VideoFrame]:
        first, self._first = self._first, None
        return self._rest if first is None else chain([first], self._rest)

    def close(self) -> None:
        """Release the file."""
        self._first = None
        self._rest.close()
        self.container.close()


def decode(
    container: InputContainer, stream: av.VideoStream, tally: Tally
) -> Generator[av.VideoFrame, None, None]:
    """Yield the pictures of a stream in the order of display and count what fails.

    Raises
    ------
    MachineError
        The decoder cannot be opened for want of threads.
    MemoryError
        There is no memory for a picture.
    """
    for packet in _packets(container, stream, tally):
        try:
            pictures = stream.decode(packet)
        except av.error.FFmpegError as error:
            if isinstance(error, BlockingIOError) and not tally.pictures + tally.errors:
                raise _no_threads() from error
            check_memory()
            tally.refuse()
            continue
        for picture in pictures:
            tally.add(picture)
            yield picture
    tally.exhausted = True


def _no_threads() -> MachineError:
    """Make the error of a decoder that could not be opened for want of threads."""
    return MachineError(
        "the system lets no more threads decode this clip; close other programs, or set "
        f"{THREADS_VARIABLE}=1"
    )


def seconds(ticks: int | None, tick_s: Fraction | None) -> float:
    """Return a time stamp in seconds, rounded once; NaN where there is none."""
    if ticks is None or tick_s is None:
        return math.nan
    # The quotient of two ints is rounded once, however long they are.
    return ticks * tick_s.numerator / tick_s.denominator


def packets_of(
    container: InputContainer, stream: av.VideoStream
) -> Iterator[av.Packet[av.VideoStream]]:
    """Yield what a file holds of a stream.

    At the end of the file PyAV adds an empty packet for every stream, also for those that turned up
    on the way, as in a damaged transport stream, which it does not know: that is an IndexError.
    """
    for packet in container.demux(stream):
        if packet.size == 0 and packet.pts is None and packet.dts is None:
            return
        yield packet


def _packets(
    container: InputContainer, stream: av.VideoStream, tally: Tally
) -> Iterator[av.Packet[av.VideoStream] | None]:
    """Yield packets and at last None, upon which a decoder gives its last pictures."""
    packets = packets_of(container, stream)
    waiting = None
    while True:
        try:
            packet = next(packets, None)
        except av.error.FFmpegError as error:
            check_memory()
            tally.broke_off = " ".join((error.strerror or str(error)).split())
            packet = None
        if packet is None or packet.size == 0:
            break
        if waiting is not None:
            yield waiting
        waiting = packet
    if waiting is not None and waiting.is_corrupt:
        # A decoder would paint over the missing part of the packet, or complain when it is asked
        # for its last pictures and keep those to itself.
        tally.cut_off = True
    elif waiting is not None:
        yield waiting
    yield None

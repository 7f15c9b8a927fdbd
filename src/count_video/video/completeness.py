"""Is all there that the file promises? What is missing is said, with numbers."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from contextlib import closing, suppress
from dataclasses import dataclass
from pathlib import Path

import av
import av.error

from count_video.video.decoding import Reading, Tally, reading_of

GAP_SHARE = 5.0
"""Steps so many times the usual one come of no variable rate: phones stay below 4."""


@dataclass(frozen=True)
class Promise:
    """What a container says of the length of its film."""

    frames: int | None
    """Frames, by its own count or by its packets; None if it holds neither."""
    end_s: float = math.nan
    """Footage time at which the film should end; NaN if it does not say or counts its frames."""
    tolerance_s: float = 0.0
    """By so much a whole film may end earlier."""


def promise_of(path: Path, reading: Reading) -> Promise:
    """Ask a container how many frames there should be, and when the last of them should end.

    MP4, MOV and AVI count their frames. Matroska and WebM do not: there the packets are counted,
    which knows of packets that give no picture, and a cut shows in the duration.
    """
    stream = reading.stream
    frames = stream.frames
    if frames and reading.container.format.name.startswith("mov"):
        # An edit list hides frames: some are taken from the index, some are marked in it.
        frames = sum(not entry.is_discard for entry in stream.index_entries)
    if frames:
        return Promise(frames)
    return Promise(_packets_shown(path) or None, *_stated_end_s(reading))


@dataclass(frozen=True)
class Shortcoming:
    """What is missing or damaged, in a sentence."""

    sentence: str
    lost: float = 0
    """How many pictures it costs; NaN or infinite where that cannot be known."""


def shortcomings(promise: Promise, tally: Tally) -> Iterator[Shortcoming]:
    """Yield everything that is missing or damaged."""
    if tally.refused:
        refused = len(tally.refused)
        yield Shortcoming(
            f"{_count(refused, 'packet')} could not be decoded (the first near frame "
            f"{tally.refused[0]}): pictures are missing there",
            refused,
        )
    if tally.cut_off:
        yield Shortcoming("the file ends in the middle of a packet: it was cut")
    if tally.damaged:
        yield Shortcoming(
            f"{_count(len(tally.damaged), 'frame')} decoded with damage (the first is frame "
            f"{tally.damaged[0]}): positions there may be wrong",
        )
    if tally.broke_off:
        read = _count(tally.pictures, "frame")
        yield Shortcoming(f"reading broke off after {read}: {tally.broke_off}")
    if tally.exhausted:
        yield from _shortfalls(promise, tally)


def _shortfalls(promise: Promise, tally: Tally) -> Iterator[Shortcoming]:
    """Yield what a clip that was decoded to its end lacks."""
    if promise.frames is not None and promise.frames != tally.pictures:
        yield Shortcoming(
            f"the container promises {_count(promise.frames, 'frame')}, {tally.pictures} "
            "could be decoded: the file may be cut or damaged; copy it again from the camera",
            promise.frames - tally.pictures,
        )
    # A picture that does not say how long it lasts may last longer than the others.
    end_s = tally.time_s + (tally.lasts_s or 2 * tally.usual_step_s)
    if promise.end_s - end_s > promise.tolerance_s:
        yield Shortcoming(
            f"the container promises {promise.end_s:.2f} s of film, the last frame decoded "
            f"(number {tally.pictures}) ends at {end_s:.2f} s: the file may be cut; copy it "
            "again from the camera",
            (promise.end_s - end_s) / tally.usual_step_s,
        )
    if not tally.jumps:
        return
    widest = max(tally.jumps, key=lambda jump: jump.share)
    # Jumps over lost pictures are wide; or rare, for then the rate is constant.
    if widest.share >= GAP_SHARE or len(tally.jumps) <= max(1.0, 0.02 * tally.pictures):
        yield Shortcoming(
            f"the time stamps jump {_count(len(tally.jumps), 'time')}, most after frame "
            f"{widest.after}, by {widest.step_s:.3f} s "
            f"({widest.share:.1f} times the usual step): pictures may be missing there",
            widest.share - 1,
        )


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def _stated_end_s(reading: Reading) -> tuple[float, float]:
    """Return when the film should end and by how much that may be off, in seconds."""
    container, stream = reading.container, reading.stream
    frame_s = 1 / float(stream.average_rate) if stream.average_rate else 1.0
    tolerance_s = frame_s / 2  # it is rounded, but not by a whole frame
    # Matroska's was written when the file was closed. That of other containers without a count of
    # frames is estimated from what is left of them.
    if container.format.name != "matroska,webm":
        return math.nan, tolerance_s
    clock = r"([0-9]{1,6}):([0-9]{1,2}):([0-9]{1,2}(?:\.[0-9]{1,12})?)"
    if stated := re.fullmatch(clock, stream.metadata.get("DURATION", "")):
        hours, minutes, seconds = stated.groups()
        return 3600 * int(hours) + 60 * int(minutes) + float(seconds), tolerance_s
    if container.duration is None:
        return math.nan, tolerance_s
    if len(container.streams) > 1:  # sound may go on after the last picture
        tolerance_s = max(tolerance_s, 1.0)
    return container.duration / av.time_base, tolerance_s


def _packets_shown(path: Path) -> int:
    """Count the packets that should give a picture."""
    number = 0
    with closing(reading_of(path)) as again:
        # RFC 6386, section 9.1: bit 4 of a frame's first byte says whether VP8 shows it.
        is_vp8 = again.stream.codec_context.name == "vp8"
        with suppress(av.error.FFmpegError):  # counting meets the same error, and reports it
            for packet in again.packets():
                if not packet.is_discard:
                    number += not is_vp8 or bool(bytes(packet)[0] >> 4 & 1)
    return number

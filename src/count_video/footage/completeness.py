"""Is all there that the file promises? What is missing is said, with numbers."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import av
import av.error

from count_video.footage.decoding import Reading, Tally, packets_of
from count_video.footage.opening import choose_stream, open_container

_SOUND_S = 1.0
"""Sound may go on for so long after the last picture of a whole file."""
_ROUNDING_FRAMES = 0.5
"""A stated duration is rounded, but not by a whole frame."""
_UNSAID_FRAMES = 2.0
"""Where the last picture does not say how long it lasts, it may last longer than the others."""
_GAP_SHARE = 5.0
"""Steps so many times the usual one come of no variable rate: phones stay below 4."""
_FEW_JUMPS = 0.02
"""Where longer steps are that rare, the rate is constant and a long step misses a picture."""
_STATES_DURATION = frozenset({"matroska,webm"})
"""Containers without a count of frames whose duration was written when the file was closed; what
others are said to last is estimated from what is left of them."""
_CLOCK = re.compile(r"([0-9]{1,6}):([0-9]{1,2}):([0-9]{1,2}(?:\.[0-9]{1,12})?)")


@dataclass(frozen=True)
class Promise:
    """What a container says of the length of its film."""

    frames: int | None
    """Frames, by its own count or by its packets; None if it holds neither."""
    end_s: float
    """Footage time at which the film should end; NaN if it does not say or counts its frames."""
    tolerance_s: float
    """By so much a whole film may end earlier."""


def promise_of(path: Path, reading: Reading) -> Promise:
    """Ask a container how many frames there should be, and when the last of them should end.

    MP4, MOV and AVI count their frames. Matroska and WebM do not: there the packets are counted,
    which knows of packets that give no picture, and a cut shows in the duration.
    """
    counted = _frames_counted(reading)
    if counted:
        return Promise(counted, math.nan, 0.0)
    end_s, tolerance_s = _stated_end_s(reading)
    return Promise(_packets_shown(path) or None, end_s, tolerance_s)


def complaints(promise: Promise, tally: Tally) -> Iterator[str]:
    """Yield a sentence with numbers for everything that is missing or damaged."""
    if tally.errors:
        yield (
            f"{_count(tally.errors, 'packet')} could not be decoded (the first near frame "
            f"{tally.first_error}): pictures are missing there"
        )
    if tally.cut_off:
        yield "the file ends in the middle of a packet: it was cut"
    if tally.damaged:
        yield (
            f"{_count(tally.damaged, 'frame')} decoded with damage (the first is frame "
            f"{tally.first_damaged}): positions there may be wrong"
        )
    if tally.broke_off:
        yield f"reading broke off after {_count(tally.pictures, 'frame')}: {tally.broke_off}"
    if tally.exhausted:
        yield from _shortfalls(promise, tally)


def frames_missing(promise: Promise, tally: Tally) -> int:
    """Return how many pictures are known to be missing, by what misses most of them."""
    missing = [float(tally.errors)]
    if tally.exhausted:
        missing.append((promise.frames or 0) - tally.pictures)
        if promise.end_s - _end_s(tally) > promise.tolerance_s:
            missing.append((promise.end_s - _end_s(tally)) / tally.usual_step_s)
        if _is_gap(tally):
            missing.append(tally.widest_jump_share - 1)
    return round(max(number for number in missing if math.isfinite(number)))


def _shortfalls(promise: Promise, tally: Tally) -> Iterator[str]:
    """Yield what a clip that was decoded to its end lacks."""
    if promise.frames is not None and promise.frames != tally.pictures:
        yield (
            f"the container promises {_count(promise.frames, 'frame')}, {tally.pictures} could be "
            "decoded: the file may be cut or damaged; copy it again from the camera"
        )
    end_s = _end_s(tally)
    if promise.end_s - end_s > promise.tolerance_s:
        yield (
            f"the container promises {promise.end_s:.2f} s of film, the last frame decoded "
            f"(number {tally.pictures}) ends at {end_s:.2f} s: the file may be cut; copy it again "
            "from the camera"
        )
    if _is_gap(tally):
        yield (
            f"the time stamps jump {_count(tally.jumps, 'time')}, most after frame "
            f"{tally.widest_jump_after}, by {tally.widest_jump_s:.3f} s "
            f"({tally.widest_jump_share:.1f} times the usual step): pictures may be missing there"
        )


def _is_gap(tally: Tally) -> bool:
    """Distinguish jumps over lost pictures from the uneven steps of a variable rate."""
    if tally.widest_jump_share >= _GAP_SHARE:
        return True
    return 0 < tally.jumps <= max(1.0, _FEW_JUMPS * tally.pictures)


def _end_s(tally: Tally) -> float:
    """Return when the last picture ends, at the latest."""
    return tally.time_s + (tally.lasts_s or _UNSAID_FRAMES * tally.usual_step_s)


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def _frames_counted(reading: Reading) -> int:
    """Return the container's own count of the frames that it shows, 0 if it has none."""
    stream = reading.stream
    if stream.frames and reading.container.format.name.startswith("mov"):
        # An edit list hides frames: some are taken from the index, some are marked in it.
        return sum(not entry.is_discard for entry in stream.index_entries)
    return stream.frames


def _stated_end_s(reading: Reading) -> tuple[float, float]:
    """Return when the film should end and by how much that may be off, in seconds."""
    container, stream = reading.container, reading.stream
    frame_s = 1 / float(stream.average_rate) if stream.average_rate else _SOUND_S
    tolerance_s = _ROUNDING_FRAMES * frame_s
    if container.format.name not in _STATES_DURATION:
        return math.nan, tolerance_s
    if clock := _CLOCK.fullmatch(stream.metadata.get("DURATION", "")):
        hours, minutes, seconds = clock.groups()
        return 3600 * int(hours) + 60 * int(minutes) + float(seconds), tolerance_s
    if container.duration is None:
        return math.nan, tolerance_s
    shared = len(container.streams) > 1
    return container.duration / av.time_base, max(tolerance_s, _SOUND_S if shared else 0.0)


def _packets_shown(path: Path) -> int:
    """Count the packets that should give a picture."""
    with open_container(path) as container:
        stream = choose_stream(path, container)
        number = 0
        try:
            for packet in packets_of(container, stream):
                number += packet.size > 0 and not packet.is_discard and not _is_hidden(packet)
        except av.error.FFmpegError:
            pass  # reading to the end meets the same error, and reports it
    return number


def _is_hidden(packet: av.Packet[av.VideoStream]) -> bool:
    """Whether a packet holds a picture for the decoder's eyes only, as VP8 knows them."""
    # RFC 6386, section 9.1: bit 4 of a frame's first byte says whether it is shown.
    return packet.stream.codec_context.name == "vp8" and not bytes(packet)[0] >> 4 & 1

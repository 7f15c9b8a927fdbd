"""Packet by packet from container to pictures; a bad packet costs its picture, not the rest."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction

import av
import av.error
from av.container import InputContainer


@dataclass
class DecodeTally:
    """What happened while decoding, counted as it goes."""

    packets: int = 0
    """Packets with data that the container gave."""
    hidden: int = 0
    """Packets that an edit list keeps from display."""
    errors: int = 0
    """Packets that the decoder refused."""
    damaged: int = 0
    """Pictures that the decoder gave but calls damaged."""
    broke_off: bool = False
    """True when reading failed before the end of the file."""


def decode(
    container: InputContainer, stream: av.VideoStream, tally: DecodeTally
) -> Iterator[av.VideoFrame]:
    """Yield the pictures of a stream in display order and count what fails."""
    for packet in _packets(container, stream, tally):
        try:
            pictures = packet.decode()
        except av.error.FFmpegError:
            tally.errors += 1
            continue
        for picture in pictures:
            tally.damaged += picture.is_corrupt
            yield picture


def _packets(
    container: InputContainer, stream: av.VideoStream, tally: DecodeTally
) -> Iterator[av.Packet[av.VideoStream]]:
    """Yield packets, the last one empty (it makes the decoder give its last pictures)."""
    packets = container.demux(stream)
    while True:
        try:
            packet = next(packets)
        except StopIteration:
            return
        except av.error.FFmpegError:
            tally.broke_off = True
            yield av.Packet()
            return
        tally.packets += packet.size > 0
        tally.hidden += packet.is_discard
        yield packet


def footage_time_s(frame: av.VideoFrame) -> float:
    """Return a picture's time stamp in seconds, rounded once; NaN where it has none."""
    if frame.pts is None or frame.time_base is None:
        return float("nan")
    return float(Fraction(frame.pts) * frame.time_base)

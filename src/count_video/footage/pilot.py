"""A look at a clip before the main pass: short runs of frames, spread from its start to its end.

Decoding can only begin at a key frame, so that is where the runs begin: the packets tell where key
frames are, and the time stamps, put in order, tell which index a decoded picture has.
"""

from __future__ import annotations

from contextlib import closing
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from pathlib import Path

import av
import av.error
import numpy as np

from count_video.errors import UsageError
from count_video.footage.decoding import Reading, Tally, decode, seconds
from count_video.footage.pictures import Luma, luma_of, quarter_turns, upright
from count_video.footage.repeats import mark_repeats
from count_video.records import Frame

RUN_FRAMES = 12
"""Usual length of a run: long enough to see a motion, short enough to see many places."""

Run = list[Frame]
Span = tuple[int, int]
"""First frame and the one to stop before."""


@dataclass(frozen=True)
class _Survey:
    """What the packets tell of a film without decoding it."""

    index: dict[int, int]
    """Frame index of each time stamp."""
    keys: tuple[tuple[int, int], ...]
    """Frame index and time stamp of each key frame, in order."""


def pilot_frames(path: Path, *, budget: int, start: int = 0, end: int | None = None) -> list[Run]:
    """Return runs of consecutive frames spread over a clip.

    Parameters
    ----------
    path
        The clip.
    budget
        Number of frames in all runs together, at most.
    start, end
        Part of the clip to look at, in frames; ``end`` is exclusive.

    Returns
    -------
    list of list of Frame
        Runs in order of time, each with its own pixels (they outlive the file). A clip no longer
        than the budget is one run. Indices are exact as long as every packet gives a picture.

    Raises
    ------
    FootageError
        If the file cannot be read as footage.
    UsageError
        If ``budget`` is not positive.
    """
    if budget < 1:
        raise UsageError(f"a pilot of {budget} frames shows nothing; give at least 1")
    with closing(Reading(path)) as reading:
        survey = _survey(reading)
        if survey is not None:
            last = min(len(survey.index), end if end is not None else len(survey.index))
            spans = _spans(survey, budget, start, last)
            if spans and (runs := _sought(reading, survey, spans)) is not None:
                return runs
    with closing(Reading(path)) as reading:
        last = start + budget if end is None else min(end, start + budget)
        return _in_one_go(reading, start, last)


def _survey(reading: Reading) -> _Survey | None:
    """Read all packets; None if they do not tell the order of the pictures."""
    stamps: list[int] = []
    keys: list[int] = []
    try:
        for packet in reading.container.demux(reading.stream):
            if not packet.size or packet.is_discard:
                continue
            if packet.pts is None:
                return None
            stamps.append(packet.pts)
            if packet.is_keyframe:
                keys.append(packet.pts)
    except av.error.FFmpegError:
        return None
    index = {stamp: place for place, stamp in enumerate(sorted(stamps))}
    if len(index) < len(stamps):
        return None
    return _Survey(index, tuple((index[stamp], stamp) for stamp in sorted(keys)))


def _spans(survey: _Survey, budget: int, start: int, last: int) -> list[Span]:
    """Choose runs that begin at key frames, evenly spread; none where there is no need or way."""
    keys = [place for place, _ in survey.keys if start <= place < last]
    if not keys or last - start <= budget:
        return []
    wanted = np.linspace(start, last, min(len(keys), max(1, budget // RUN_FRAMES)), endpoint=False)
    nearest = np.abs(np.subtract.outer(wanted, keys)).argmin(axis=1)
    firsts = [keys[place] for place in np.unique(nearest)]
    length = budget // len(firsts)
    return [(first, min(first + length, after)) for first, after in pairwise([*firsts, last])]


def _sought(reading: Reading, survey: _Survey, spans: list[Span]) -> list[Run] | None:
    """Decode runs one by one; None if the file cannot be sought or its time stamps mislead."""
    stamps = dict(survey.keys)
    runs = []
    for first, last in spans:
        try:
            reading.container.seek(stamps[first], stream=reading.stream)
        except av.error.FFmpegError:
            return None
        pictures = []
        for picture in decode(reading.container, reading.stream, Tally()):
            place = survey.index.get(picture.pts) if picture.pts is not None else None
            if place is None:
                return None
            if place >= first:
                pictures.append((place, picture))
            if place >= last - 1:
                break
        places = [place for place, _ in pictures]
        if places != list(range(first, last)):
            return None
        runs.append(_run(first, [picture for _, picture in pictures], reading.stream.time_base))
    return runs


def _in_one_go(reading: Reading, start: int, last: int) -> list[Run]:
    pictures = []
    for place, picture in enumerate(reading):
        if place >= start:
            pictures.append(picture)
        if place >= last - 1:
            break
    return [_run(start, pictures, reading.stream.time_base)] if pictures else []


def _run(first: int, pictures: list[av.VideoFrame], tick_s: Fraction | None) -> Run:
    lumas = [luma_of(picture) for picture in pictures]
    return [
        # A copy of the pixels lets go of the decoder's buffers, which hold the colours too.
        Frame(first + place, seconds(picture.pts, tick_s), _own(picture, luma), copy)
        for place, (picture, luma, copy) in enumerate(
            zip(pictures, lumas, mark_repeats(lumas), strict=True)
        )
    ]


def _own(picture: av.VideoFrame, luma: Luma) -> Luma:
    return np.array(upright(luma, quarter_turns(picture)), order="C")

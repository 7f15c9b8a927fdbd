"""A look at a clip before the main pass: short runs of frames, spread from its start to its end.

Decoding can only begin at a key frame, so that is where the runs begin: the packets tell where key
frames are, and the time stamps, put in order, tell which index a decoded picture has.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from dataclasses import dataclass
from fractions import Fraction
from itertools import islice, pairwise
from pathlib import Path

import av
import av.error
import numpy as np

from count_video.errors import UsageError
from count_video.footage.decoding import (
    Reading,
    Tally,
    decode,
    decoder_threads,
    packets_of,
    seconds,
)
from count_video.footage.pictures import Luma, luma_of, quarter_turns, upright
from count_video.footage.repeats import mark_repeats
from count_video.records import Frame

RUN_FRAMES = 12
"""Usual length of a run: long enough to see a motion, short enough to see many places."""
WORKERS_AT_MOST = 4
"""More decoders at once gain little and hold more pictures."""

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


def pilot_frames(
    path: Path,
    *,
    budget: int,
    length: int = RUN_FRAMES,
    start: int = 0,
    end: int | None = None,
    reduced: Callable[[Luma], Luma] = np.copy,
) -> list[Run]:
    """Return runs of consecutive frames spread over a clip.

    Parameters
    ----------
    path
        The clip.
    budget
        Number of frames in all runs together, at most.
    length
        Usual number of frames of a run: where there are key frames enough, runs are no longer.
    start, end
        Part of the clip to look at, in frames; ``end`` is exclusive.
    reduced
        Takes a picture and returns what is kept of it, an array of its own, before the next is
        decoded: so no more is held than that.

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
    spans = [] if survey is None else _spans(survey, (budget, length), start, end)
    if survey is not None and spans:
        runs = _sought(path, survey, spans, reduced)
        if runs is not None:
            return runs
    last = start + budget if end is None else min(end, start + budget)
    return _in_one_go(path, start, last, reduced)


def _survey(reading: Reading) -> _Survey | None:
    """Read all packets; None if they do not tell the order of the pictures."""
    stamps: list[int] = []
    keys: list[int] = []
    try:
        for packet in packets_of(reading.container, reading.stream):
            if not packet.size or packet.is_discard or packet.is_corrupt:
                continue
            if packet.pts is None:
                return None
            stamps.append(packet.pts)
            if packet.is_keyframe:
                keys.append(packet.pts)
    except av.error.FFmpegError:
        return None
    index = {stamp: place for place, stamp in enumerate(sorted(stamps))}
    # Pictures before the first key frame may or may not be decodable: then no index is certain.
    if len(index) < len(stamps) or not keys or index[min(keys)] != 0:
        return None
    return _Survey(index, tuple((index[stamp], stamp) for stamp in sorted(keys)))


def _spans(
    survey: _Survey, budget_and_length: tuple[int, int], start: int, end: int | None
) -> list[Span]:
    """Choose runs that begin at key frames, evenly spread; none where there is no need or way."""
    budget, length = budget_and_length
    last = len(survey.index) if end is None else min(end, len(survey.index))
    keys = [place for place, _ in survey.keys if start <= place < last]
    if not keys or last - start <= budget:
        return []
    wanted = np.linspace(start, last, min(len(keys), max(1, budget // length)), endpoint=False)
    nearest = np.abs(np.subtract.outer(wanted, keys)).argmin(axis=1)
    firsts = [keys[place] for place in np.unique(nearest)]
    rooms = [after - first for first, after in pairwise([*firsts, last])]
    lengths = _share_out(budget, rooms)
    return [(first, first + length) for first, length in zip(firsts, lengths, strict=True)]


def _share_out(budget: int, rooms: list[int]) -> list[int]:
    """Split the budget evenly; what a small room cannot take goes to the larger ones."""
    lengths = [0] * len(rooms)
    takers = sorted(range(len(rooms)), key=rooms.__getitem__)
    for served, taker in enumerate(takers):
        lengths[taker] = min(rooms[taker], budget // (len(takers) - served))
        budget -= lengths[taker]
    return lengths


def _sought(
    path: Path, survey: _Survey, spans: list[Span], reduced: Callable[[Luma], Luma]
) -> list[Run] | None:
    """Decode the runs; None if the file cannot be sought or its time stamps mislead.

    A decoder that works on several pictures at once wastes some at the end of every run. So each
    decoder takes one picture at a time here, and several decoders share the runs.
    """
    workers = min(len(spans), decoder_threads(), WORKERS_AT_MOST)
    shares = [spans[worker::workers] for worker in range(workers)]
    try:
        with ThreadPoolExecutor(workers) as pool:
            found = list(pool.map(lambda share: _runs(path, survey, share, reduced), shares))
    except _MisledError:
        return None
    return sorted((run for runs in found for run in runs if run), key=lambda run: run[0].index)


def _runs(
    path: Path, survey: _Survey, spans: list[Span], reduced: Callable[[Luma], Luma]
) -> list[Run]:
    """Decode some of the runs with a decoder of their own."""
    stamps = dict(survey.keys)
    with closing(Reading(path, threads=False)) as reading:
        runs = []
        for first, last in spans:
            try:
                reading.container.seek(stamps[first], stream=reading.stream)
            except av.error.FFmpegError as error:
                raise _MisledError from error
            pictures = _span(reading, survey, first, last)
            runs.append(_run(first, pictures, reading.stream.time_base, reduced))
        return runs


def _span(reading: Reading, survey: _Survey, first: int, last: int) -> Iterator[av.VideoFrame]:
    """Decode from where the file stands; pictures before ``first`` are passed over."""
    wanted = first
    for picture in decode(reading.container, reading.stream, Tally()):
        place = None if picture.pts is None else survey.index.get(picture.pts)
        if place is None:
            raise _MisledError
        if place > wanted:  # a picture is missing: the run ends before it
            return
        if place == wanted:
            wanted += 1
            yield picture
        if wanted == last:
            return


def _in_one_go(path: Path, start: int, last: int, reduced: Callable[[Luma], Luma]) -> list[Run]:
    with closing(Reading(path)) as reading:
        pictures = islice(reading, start, max(start, last))
        run = _run(start, pictures, reading.stream.time_base, reduced)
        return [run] if run else []


def _run(
    first: int,
    pictures: Iterable[av.VideoFrame],
    tick_s: Fraction | None,
    reduced: Callable[[Luma], Luma],
) -> Run:
    kept: list[tuple[float, Luma]] = []

    def lumas() -> Iterator[Luma]:
        for picture in pictures:
            # Each picture is copied as it comes, which gives its buffers back to the decoder.
            luma = _own(picture)
            kept.append((seconds(picture.pts, tick_s), reduced(luma)))
            yield luma

    copies = list(mark_repeats(lumas()))
    return [
        Frame(first + place, time_s, luma, copy)
        for place, ((time_s, luma), copy) in enumerate(zip(kept, copies, strict=True))
    ]


def _own(picture: av.VideoFrame) -> Luma:
    return np.array(upright(luma_of(picture), quarter_turns(picture)), order="C")


class _MisledError(Exception):
    """The time stamps or the index of a file are not what its packets say."""

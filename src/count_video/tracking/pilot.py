"""The pilot: short runs of frames, spread over the clip, from which the bodies are learnt."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np

from count_video.footage.reader import pilot_frames
from count_video.records import Frame
from count_video.tracking.view import View

PILOT_BYTES = 70_000_000
"""Pictures of the pilot are held in memory; so much may they take."""
PILOT_FRAMES = 180
PILOT_FRAMES_AT_LEAST = 72
"""Twelve of the shorter runs, about as many as of pictures of 1280 x 720 px: fewer would pass over
phases of the motion. Views are hardly wider than 1920 px, so that these take 150 MB."""
SMALL_CLIP_PIXELS = 4e8
SMALL_CLIP_BUDGETS = 2
"""Clips with fewer pixels in all frames together are decoded whole for the pilot; so are those
of which the pilot holds every second frame or more, for they may have but one key frame."""
SLOW_STRIDE = 4
"""Where nothing is found, the runs are made so many times as long."""
UNKNOWN_LENGTH_FRAMES = 2000
"""Taken for the length of a clip that does not tell it."""
RUN_FRAMES = 12
SHORT_RUN_FRAMES = 6
SHORT_BUDGET = 100
"""Runs are cut to about this length; to the shorter one where the pilot may hold fewer pictures
than this, so that they still show many places."""


def pilots(view: View) -> Iterator[list[list[Frame]]]:
    """Yield runs of frames spread over the clip; should they not do, runs chosen otherwise.

    A small clip is decoded for it from end to end, which costs little and shows every phase; of a
    large one at first only what follows its key frames. Bodies may show up far from any of them, or
    creep. Copies of pictures are left out.
    """
    promised = view.footage.info.frames_promised
    few = max(SMALL_CLIP_PIXELS / _picture_pixels(view), SMALL_CLIP_BUDGETS * _budget(view.pixels))
    if promised is None or promised >= few:
        yield _behind_key_frames(view)
    yield _evenly(view, 1)
    yield _evenly(view, SLOW_STRIDE)


def _behind_key_frames(view: View) -> list[list[Frame]]:
    budget = _budget(view.pixels)
    runs = pilot_frames(
        view.footage.info.path,
        budget=budget,
        length=_run_frames(budget),
        start=view.start,
        end=view.end,
        reduced=lambda luma: view.of_luma(luma).copy(),
    )
    fresh = [[frame for frame in run if not frame.repeats_previous] for run in runs]
    return [piece for run in fresh for piece in _pieces(run)]


def _picture_pixels(view: View) -> int:
    return view.footage.info.width_px * view.footage.info.height_px


def _budget(pixels: int) -> int:
    """How many pictures of so many pixels the pilot may hold."""
    return int(np.clip(PILOT_BYTES // pixels, PILOT_FRAMES_AT_LEAST, PILOT_FRAMES))


def _run_frames(budget: int) -> int:
    return RUN_FRAMES if budget >= SHORT_BUDGET else SHORT_RUN_FRAMES


def _evenly(view: View, stride: int) -> list[list[Frame]]:
    """Keep runs of every ``stride``-th frame, evenly spaced, of a clip that is decoded whole."""
    promised = view.footage.info.frames_promised or UNKNOWN_LENGTH_FRAMES
    last = promised if view.end is None else min(view.end, promised)
    budget = _budget(view.pixels)
    span = _run_frames(budget) * stride
    spacing = max(span, -(-(last - view.start) // (budget // _run_frames(budget))))
    runs: dict[int, list[Frame]] = {}
    held = 0
    for frame in view.frames():
        number, place = divmod(frame.index - view.start, spacing)
        wanted = place < span and place % stride == 0 and not frame.repeats_previous
        if wanted and held < budget:
            runs.setdefault(number, []).append(replace(frame, luma=frame.luma.copy()))
            held += 1
    return list(runs.values())


def _pieces(run: list[Frame]) -> list[list[Frame]]:
    """Split a long run: within a piece, the bodies are to move evenly."""
    count = max(1, round(len(run) / RUN_FRAMES))
    edges = [round(part * len(run) / count) for part in range(count + 1)]
    return [run[a:b] for a, b in pairwise(edges) if b > a]

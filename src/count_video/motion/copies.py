"""Copies that were put into a clip: its pictures were taken evenly, its frames not.

A clip of 25 pictures a second that is shown at 30 holds a copy after every fifth picture::

    picture   0 1 2 3 4 . 5 6 7 8 9 .      filmed at even times
    frame     0 1 2 3 4 5 6 7 8 9 10 11

By the frames' numbers a body would stand still during each copy and all collisions would lie up to
a picture off. Where a camera lost a picture and repeated the one before, it is the other way round:
the frames are even, and the body moves two steps in one. The bodies' own paths show which it is.

Where every picture comes twice, the camera's exposure and the shortest interval that it resolves
span two frames. The search for collisions therefore counts in pictures, and what it finds is given
in frames.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from count_video.motion.time_base import TimeBase
from count_video.records import BodyTrack, Track
from count_video.signals import sigma_of

STEPS_AT_LEAST = 6
"""Changes of the step between frames, while a body moves, that a judgement takes."""
MOVES_SIGMAS = 8.0
"""A body moves if it covers so many times the noise from picture to picture; errors that last do
not matter for a step."""
KEEP_TIME = 0.9
"""Share of the noticed copies that come in step."""
SMOOTHER = 0.5
"""Pictures are taken for even if the paths are so much smoother for it."""


def with_copies(track: Track) -> TimeBase | None:
    """Find copies that were put between evenly taken pictures; None where the frames are even.

    Both times are tried on the bodies' steps wherever the step between frames changes.
    """
    rows = ~_missed_copies(track)
    frame = track.frame[rows]
    steps = np.diff(frame)
    if len(steps) < 2 or np.ptp(steps) == 0:
        return None
    step = float(steps.mean())
    by_frame, by_picture = [], []
    for body in _bodies(track):
        moved = np.diff(body.position_px[rows])
        least = MOVES_SIGMAS * sigma_of(body.position_px[rows])
        lesser = np.minimum(np.abs(moved[1:]), np.abs(moved[:-1]))
        decisive = (np.diff(steps) != 0) & (lesser > least)
        by_frame.append(np.abs(np.diff(step * moved / steps))[decisive])
        by_picture.append(np.abs(np.diff(moved))[decisive])
    rough, smooth = np.concatenate(by_frame), np.concatenate(by_picture)
    if len(rough) < STEPS_AT_LEAST or np.median(smooth) > SMOOTHER * np.median(rough):
        return None
    until = np.append(frame[1:] - 1.0, frame[-1])
    return TimeBase(frame, frame[0] + step * np.arange(len(frame)), until, rows)


def _missed_copies(track: Track) -> NDArray[np.bool_]:
    """Which rows are copies that were not noticed, shape (rows,).

    A converter's copies keep time. Where nearly all that were noticed do, a frame that is due to be
    a copy is one if no body moved: at a clip's start little is known yet that would show them.
    """
    none = np.zeros(len(track.frame), dtype=bool)
    if len(track.frame) == 0:
        return none
    first, last = int(track.frame[0]), int(track.frame[-1])
    copies = np.setdiff1d(np.arange(first, last + 1), track.frame.astype(int))
    if len(copies) < STEPS_AT_LEAST:
        return none
    apart, often = np.unique(np.diff(copies), return_counts=True)
    period = int(apart[np.argmax(often)])
    phases = np.bincount(copies % period, minlength=period)
    if period < 2 or phases.max() < KEEP_TIME * len(copies):
        return none
    due: NDArray[np.bool_] = track.frame.astype(int) % period == int(np.argmax(phases))
    for body in _bodies(track):
        moved = np.abs(np.diff(body.position_px, prepend=np.nan))
        due &= ~(moved > MOVES_SIGMAS * sigma_of(body.position_px))
    return due


def _bodies(track: Track) -> list[BodyTrack]:
    return [track.ball] if track.heavy is None else [track.ball, track.heavy]

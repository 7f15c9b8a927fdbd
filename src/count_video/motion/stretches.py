r"""The stretch of a track of two bodies that shows one trial as it was filmed.

Edited clips show a trial twice, or its climax first, and hold or fade their first and last picture.
Where much of the picture changes it shows that by itself (see ``tracking.shots``). Where a camera
stands still, and only small bodies move, their motion does::

    heavy body                     _____          a still picture: it stops at once, away from the
         .           '-.         .'               ball, which stands as well, and nothing is there
          '-.    _____ '-.     .'                 that stops it
             '-.'      ^  '-.-'
                      a cut: it jumps, and its speeds before and after do not take it so far
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np

from count_video.motion.gaps import gaps_of
from count_video.motion.time_base import at_rows
from count_video.motion.time_hypotheses import CLEAR_SIGMAS, STILL_SHARE
from count_video.records import Floats, Track

# ---- cuts ----------------------------------------------------------------------------------------

SIDE_ROWS = 8
"""So many steps on either side give the speed."""
FRAMES_LEFT_OUT = 1
"""So many frames may be left out without a trace; more may, too (see ``skips``)."""
JUMP_SHARE = 0.02
"""A template slips by less than this share of the ball's diameter."""


def longest_shot(track: Track) -> Track:
    """Keep the rows between two cuts, or a cut and an end, that are most."""
    ends = [0, *_cuts(track), len(track.frame)]
    first, end = max(pairwise(ends), key=lambda part: part[1] - part[0])
    return _rows_of(track, first, end)


def _cuts(track: Track) -> list[int]:
    """Rows of the first pictures after what may be cuts.

    There the heavy body jumps farther than its speed before or after takes it, and not as far as
    the ball, as they do where the camera is knocked.
    """
    heavy, ball = (body.position_px for body in track.bodies[::-1])
    rows = np.flatnonzero(np.isfinite(heavy) & np.isfinite(ball))
    if len(rows) < 2:
        return []
    heavy, ball = heavy[rows], ball[rows]
    passed = np.diff((track.frame if track.stamped is None else track.stamped)[rows])
    steps, moved = np.diff(heavy), np.diff(ball)
    velocity = steps / passed
    sigma_px = max(float(np.nanmedian(body.sigma_px)) for body in track.bodies)
    least_px = max(CLEAR_SIGMAS * sigma_px, JUMP_SHARE * track.ball_diameter_px)
    jumps = (np.abs(steps) > least_px) & (np.abs(steps - moved) > least_px)
    cuts = []
    for k in np.flatnonzero(jumps).tolist():
        sides = velocity[max(0, k - SIDE_ROWS) : k], velocity[k + 1 : k + 1 + SIDE_ROWS]
        speeds = [np.sign(steps[k]) * float(np.median(side)) for side in sides if len(side)]
        fastest = max([0.0, *speeds])
        if abs(steps[k]) > (passed[k] + FRAMES_LEFT_OUT) * fastest + least_px:
            cuts.append(int(rows[k + 1]))
    return cuts


# ---- still pictures ------------------------------------------------------------------------------

STILL_ROWS = 3
"""A still picture stays for so many rows at the least: who holds one wants it to be seen."""
STANDING_SHARE = 0.9
"""In this share of the rows of a still picture the bodies stand: as it fades they are misplaced."""
GOES_ON = 2.0
"""A body that is let go moves three times as far in the second step as in the first; one that a
still picture stops keeps its speed, to this factor, up to it."""


def without_still(track: Track) -> Track:
    """Leave out still pictures with which a track begins or ends."""
    rows = len(track.frame)
    places = np.array([body.position_px for body in track.bodies])
    if not np.isfinite(places).all(axis=0).any():
        return track
    clear = CLEAR_SIGMAS * np.array([[np.nanmedian(body.sigma_px)] for body in track.bodies])
    gap = gaps_of(track).closing("bodies")
    end = _rows_before_still(places, clear, gap)
    start = rows - _rows_before_still(places[:, ::-1], clear, gap[::-1])
    return _rows_of(track, start, end)


def _rows_before_still(places: Floats, clear: Floats, gap: Floats) -> int:
    """Count rows of places, shape (bodies, rows), up to a still picture; all if none follows.

    Steps of more than ``clear``, shape (bodies, 1), are none of noise.
    """
    steps = np.abs(np.diff(places))
    moved = np.flatnonzero((steps > clear).any(axis=0))
    last = int(moved[-1]) + 1 if len(moved) else 0
    if last < 2 or not gap[last] > abs(gap[last] - gap[last - 1]):
        return len(gap)
    step, before = np.nanmax(steps[:, last - 2 : last], axis=0)[::-1]
    after = np.abs(places[:, last + 1 :] - places[:, last, None])
    seen = after[:, np.isfinite(after).all(axis=0)]
    stands = seen.shape[1] >= STILL_ROWS and np.quantile(seen, STANDING_SHARE) <= STILL_SHARE * step
    goes_on = step <= GOES_ON * before and before <= GOES_ON * step
    return last + 1 if stands and goes_on else len(gap)


def _rows_of(track: Track, start: int, end: int) -> Track:
    """Keep the rows from ``start`` to before ``end``; the same track if these are all."""
    if end - start == len(track.frame):
        return track
    first, last = track.frame[start], track.frame[end - 1]
    lost = tuple(one for one in track.lost_beyond if first < one < last)
    kept = (track.frame >= first) & (track.frame <= last)
    return at_rows(replace(track, lost_beyond=lost), kept)

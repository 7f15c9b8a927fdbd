r"""Hypotheses about the times of a clip's pictures, which the bodies' own paths show.

Frames are usually even. Two hypotheses say otherwise:

*Copies.* A clip of 25 pictures a second that is shown at 30 holds a copy after every fifth::

    picture   0 1 2 3 4 . 5 6 7 8 9 .      filmed at even times
    frame     0 1 2 3 4 5 6 7 8 9 10 11

By the frames' numbers a body would stand still during each. Where a camera lost a picture and
repeated the one before, it is the other way round: the frames are even, and the body moves two
steps in one.

*Time stamps.* A phone in poor light takes fewer pictures, and its time stamps say when; those of a
file that was slowed down or converted may say nothing.

*Changes of the rate* by a whole factor, as slow-motion exports leave pictures out in parts of a
clip: where the energy of both bodies together jumps, as no collision lets it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from count_video.motion.gaps import Gaps, gaps_of
from count_video.motion.time_base import Ramp, TimeBase, at_rows, even
from count_video.reasons import Cause, Reason
from count_video.records import Collision, Floats, Track
from count_video.signals import sigma_of

CLEAR_SIGMAS = 8.0
"""Steps of places and of speeds are clear from so many standard uncertainties: of all steps of a
thousand clips none is so large by noise, also by noise that lasts for some frames."""
TRIED = 3
"""So many changes of the rate of each sort are tried, the greatest first."""

# ---- copies --------------------------------------------------------------------------------------

CHANGES_AT_LEAST = 2
"""Changes of the step between frames, while a body moves, that a judgement takes: before a copy and
after it. Each is clear by itself."""
COPIES_AT_LEAST = 6
"""So many copies show when they come."""
KEEP_TIME = 0.9
"""Share of the noticed copies that come in step."""
STILL_SHARE = 0.25
"""A body stands still in a copy but for this share of its steps, as encoders change copies."""
SMOOTHER, STEP_CHANGES = 0.5, 0.25
"""Other times than the frames' numbers stand if the paths are so much smoother by them, wherever
one step changes against the other by this share."""


def usual_times(track: Track) -> TimeBase:
    """Time the pictures by copies between them or by their time stamps, or else evenly."""
    return with_copies(track) or with_stamps(track) or even(track.frame)


def with_stamps(track: Track) -> TimeBase | None:
    """Take pictures at their time stamps; None where these are even, or explain no more."""
    if track.stamped is None or not _is_smoother(track, track.stamped):
        return None
    notes = (Reason(Cause.UNEVEN_STAMPS),)
    return replace(even(track.frame), time=track.stamped, keeps_rate=False, notes=notes)


def with_copies(track: Track) -> TimeBase | None:
    """Find copies that were put between evenly taken pictures; None where the frames are even."""
    rows = ~_missed_copies(track)
    frame = track.frame[rows]
    steps = np.diff(frame)
    if len(steps) < 2 or np.ptp(steps) == 0:
        return None
    time = frame[0] + float(steps.mean()) * np.arange(len(frame))
    if not _is_smoother(at_rows(track, rows), time):
        return None
    return TimeBase(frame, time, np.append(frame[1:] - 1.0, frame[-1]), rows)


def _is_smoother(track: Track, time: Floats) -> bool:
    """Whether bodies move much more steadily by other times than by the frames' numbers.

    Both are tried on the bodies' steps wherever one step changes against the other.
    """
    steps, others = np.diff(track.frame), np.diff(time)
    changes = np.abs(np.diff(steps / others)) > STEP_CHANGES
    by_frame, by_time = [], []
    for place in (body.position_px for body in track.bodies):
        moved = np.diff(place)
        lesser = np.minimum(np.abs(moved[1:]), np.abs(moved[:-1]))
        decisive = changes & (lesser > CLEAR_SIGMAS * sigma_of(place))
        by_frame.append(np.abs(np.diff(moved / steps))[decisive])
        by_time.append(np.abs(np.diff(moved / others))[decisive])
    rough, smooth = np.concatenate(by_frame), np.concatenate(by_time)
    # A collision is rough by both times: of the means it takes as much.
    return len(rough) >= CHANGES_AT_LEAST and bool(smooth.mean() <= SMOOTHER * rough.mean())


def _missed_copies(track: Track) -> NDArray[np.bool_]:
    """Which rows are copies that were not noticed, shape (rows,).

    A converter's copies keep time. Those that were noticed, and frames in which a body stands still
    on its way, say when they come. Where nearly all of them do, a frame that is due to be a copy is
    one if no body moved.
    """
    frame, none = track.frame.astype(int), np.zeros(len(track.frame), dtype=bool)
    copies = np.setdiff1d(np.arange(frame.min(initial=0), frame.max(initial=0)), frame)
    copies = copies[copies > frame.min(initial=0)]
    copies = np.union1d(copies, frame[_stands_still(track)])
    if len(copies) < COPIES_AT_LEAST:
        return none
    period = int(np.bincount(np.diff(copies)).argmax())
    phases = np.bincount(copies % period, minlength=period)
    if period < 2 or phases.max() < KEEP_TIME * len(copies):
        return none
    due: NDArray[np.bool_] = frame % period == phases.argmax()
    for place in (body.position_px for body in track.bodies):
        due &= ~(np.abs(np.diff(place, prepend=np.nan)) > CLEAR_SIGMAS * sigma_of(place))
    return due


def _stands_still(track: Track) -> NDArray[np.intp]:
    """Rows in which a body is where it was, but moves clearly the same way before and after."""
    still = np.zeros(len(track.frame), dtype=bool)
    for body in (one for one in track.bodies if np.isfinite(one.sigma_px).any()):
        before, here, after = (np.diff(body.position_px)[n : n - 2 or None] for n in range(3))
        way = np.minimum(before * np.sign(after), np.abs(after))
        clear = way > CLEAR_SIGMAS * np.nanmedian(body.sigma_px)
        still[2:-1] |= clear & (np.abs(here) < STILL_SHARE * way)
    return np.flatnonzero(still)


# ---- changes of the rate -------------------------------------------------------------------------

SIDE_STEPS = 4
"""So many steps on either side give the energy: farther away the threads have changed it."""
FACTOR_AT_LEAST, FACTOR_AT_MOST = 1.4, 16
"""Exports play at half the rate or less; smaller changes are left to the bodies."""
STANDS_OUT = 2.0
"""A speed changes by so much more than it goes on changing by itself: threads speed bodies up and
slow them down from step to step."""
FACTOR_SHARE = 0.3
"""Few pictures give a factor to about this share."""


def rate_changes(gaps: Gaps, collisions: Sequence[Collision]) -> list[tuple[float, float]]:
    """Find places at which the rate may change, in order of time.

    Of each its frame coordinate, and the time from picture to picture after it over that before.
    The mean velocity of the heavy body and the median speed of the ball over some steps, of which a
    collision spoils one, give the energy; ``collisions`` give the ratio of the masses.
    """
    frame, weight = gaps.frame, np.sqrt(_mass_share(collisions))
    if len(frame) <= 4 * SIDE_STEPS + 1:
        return []
    ball, heavy = (
        np.diff(np.interp(frame, frame[seen], signal[seen])) / np.diff(frame)
        for signal in (gaps.ball_px, gaps.heavy_px)
        for seen in [np.isfinite(signal)]
    )
    sides = sliding_window_view(np.stack([heavy, np.abs(ball)]), SIDE_STEPS, axis=1)
    speed = np.hypot(sides[0].mean(axis=-1), weight * np.median(sides[1], axis=-1))
    noise = np.hypot(sigma_of(gaps.heavy_px), weight * sigma_of(gaps.ball_px))
    far = SIDE_STEPS + 1
    before, after = speed[:-far], speed[far:]
    jump = np.log(np.maximum(after, 1e-9) / np.maximum(before, 1e-9))
    bend = np.pad(np.abs(jump), far, mode="edge")
    by_itself = np.maximum(bend[: -2 * far], bend[2 * far :])
    clear = np.abs(jump) > np.maximum(np.log(FACTOR_AT_LEAST), STANDS_OUT * by_itself)
    clear &= np.abs(after - before) > CLEAR_SIGMAS * noise / SIDE_STEPS
    size = np.where(clear, np.abs(jump), 0.0)
    return [
        (float(frame[place + SIDE_STEPS : place + far + 1].mean()), float(np.exp(jump[place])))
        for place in np.flatnonzero(size)
        if size[place] == size[max(0, place - SIDE_STEPS) : place + far].max()
    ]


def _mass_share(collisions: Sequence[Collision]) -> float:
    """Light mass over heavy mass, from what the bodies give each other; 0 where none is shown."""
    shares = []
    for one in collisions:
        gained = one.velocity_after.ball_px_frame - one.velocity_before.ball_px_frame
        given = one.velocity_before.heavy_px_frame - one.velocity_after.heavy_px_frame
        if one.kind == "bodies" and np.isfinite([given, gained]).all() and gained:
            shares.append(given / gained)
    return float(np.clip(np.median(shares), 0.0, 1.0)) if shares else 0.0


def ramps_of(track: Track, collisions: Sequence[Collision]) -> Iterator[tuple[Ramp, float]]:
    """Yield changes of the rate that the clip may have, each with the factor that the speeds show.

    The rate rises where collisions are close and falls again later, by the same factor; or the clip
    shows one of both changes. Exports leave out pictures, so the factor is a whole number.
    """
    changes = rate_changes(gaps_of(track), collisions)
    changes.sort(key=lambda change: -abs(np.log(change[1])))
    rises = [change for change in changes if change[1] < 1][:TRIED]
    falls = [change for change in changes if change[1] > 1][:TRIED]
    both = [(rise, fall) for rise in rises for fall in falls if rise < fall]
    for some in (*both, *((change,) for change in (*rises, *falls))):
        sizes = np.abs(np.log([change[1] for change in some]))
        shown = float(np.exp(sizes.mean()))
        if np.ptp(sizes) < 2 * np.log1p(FACTOR_SHARE) and shown < FACTOR_AT_MOST:
            at = tuple(change[0] for change in some)
            yield Ramp(at, some[0][1] < 1, max(2, round(shown))), shown

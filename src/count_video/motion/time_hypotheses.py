r"""Hypotheses about the times of a clip's pictures, which the bodies' own paths show.

Frames are usually even. Three hypotheses say otherwise:

*Copies.* A clip of 25 pictures a second that is shown at 30 holds a copy after every fifth::

    picture   0 1 2 3 4 . 5 6 7 8 9 .      filmed at even times
    frame     0 1 2 3 4 5 6 7 8 9 10 11

By the frames' numbers a body would stand still during each. Where a camera lost a picture and
repeated the one before, it is the other way round: the frames are even, and the body moves two
steps in one.

*Frames left out* without a trace in the time stamps::

    place            .'
                   .'        after so many frames left out a body goes on from
                             where it would have been by then: its place steps,
             .'              its velocity does not
           .'
          ----------+------> frame

No collision makes a place step. Two lines with one slope v are fitted to the places before and
after each picture; the step s between them, over its uncertainty, is clear or not, and s / v is the
number of frames. The heavy body shows it best, as it turns round but once; the ball may have
collided in what is left out. Where collisions are close no flight is long enough for a line: there
the fit of the whole burst seeks them (see ``skips``).

*Changes of the rate* by a whole factor, as slow-motion exports leave pictures out in parts of a
clip. All speeds change at once. No collision does that: the energy of both bodies together is the
same after it, but for what each restitution takes. So changes of its root are the places in
question.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from count_video.motion.errors_of_places import HALF_EXPOSURE
from count_video.motion.gaps import Gaps, gaps_of
from count_video.motion.linear import least_squares
from count_video.motion.priors import LEFT_OUT
from count_video.motion.time_base import LeftOut, Ramp, TimeBase
from count_video.records import Collision, Floats, Track
from count_video.signals import sigma_of

CLEAR_SIGMAS = 8.0
"""Steps of places and of speeds are clear from so many standard uncertainties: of all steps of a
thousand clips none is so large by noise, also by noise that lasts for some frames."""
TRIED = 3
"""So many changes of the rate of each sort are tried, the greatest first, and so many ramps are
fitted closely, those by which the heavy body strays least."""

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
    for place in (body.position_px for body in track.bodies):
        moved = np.diff(place[rows])
        lesser = np.minimum(np.abs(moved[1:]), np.abs(moved[:-1]))
        decisive = (np.diff(steps) != 0) & (lesser > CLEAR_SIGMAS * sigma_of(place[rows]))
        by_frame.append(np.abs(np.diff(step * moved / steps))[decisive])
        by_picture.append(np.abs(np.diff(moved))[decisive])
    rough, smooth = np.concatenate(by_frame), np.concatenate(by_picture)
    # A collision is rough by both times: of the means it takes as much.
    if len(rough) < CHANGES_AT_LEAST or smooth.mean() > SMOOTHER * rough.mean():
        return None
    until = np.append(frame[1:] - 1.0, frame[-1])
    return TimeBase(frame, frame[0] + step * np.arange(len(frame)), until, rows)


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
    for body in track.bodies:
        before, here, after = (np.diff(body.position_px)[n : n - 2 or None] for n in range(3))
        way = np.minimum(before * np.sign(after), np.abs(after))
        clear = way > CLEAR_SIGMAS * np.nanmedian(body.sigma_px)
        still[2:-1] |= clear & (np.abs(here) < STILL_SHARE * way)
    return np.flatnonzero(still)


# ---- frames left out -----------------------------------------------------------------------------

SIDE_FRAMES = 8
"""So many frames on either side show a step; threads and slopes hardly bend a path in them."""
SIDE_ROWS = 3
FRAMES_AT_LEAST, FRAMES_AT_MOST = 0.75, 500
"""What moves a body by less than this part of a frame's way is an uneven time base, no frame."""
FRAMES_TO = 0.02
"""Their number is sought to this part of one, before it is rounded: lines are not quite paths."""


def left_out(track: Track, collisions: Sequence[Collision], burst: int) -> LeftOut | None:
    """Find the clearest place where frames of the burst are left out; None if there is none.

    Parameters
    ----------
    track
        Both bodies by the times that are in question.
    collisions
        What it shows by them.
    burst
        How many of these belong to the burst; what is left out beyond them may hold more of it.
    """
    if burst == 0:
        return None
    gaps, bodies = gaps_of(track), []
    end = min((one.frame for one in collisions[burst:]), default=np.inf)
    for signal, kinds in ((gaps.ball_px, ("bodies", "wall")), (gaps.heavy_px, ("bodies",))):
        struck = [one.frame for one in collisions[:burst] if one.kind in kinds]
        flights = np.array([-np.inf, *struck, end])
        bodies.append(_steps(gaps.frame, signal, flights, collisions[0].frame))
    clear = [step for body in bodies for step in body.clear]
    if not clear:
        return None
    _, row = max(clear)
    shown = [body.at(row) for body in bodies if row in body.row]
    worth = np.arange(FRAMES_AT_LEAST, FRAMES_AT_MOST, FRAMES_TO)
    strays = np.sum([one.beyond(worth) for one in shown], axis=0)
    frames = float(worth[np.argmin(strays)])
    if frames == worth[-1] or _is_misplaced(shown, float(strays.min())):
        return None
    return LeftOut(float(gaps.frame[row]), round(frames))


@dataclass(frozen=True)
class _Steps:
    """Two lines of one slope, fitted to places of a body before and after each of m pictures."""

    row: NDArray[np.intp]
    """Rows of these pictures, shape (m,)."""
    lines: Floats
    """Place after it by the line before, and by that after; the slope; px and frames, (m, 3)."""
    covariance: Floats
    """Shape (m, 3, 3)."""

    @property
    def step_px(self) -> Floats:
        """By how much the places step, shape (m,)."""
        return np.asarray(self.lines[:, 1] - self.lines[:, 0])

    def variance(self, frames: Floats | float) -> Floats:
        """Variance of what steps are beyond the way of so many frames, in px squared."""
        weight = np.stack(np.broadcast_arrays(-1.0, 1.0, -np.asarray(frames)), axis=-1)
        return np.asarray(np.einsum("...i,...ij,...j->...", weight, self.covariance, weight))

    def beyond(self, frames: Floats | float) -> Floats:
        """Squares of what steps are beyond the way of so many frames, over their variance."""
        return (self.step_px - frames * self.lines[:, 2]) ** 2 / self.variance(frames)

    @property
    def clear(self) -> list[tuple[float, int]]:
        """Those that are clear, and of a frame or more: squares over variance, and row of each."""
        squares, rate = self.beyond(0.0), self.lines[:, 2]
        forward = self.step_px * rate > FRAMES_AT_LEAST * rate**2
        chosen = (squares > CLEAR_SIGMAS**2) & forward
        return list(zip(squares[chosen].tolist(), self.row[chosen].tolist(), strict=True))

    def at(self, row: int) -> _Steps:
        """Take that after the picture of a row."""
        chosen = self.row == row
        return _Steps(self.row[chosen], self.lines[chosen], self.covariance[chosen])


def _steps(frame: Floats, signal: Floats, struck: Floats, begin: float) -> _Steps:
    """Fit the places of a body about each picture between the contacts at which it is struck."""
    rows = np.flatnonzero((frame[:-1] > begin) & (frame[1:] < struck[-1]))
    number = np.searchsorted(struck[:-1], frame[rows], side="right")
    rows, number = (each[struck[number] > frame[rows + 1]] for each in (rows, number))
    near = rows[:, None] + np.arange(1 - SIDE_FRAMES, SIDE_FRAMES + 1)
    inside = (near >= 0) & (near < len(frame))
    near = near.clip(0, len(frame) - 1)
    flight = struck[number - 1] + HALF_EXPOSURE, struck[number] - HALF_EXPOSURE
    inside &= (frame[near] > flight[0][:, None]) & (frame[near] < flight[1][:, None])
    time = frame[near] - (frame[rows] + frame[rows + 1])[:, None] / 2
    inside &= np.isfinite(signal[near]) & (np.abs(time) < SIDE_FRAMES)
    sides = np.stack([inside & (time < 0), inside & (time > 0)], axis=-1)
    known = sides.sum(axis=1).min(axis=1) >= SIDE_ROWS
    rows, near, inside = rows[known], near[known], inside[known]
    design = np.concatenate([sides[known], (inside * time[known])[..., None]], axis=-1)
    place = np.where(inside, signal[near] - signal[rows][:, None], 0.0)
    lines, covariance, squares = least_squares(design, place)
    freedom = np.maximum(inside.sum(axis=1) - 3, 1)
    variance = np.maximum(sigma_of(signal) ** 2, squares / freedom)
    return _Steps(rows, lines, covariance * variance[:, None, None])


def _is_misplaced(shown: Sequence[_Steps], strays: float) -> bool:
    """Whether bodies are misplaced after a picture, for no frames left out explain their steps.

    Those move each body by as much as its velocity makes it. A knock of the camera moves both by
    the same, and a template that slips moves one alone; that both slip is as rare as frames are
    left out, once more. ``strays`` are the squares, over their variance, that the likeliest number
    of frames leaves.
    """
    if len(shown) < 2:
        return False
    ball, heavy = shown
    variance = ball.variance(0.0) + heavy.variance(0.0)
    knocked = float(((ball.step_px - heavy.step_px) ** 2 / variance)[0])
    slipped = min(float(one.beyond(0.0)[0]) for one in shown)
    # Frames left out are as likely beforehand as one of these three: a knock, or either that slips.
    return min(knocked, slipped, -2 * math.log(LEFT_OUT)) + 2 * math.log(3) < strays


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


def ramps_of(track: Track, collisions: Sequence[Collision]) -> Iterator[list[Ramp]]:
    """Yield changes of the rate that the clip may have; none where nothing shows any.

    The rate rises where collisions are close and falls again later, by the same factor; or the clip
    shows one of both changes. Exports leave out pictures, so the factor is a whole number. Those
    at the same places, by the factors that come into question, come together, the likeliest first.
    """
    changes = rate_changes(gaps_of(track), collisions)
    changes.sort(key=lambda change: -abs(np.log(change[1])))
    rises = [change for change in changes if change[1] < 1][:TRIED]
    falls = [change for change in changes if change[1] > 1][:TRIED]
    both = [(rise, fall) for rise in rises for fall in falls if rise < fall]
    for some in (*both, *((change,) for change in (*rises, *falls))):
        at, sizes = tuple(one[0] for one in some), [max(one[1], 1 / one[1]) for one in some]
        low, high = max(sizes) / (1 + FACTOR_SHARE), min(sizes) * (1 + FACTOR_SHARE)
        whole = np.arange(max(2, int(np.ceil(low))), min(FACTOR_AT_MOST, int(high)) + 1)
        factors = whole[np.argsort(np.abs(whole - np.sqrt(low * high)))].tolist()
        if factors:
            yield [Ramp(at, some[0][1] < 1, factor) for factor in factors]

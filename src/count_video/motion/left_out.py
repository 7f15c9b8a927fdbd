r"""Frames left out of a clip without a trace in its time stamps: a hypothesis about the times.

    place            .'
                   .'        after so many frames left out a body goes on from
                             where it would have been by then: its place steps,
             .'              its velocity does not
           .'
          ----------+------> frame

No collision makes a place step. For each step from picture to picture that holds no contact of a
body, the places on both sides are fitted by two lines with one slope v. The step s between them,
over its uncertainty, is the likelihood ratio of frames left out against none, and s / v is their
number. The heavy body shows it best, as it turns round but once; the ball shows that there is a
step, but may have collided in what is left out.

Where collisions are close no flight is long enough for a line: there the fit of the whole burst
seeks them (see ``skips``).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from count_video.motion.errors_of_places import HALF_EXPOSURE
from count_video.motion.gaps import Gaps, gaps_of
from count_video.motion.time_base import TimeBase, even
from count_video.reasons import Cause, Reason
from count_video.records import Collision, Floats, Track
from count_video.signals import sigma_of

SIDE_FRAMES = 8.0
"""So many frames on either side show a step; threads and slopes hardly bend a path in them."""
SIDE_ROWS = 3
STEP_SIGMAS = 8.0
"""Of all steps of a thousand clips none is so large by noise that lasts for some frames."""
FRAMES_AT_LEAST = 0.75
"""What moves a body by less than this part of a frame's way is an uneven time base, no frame."""
FRAMES_AT_MOST = 500


@dataclass(frozen=True)
class LeftOut:
    """Frames that are missing between two pictures."""

    after: float
    """Frame coordinate of the picture before them."""
    frames: int
    """How many they are."""

    @property
    def note(self) -> Reason:
        """What is unusual about the clip."""
        return Reason(Cause.GAP_MADE_UP_FOR, (self.after, self.frames))

    def time_base(self, frame: Floats) -> TimeBase:
        """Time pictures in these frames, shape (n,), as if those left out were there."""
        late = frame > self.after
        return replace(
            even(frame),
            time=frame + self.frames * late,
            gap=int(np.argmax(late)) - 1,
            notes=(self.note,),
        )


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
    gaps = gaps_of(track)
    later = min((one.frame for one in collisions[burst:]), default=np.inf)
    steps = _steps(gaps, collisions[:burst], later)
    clarity, row, frames = max(steps, default=(0.0, 0, 0.0))
    # The heavy body is likelier to have met nothing in them.
    frames = next((last for _, other, last in steps[::-1] if other == row), frames)
    if clarity == 0.0 or frames > FRAMES_AT_MOST:
        return None
    return LeftOut(float(gaps.frame[row]), max(1, round(frames)))


def _steps(
    gaps: Gaps, collisions: Sequence[Collision], end: float
) -> list[tuple[float, int, float]]:
    """List clear steps that no contact explains, from the first contact on: the heavy body's last.

    Of each its clarity, the row of the picture before it, and the frames that it is worth.
    """
    found: list[tuple[float, int, float]] = []
    frame = gaps.frame
    rows = np.flatnonzero((frame[:-1] > collisions[0].frame) & (frame[1:] < end))
    for signal, kinds in ((gaps.ball_px, ("bodies", "wall")), (gaps.heavy_px, ("bodies",))):
        struck = np.array([-np.inf, *(c.frame for c in collisions if c.kind in kinds), end])
        number = np.searchsorted(struck[:-1], frame[rows], side="right")
        flight = np.stack([struck[number - 1], struck[number]])
        clarity, frames = _clarity(frame, signal, rows, flight)
        clear = (clarity > STEP_SIGMAS) & (frames > FRAMES_AT_LEAST)
        clear &= flight[1] > frame[rows + 1]
        found += [
            (float(clarity[n]), int(rows[n]), float(frames[n])) for n in np.flatnonzero(clear)
        ]
    return found


def _clarity(
    frame: Floats, signal: Floats, rows: NDArray[np.intp], flights: Floats
) -> tuple[Floats, Floats]:
    """Clarity of the steps after rows, and the frames that each is worth; 0 if places are too few.

    Both have shape (rows,). ``flights``, shape (2, rows), are the contacts before and after each.
    Two lines with one slope are fitted to the places before and after the step.
    """
    side = int(SIDE_FRAMES)
    near = rows + np.arange(1 - side, side + 1)[:, None]
    inside = (near >= 0) & (near < len(frame))
    near = near.clip(0, len(frame) - 1)
    inside &= (frame[near] > flights[0] + HALF_EXPOSURE) & (
        frame[near] < flights[1] - HALF_EXPOSURE
    )
    middle = (frame[rows] + frame[rows + 1]) / 2
    inside &= np.isfinite(signal[near]) & (np.abs(frame[near] - middle) < SIDE_FRAMES)
    shape = (2, side, len(rows))
    shown = inside.reshape(shape)
    count = shown.sum(axis=1)
    time, place = (
        np.where(inside, values, 0.0).reshape(shape)
        for values in (frame[near] - middle, signal[near])
    )
    with np.errstate(invalid="ignore", divide="ignore"):
        means = [values.sum(axis=1) / count for values in (time, place)]
        time, place = (
            np.where(shown, values - mean[:, None], 0.0)
            for values, mean in zip((time, place), means, strict=True)
        )
        squares = (time**2).sum(axis=(0, 1))
        rate = (time * place).sum(axis=(0, 1)) / squares
        apart = means[0][1] - means[0][0]
        step = means[1][1] - means[1][0] - rate * apart
        rest = ((place - rate * time) ** 2).sum(axis=(0, 1))
        variance = np.maximum(sigma_of(signal) ** 2, rest / np.maximum(count.sum(axis=0) - 3, 1))
        variance = variance * ((1 / count).sum(axis=0) + apart**2 / squares)
        known = (count.min(axis=0) >= SIDE_ROWS) & (rate != 0)
        clarity = np.where(known, np.abs(step) / np.sqrt(variance), 0.0)
        return clarity, np.where(known, step / rate, 0.0)

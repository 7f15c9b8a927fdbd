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
seeks them (see ``time_base``).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from count_video.motion.gaps import Gaps, gaps_of
from count_video.motion.pieces import HALF_EXPOSURE
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
"""What moves a body by less than this part of a frame's way is an uneven clock, no frame."""
FRAMES_AT_MOST = 500
SAME_FRAMES = 0.5
"""Both bodies give the same number to this part of a frame."""


@dataclass(frozen=True)
class LeftOut:
    """Frames that are missing between two pictures."""

    after: float
    """Frame coordinate of the picture before them."""
    frames: int
    """How many they are."""
    flown: bool
    """Whether the ball goes on as if it had met nothing in them."""

    @property
    def note(self) -> Reason:
        """What is unusual about the clip."""
        return Reason(Cause.GAP_MADE_UP_FOR, (self.after, self.frames))

    def time_base(self, frame: Floats) -> TimeBase:
        """Time pictures in these frames, shape (n,), as if those left out were there."""
        late = frame > self.after
        doubts = () if self.flown else (Reason(Cause.LEFT_OUT, (self.after, self.frames)),)
        return replace(
            even(frame),
            time=frame + self.frames * late,
            gap=int(np.argmax(late)) - 1,
            notes=(self.note,),
            doubts=doubts,
        )


def left_out(track: Track, collisions: Sequence[Collision], burst: int) -> LeftOut | None:
    """Find the clearest place where frames of the burst are left out; None if there is none.

    Parameters
    ----------
    track
        Both bodies by the clock that is in question.
    collisions
        What it shows by that clock.
    burst
        How many of these belong to the burst; what is left out beyond them may hold more of it.
    """
    if burst == 0:
        return None
    gaps = gaps_of(track)
    later = min((one.frame for one in collisions[burst:]), default=np.inf)
    steps = _steps(gaps, collisions[:burst], later)
    clearest = max(steps, key=lambda step: step.clarity, default=None)
    if clearest is None:
        return None
    here = {step.heavy: step.frames for step in steps if step.row == clearest.row}
    frames = here.get(True, clearest.frames)
    if frames > FRAMES_AT_MOST:
        return None
    flown = len(here) > 1 and abs(here[False] - here[True]) < SAME_FRAMES
    return LeftOut(float(gaps.frame[clearest.row]), max(1, round(frames)), flown)


@dataclass(frozen=True)
class _Step:
    row: int
    """Of the picture before it."""
    clarity: float
    frames: float
    heavy: bool


def _steps(gaps: Gaps, collisions: Sequence[Collision], end: float) -> list[_Step]:
    """List clear steps of either body that no contact explains, from the first contact on."""
    found, first = [], collisions[0].frame
    for heavy, signal in ((False, gaps.ball_px), (True, gaps.heavy_px)):
        struck = [c.frame for c in collisions if not heavy or c.kind == "bodies"]
        seen, sigma = np.isfinite(signal), sigma_of(signal)
        for row in np.flatnonzero((gaps.frame[:-1] > first) & (gaps.frame[1:] < end)):
            low = max([at for at in struck if at <= gaps.frame[row]], default=-np.inf)
            high = min([at for at in struck if at > gaps.frame[row]], default=end)
            middle = (gaps.frame[row] + gaps.frame[row + 1]) / 2
            inside = seen & (gaps.frame > low + HALF_EXPOSURE) & (gaps.frame < high - HALF_EXPOSURE)
            inside &= np.abs(gaps.frame - middle) < SIDE_FRAMES
            step = _step(gaps.frame[inside] - middle, signal[inside], sigma)
            if step is not None and high > gaps.frame[row + 1]:
                found.append(_Step(int(row), step[0], step[1], heavy))
    return [step for step in found if step.clarity > STEP_SIGMAS and step.frames > FRAMES_AT_LEAST]


def _step(time: Floats, place: Floats, sigma: float) -> tuple[float, float] | None:
    """Clarity of a step at time 0 and the frames that it is worth; None if places are too few."""
    after = time > 0
    if min(after.sum(), (~after).sum()) < SIDE_ROWS:
        return None
    design = np.column_stack([np.ones_like(time), time, after])
    inverse = np.linalg.inv(design.T @ design)
    _, rate, step = inverse @ design.T @ place
    if rate == 0:
        return None
    rest = place - design @ (inverse @ design.T @ place)
    variance = max(sigma**2, float(rest @ rest) / max(len(time) - 3, 1))
    return abs(float(step)) / float(np.sqrt(variance * inverse[2, 2])), float(step / rate)

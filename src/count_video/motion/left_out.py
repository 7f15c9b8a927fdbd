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

from collections.abc import Iterator, Sequence
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
    steps = list(_steps(gaps, collisions[:burst], later))
    clarity, row, frames = max(steps, default=(0.0, 0, 0.0))
    # The heavy body is likelier to have met nothing in them.
    frames = next((last for _, other, last in steps[::-1] if other == row), frames)
    if clarity == 0.0 or frames > FRAMES_AT_MOST:
        return None
    return LeftOut(float(gaps.frame[row]), max(1, round(frames)))


def _steps(
    gaps: Gaps, collisions: Sequence[Collision], end: float
) -> Iterator[tuple[float, int, float]]:
    """Yield clear steps that no contact explains, from the first contact on: the heavy body's last.

    Of each its clarity, the row of the picture before it, and the frames that it is worth.
    """
    first = collisions[0].frame
    for signal, kinds in ((gaps.ball_px, ("bodies", "wall")), (gaps.heavy_px, ("bodies",))):
        struck = [c.frame for c in collisions if c.kind in kinds]
        seen, sigma = np.isfinite(signal), sigma_of(signal)
        for row in np.flatnonzero((gaps.frame[:-1] > first) & (gaps.frame[1:] < end)).tolist():
            low = max([at for at in struck if at <= gaps.frame[row]], default=-np.inf)
            high = min([at for at in struck if at > gaps.frame[row]], default=end)
            middle = (gaps.frame[row] + gaps.frame[row + 1]) / 2
            inside = seen & (gaps.frame > low + HALF_EXPOSURE) & (gaps.frame < high - HALF_EXPOSURE)
            inside &= np.abs(gaps.frame - middle) < SIDE_FRAMES
            clarity, frames = _step(gaps.frame[inside] - middle, signal[inside], sigma)
            clear = clarity > STEP_SIGMAS and frames > FRAMES_AT_LEAST
            if clear and high > gaps.frame[row + 1]:
                yield clarity, row, frames


def _step(time: Floats, place: Floats, sigma: float) -> tuple[float, float]:
    """Clarity of a step at time 0 and the frames that it is worth; 0 if places are too few."""
    after = time > 0
    if min(after.sum(), (~after).sum()) < SIDE_ROWS:
        return 0.0, 0.0
    design = np.column_stack([np.ones_like(time), time, after])
    inverse = np.linalg.inv(design.T @ design)
    _, rate, step = inverse @ design.T @ place
    if rate == 0:
        return 0.0, 0.0
    rest = place - design @ (inverse @ design.T @ place)
    variance = max(sigma**2, float(rest @ rest) / max(len(time) - 3, 1))
    return abs(float(step)) / float(np.sqrt(variance * inverse[2, 2])), float(step / rate)

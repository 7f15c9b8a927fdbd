r"""When the pictures of a clip were taken: hypotheses about its frames, and which one stands.

    time                          .             time                 .
                             _..-'   rate                         .-'   frames left out
                       __..-'        changes                     |
                 _..-''                                       .-'
               .'                                          .-'
              +------------------> frame                  +------------------> frame

Frames are usually as even as the camera took them. Converters put copies between them, and
slow-motion exports leave pictures out in a part of the clip. Each such hypothesis gives every
picture its time; collisions are found by these times and placed among the frames that show them.
Cuts leave frames out without a trace: the fit of the whole burst finds them (see ``skips``).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple, dataclass, replace

import numpy as np
from numpy.typing import NDArray

from count_video.reasons import Cause, Reason
from count_video.records import BodyTrack, Collision, Floats, Track, Velocities


@dataclass(frozen=True)
class TimeBase:
    """Times of the n pictures of a clip, by one hypothesis about its frames."""

    frame: Floats
    """Frame coordinate in which each picture comes first, shape (n,)."""
    time: Floats
    """When it was taken, in frames of the camera, increasing, shape (n,)."""
    until: Floats
    """Frame coordinate in which each picture is shown last, shape (n,)."""
    rows: NDArray[np.bool_]
    """Which rows of the track show a new picture."""
    keeps_rate: bool = True
    """Whether the frames count as even but for what is left out or put in between them; else
    velocities and uncertainties are those of the frames about a collision."""
    notes: tuple[Reason, ...] = ()
    """What is unusual about the clip."""

    def evened(self, track: Track) -> Track:
        """Time the pictures of a track by this hypothesis."""
        return replace(at_rows(track, self.rows), frame=self.time)

    def shown(self, collision: Collision) -> Collision:
        """Place a collision among the frames: after the last that shows the picture before it."""
        k, pace = self._before(self.time, collision)
        return self._moved(collision, self.time[k], self.until[k], 1 / pace)

    def timed(self, collision: Collision) -> Collision:
        """Convert a collision from frames to these times."""
        k, pace = self._before(self.frame, collision)
        return self._moved(collision, self.until[k], self.time[k], pace)

    def _before(self, starts: Floats, collision: Collision) -> tuple[int, float]:
        """Picture before a collision, and the time that a frame takes after it."""
        k = int(np.searchsorted(starts, collision.frame, side="right")) - 1
        k = min(max(k, 0), len(self.time) - 2)
        return k, (self.time[k + 1] - self.time[k]) / (self.frame[k + 1] - self.until[k])

    def _moved(self, collision: Collision, start: float, to: float, pace: float) -> Collision:
        scaled = collision if self.keeps_rate else in_frames(collision, pace)
        return replace(scaled, frame=float(to + (collision.frame - start) * pace))


def even(frame: Floats) -> TimeBase:
    """Take pictures for evenly taken, of which the frame coordinates have shape (n,)."""
    return TimeBase(frame, frame, frame, np.ones(len(frame), dtype=bool))


def left_out(after: float, frames: int) -> TimeBase:
    """Let so many frames be missing after a picture, of which the frame coordinate is given."""
    frame = after + np.arange(-1.0, 3.0)  # on both sides it goes on evenly
    notes = (Reason(Cause.GAP_MADE_UP_FOR, (after, frames)),) if frames else ()
    return replace(even(frame), time=frame + frames * (frame > after), notes=notes)


@dataclass(frozen=True)
class Ramp:
    """Changes of a clip's rate, by turns to the one and the other of two."""

    changes: tuple[float, ...]
    """Frame coordinates at which the rate changes, increasing."""
    sparse_first: bool
    """Whether pictures are left out before the first of them; from then on by turns."""
    factor: int
    """Time from picture to picture where some are left out over that where none are."""

    def time_base(self, frame: Floats) -> TimeBase:
        """Time pictures in these frames, shape (n,), in the shortest of their steps."""
        ends = np.concatenate([frame[:1], self.changes, frame[-1:]])
        pace = np.where(self._sparse(np.arange(len(ends) - 1)), self.factor, 1)
        times = np.concatenate([[0.0], np.cumsum(np.diff(ends) * pace)])
        note = Reason(Cause.RATE_CHANGES, (self.factor, *self.changes))
        time = np.interp(frame, ends, times)
        return replace(even(frame), time=time, keeps_rate=False, notes=(note,))

    def slows(self, frames: Sequence[float]) -> bool:
        """Whether a collision, of which the frames are given, lies where no pictures are left out.

        Where none does, no count hangs on the change, and it may be none: bodies that are let go
        speed up as well.
        """
        return not bool(self._sparse(np.searchsorted(self.changes, frames)).all())

    def _sparse(self, stretch: NDArray[np.intp]) -> NDArray[np.bool_]:
        return np.asarray((stretch % 2 == 0) == self.sparse_first)


def at_rows(track: Track, rows: NDArray[np.bool_]) -> Track:
    """Keep these rows of a track, shape (n,)."""

    def kept(body: BodyTrack) -> BodyTrack:
        return replace(body, position_px=body.position_px[rows], sigma_px=body.sigma_px[rows])

    return replace(
        track,
        frame=track.frame[rows],
        ball=kept(track.ball),
        heavy=None if track.heavy is None else kept(track.heavy),
        shift_px=None if track.shift_px is None else track.shift_px[rows],
        beside_px=None if track.beside_px is None else track.beside_px[rows],
        stamped=None if track.stamped is None else track.stamped[rows],
        turned=track.turned and replace(track.turned, turns=track.turned.turns[rows]),
    )


def frames_per_picture(track: Track) -> float:
    """Usual number of frames from one new picture to the next; 1 for footage as it was filmed."""
    if len(track.frame) < 2:
        return 1.0
    return float(np.median(np.diff(track.frame)))


def in_pictures(track: Track, pace: float) -> Track:
    """Count the track's frames in pictures."""
    return track if pace == 1.0 else replace(track, frame=track.frame / pace)


def in_frames(collision: Collision, pace: float) -> Collision:
    """Convert a collision that was found in pictures to frames."""
    return replace(
        collision,
        frame=collision.frame * pace,
        frame_sigma=collision.frame_sigma * pace,
        velocity_before=_slowed(collision.velocity_before, pace),
        velocity_after=_slowed(collision.velocity_after, pace),
    )


def _slowed(velocities: Velocities, pace: float) -> Velocities:
    return Velocities(*(value / pace for value in astuple(velocities)))

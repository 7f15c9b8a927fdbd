"""The clock of a clip into which copies were put: its pictures were taken evenly, its frames not.

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

from dataclasses import astuple, dataclass, replace

import numpy as np
from numpy.typing import NDArray

from count_video.motion.swing import Swing
from count_video.records import BodyTrack, Collision, Floats, Track, Velocities
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


@dataclass(frozen=True)
class Cadence:
    """Even times of the pictures of a clip."""

    rows: NDArray[np.bool_]
    """Which rows of the track show a new picture, shape (rows,)."""
    frame: Floats
    """Frame in which each picture comes first, shape (n,)."""
    step: float
    """Frames from one picture to the next on average."""

    def evened(self, track: Track) -> Track:
        """Time the pictures of a track evenly, in frames on average."""
        heavy = None if track.heavy is None else self._pictures_of(track.heavy)
        frame = self.frame[0] + self.step * np.arange(len(self.frame))
        return replace(track, frame=frame, ball=self._pictures_of(track.ball), heavy=heavy)

    def _pictures_of(self, body: BodyTrack) -> BodyTrack:
        return replace(
            body, position_px=body.position_px[self.rows], sigma_px=body.sigma_px[self.rows]
        )

    def shown(self, collision: Collision) -> Collision:
        """Place a collision that was found between evened pictures among the frames that show it.

        It lies between the last frame that shows the picture before it and the first that shows
        the picture after it.
        """
        place = (collision.frame - self.frame[0]) / self.step
        before = int(np.clip(np.floor(place), 0, len(self.frame) - 2))
        return replace(collision, frame=float(self.frame[before + 1]) - 1.0 + place - before)


def cadence_of(track: Track) -> Cadence | None:
    """Find copies that were put between evenly taken pictures; None where the frames are even.

    Both clocks are tried on the bodies' steps wherever the step between frames changes.
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
    return Cadence(rows, frame, step)


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


def swing_in_frames(swing: Swing | None, pace: float) -> Swing | None:
    """Convert a swing that was fitted in pictures to frames."""
    if swing is None:
        return None
    return replace(
        swing,
        rate_squared=swing.rate_squared / pace**2,
        rate_squared_sigma=swing.rate_squared_sigma / pace**2,
    )

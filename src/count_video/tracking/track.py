"""One clip from frames to positions: find the bodies in a few runs, then follow them through all.

The footage is decoded twice only in part: a pilot of short runs spread over the clip teaches what
the bodies look like; the main pass streams every frame once and keeps none of them.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from count_video.errors import TrackingError
from count_video.footage.reader import Footage
from count_video.progress import NO_PROGRESS, Progress
from count_video.records import Frame, Track, WallSide
from count_video.tracking.follow import Follower
from count_video.tracking.pairs.bodies import Bodies, NotFound
from count_video.tracking.pairs.finding import Finder
from count_video.tracking.pilot import pilots
from count_video.tracking.placed import track_of
from count_video.tracking.silhouettes.beside import PROGRESS_STEP, Pass, follow_beside
from count_video.tracking.steadying.camera import Camera, Motion
from count_video.tracking.steadying.landmarks import clear_of
from count_video.tracking.steadying.standing import steadied
from count_video.tracking.view import Region, TrackSettings, View, view_of

__all__ = ["Region", "TrackSettings", "track_clip", "tracks"]

PAIRS_AT_MOST = 3
"""So many pairs of bodies are followed in turn, should the others not do."""


def track_clip(
    footage: Footage, settings: TrackSettings, progress: Progress = NO_PROGRESS
) -> Track:
    """Measure where ball and heavy body were, frame by frame; raises as :func:`tracks` does."""
    return next(tracks(footage, settings, progress))


def tracks(
    footage: Footage,
    settings: TrackSettings,
    progress: Progress = NO_PROGRESS,
    *,
    closely: bool = False,
) -> Iterator[Track]:
    """Measure where ball and heavy body were, frame by frame, the likeliest bodies first.

    There is a second track only where more than two things move, or one body shows up in different
    ways. Each takes a pass through the footage when it is asked for. ``closely`` looks, for longer,
    for bodies that are not found otherwise.

    Raises
    ------
    TrackingError
        If no pair of bodies that could collide is found; the message says what was missing.
    UsageError
        If the region does not fit into the picture.
    """
    view = view_of(footage, settings)
    steady, camera, finder, bodies = _first_found(view, closely=closely)
    if isinstance(bodies, NotFound):
        _pass_over(view, progress)
        raise TrackingError(bodies.reason)
    tried: list[Bodies] = []
    faults: list[TrackingError] = []
    shown = False
    while isinstance(bodies, Bodies):
        beside = () if tried else steady
        for found in _outcomes((view, settings.wall_side), bodies, camera, beside, progress):
            if isinstance(found, TrackingError):
                faults.append(found)
            else:
                shown = True
                yield found
        tried.append(bodies)
        bodies = finder.find(tried) if len(tried) < PAIRS_AT_MOST else NotFound("")
    if faults and not shown:
        raise faults[0]


def _first_found(
    view: View, *, closely: bool
) -> tuple[list[list[Frame]], Camera, Finder, Bodies | NotFound]:
    """Look through the pilots until one shows two bodies; what the last tells if none does."""
    for runs in pilots(view):
        steady, camera = steadied(runs)
        finder = Finder(steady, closely=closely)
        bodies = finder.find()
        if isinstance(bodies, Bodies):
            break
    return steady, camera, finder, bodies


def _outcomes(
    view_and_side: tuple[View, WallSide | None],
    bodies: Bodies,
    camera: Camera,
    beside: Sequence[Sequence[Frame]],
    progress: Progress,
) -> Iterator[Track | TrackingError]:
    """Follow two bodies by their looks, and then the neighbour of one by its silhouette.

    The latter only where there are runs of frames to find it ``beside``.
    """
    view = view_and_side[0]
    landmarks = camera.landmarks and clear_of(camera.landmarks, bodies.swept())
    passes = frames, followers, motion = _follow(view, bodies, Camera(landmarks), progress)
    try:
        yield _with_shift(track_of(bodies, frames, followers, view_and_side), motion, view)
    except TrackingError as error:
        yield error
    seen = follow_beside(view, beside, bodies, passes, progress) if beside else None
    if seen is None:
        return
    try:
        yield replace(track_of(*seen, view_and_side), by_silhouette=True)
    except TrackingError as error:
        yield error


def _with_shift(track: Track, motion: Motion | None, view: View) -> Track:
    """Add to a track how the camera moved, if it did."""
    if motion is None:
        return track
    # Where the shift is unknown no body has a place either.
    return replace(track, shift_px=view.factor * np.nan_to_num(motion.shift_px))


def _pass_over(view: View, progress: Progress) -> None:
    """Decode the footage all the same: what is damaged in it should be said."""
    progress.start(view.footage.info.frames_promised, "decoding")
    for _ in view.footage.frames(view.start, view.end):
        progress.advance(1)


def _follow(view: View, bodies: Bodies, camera: Camera, progress: Progress) -> Pass:
    slope = float(np.tan(np.radians(bodies.tilt_deg)))
    left, right = Follower(bodies.left, slope), Follower(bodies.right, slope)
    indices: list[float] = []
    progress.start(view.footage.info.frames_promised, "tracking")
    for frame in view.footage.frames(view.start, view.end):
        if not frame.repeats_previous:
            luma = view.of(frame).luma
            shift = camera.see(luma)
            picture, shift = (luma.T, shift[::-1]) if bodies.upright else (luma, shift)
            indices.append(float(frame.index))
            left.see(frame.index, picture, shift)
            right.see(frame.index, picture, shift)
        if frame.index % PROGRESS_STEP == PROGRESS_STEP - 1:
            progress.advance(PROGRESS_STEP)
    motion = camera.motion()
    if motion is not None:
        left.take_away(motion, bodies.upright)
        right.take_away(motion, bodies.upright)
    return np.array(indices), (left, right), motion

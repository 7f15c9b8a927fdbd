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
from count_video.records import BodyTrack, Floats, Frame, MotionLine, Track, WallSide
from count_video.tracking.beside import PROGRESS_STEP, Pass, follow_beside
from count_video.tracking.bodies import Bodies, NotFound
from count_video.tracking.camera import Camera, Motion
from count_video.tracking.certainty import stated_sigmas
from count_video.tracking.finding import Finder
from count_video.tracking.follow import Follower
from count_video.tracking.landmarks import clear_of
from count_video.tracking.pilot import pilots
from count_video.tracking.roles import wall_side
from count_video.tracking.standing import steadied
from count_video.tracking.view import Region, TrackSettings, View, view_of

__all__ = ["Region", "TrackSettings", "track_clip", "tracks"]

FRAMES_AT_LEAST = 12
"""Shorter clips show no motion to speak of."""
SEEN_AT_LEAST = 0.5
"""A body seen in a smaller share of the frames between its first and its last was not followed."""
PRESENT_AT_LEAST = 0.2
"""A body comes in and goes out again, but is there for this share of the clip."""
PAIRS_AT_MOST = 3
"""So many pairs of bodies are followed in turn, should the others not do."""
UNSURE_FACTOR = 8.0
"""A sighting with an uncertainty so many times the usual one is not believed: blur at full speed
and a body half hidden double or treble it."""


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
    for runs in pilots(view):
        steady, camera = steadied(runs)
        finder = Finder(steady, closely=closely)
        bodies = finder.find()
        if isinstance(bodies, Bodies):
            break
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
        yield _with_shift(_track(bodies, frames, followers, view_and_side), motion, view)
    except TrackingError as error:
        yield error
    seen = follow_beside(view, beside, bodies, passes, progress) if beside else None
    if seen is None:
        return
    try:
        yield replace(_track(*seen, view_and_side), by_silhouette=True)
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


def _track(
    bodies: Bodies,
    frames: Floats,
    followers: tuple[Follower, Follower],
    view_and_side: tuple[View, WallSide | None],
) -> Track:
    if len(frames) < FRAMES_AT_LEAST:
        raise TrackingError(f"only {len(frames)} different pictures: too few to show collisions")
    view, side = view_and_side
    x_px = [view.in_picture(_sure_places(f), upright=bodies.upright) for f in followers]
    edges = [
        (view.factor * body.left_edge_px, view.factor * body.right_edge_px)
        for body in (bodies.left, bodies.right)
    ]
    sigma_px = stated_sigmas(frames, x_px, [view.factor * np.array(f.sigma_px) for f in followers])
    unseen = [float(np.isnan(x).mean()) for x in x_px]
    if not all(_followed(x) for x in x_px):
        raise TrackingError("the bodies cannot be followed through the clip: they are lost")
    side = side or wall_side(x_px[0] + edges[0][0], x_px[1] + edges[1][1])
    wall_seen = side is not None
    side = side or "left"
    ball, heavy = (0, 1) if side == "left" else (1, 0)
    width = edges[ball][1] - edges[ball][0]
    face = edges[heavy][0] if side == "left" else edges[heavy][1]
    return Track(
        frame=frames,
        ball=BodyTrack(
            x_px[ball] + edges[ball][0] + width / 2,
            sigma_px[ball],
            -width / 2,
            width / 2,
        ),
        heavy=BodyTrack(
            x_px[heavy] + face,
            sigma_px[heavy],
            edges[heavy][0] - face,
            edges[heavy][1] - face,
        ),
        wall_side=side,
        ball_diameter_px=width,
        line=_line(bodies, followers[ball], view),
        warnings=tuple(_unseen_warnings(unseen, len(frames), ball)),
        wall_seen=wall_seen,
    )


def _followed(x_px: Floats) -> bool:
    """Whether a body is seen in most frames while it is in the picture, shape (n,)."""
    seen = np.flatnonzero(np.isfinite(x_px))
    if len(seen) < max(FRAMES_AT_LEAST, PRESENT_AT_LEAST * len(x_px)):
        return False
    return len(seen) >= SEEN_AT_LEAST * (int(seen[-1]) - int(seen[0]) + 1)


def _sure_places(follower: Follower) -> Floats:
    """Places along the line in the follower's pictures; NaN for sightings that are hardly any.

    What is left of a body that sticks out of the picture may match the scenery; it does so loosely.
    """
    sigma = np.array(follower.sigma_px)
    usual = np.nanmedian(sigma) if np.isfinite(sigma).any() else np.nan
    return np.where(sigma <= UNSURE_FACTOR * usual, np.array(follower.x_px), np.nan)


def _line(bodies: Bodies, ball: Follower, view: View) -> MotionLine:
    """Line of motion through the middle of the ball's places."""
    height, width = ball.body.sprite.shape
    along = view.in_picture(np.array(ball.x_px) + width / 2, upright=bodies.upright)
    across = view.in_picture(np.array(ball.y_px) + height / 2, upright=not bodies.upright)
    x, y = float(np.nanmedian(along)), float(np.nanmedian(across))
    if bodies.upright:
        x, y = y, x
    return MotionLine(x, y, bodies.tilt_deg, bodies.upright)


def _unseen_warnings(unseen: Sequence[float], frames: int, ball: int) -> list[str]:
    names = ("ball", "cylinder") if ball == 0 else ("cylinder", "ball")
    return [
        f"the {name} is not seen in {round(share * frames)} of {frames} frames"
        for name, share in zip(names, unseen, strict=True)
        if share > 0
    ]

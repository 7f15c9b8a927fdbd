"""One clip from frames to positions: find the bodies in a few runs, then follow them through all.

The footage is decoded twice only in part: a pilot of short runs spread over the clip teaches what
the bodies look like; the main pass streams every frame once and keeps none of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from count_video.errors import TrackingError, UsageError
from count_video.footage.reader import Footage, pilot_frames
from count_video.progress import NO_PROGRESS, Progress
from count_video.records import BodyTrack, Floats, Frame, MotionLine, Track, WallSide
from count_video.tracking.bodies import Bodies, NotFound, find_bodies
from count_video.tracking.follow import Follower
from count_video.tracking.roles import wall_side

PILOT_BYTES = 70_000_000
"""Pictures of the pilot are held in memory; so much may they take."""
PILOT_FRAMES = 180
PILOT_FRAMES_AT_LEAST = 24
SMALL_CLIP_PIXELS = 4e8
"""Clips with fewer pixels in all frames together are decoded whole for the pilot."""
SLOW_STRIDE = 4
"""Where nothing is found, the runs are made so many times as long."""
UNKNOWN_LENGTH_FRAMES = 2000
"""Taken for the length of a clip that does not tell it."""
RUN_FRAMES = 12
"""Runs are cut to about this length."""
FRAMES_AT_LEAST = 12
"""Shorter clips show no motion to speak of."""
SEEN_AT_LEAST = 0.5
"""A body seen in a smaller share of the frames was not followed."""
PROGRESS_STEP = 16

Region = tuple[int, int, int, int]
"""x, y, width, height in px."""


@dataclass(frozen=True)
class TrackSettings:
    """What the user may tell the tracker; everything is found where nothing is told."""

    wall_side: WallSide | None = None
    region: Region | None = None
    """Part of the picture that holds the experiment."""
    start: int = 0
    """First frame to use."""
    end: int | None = None
    """Frame to stop before; None for the clip's end."""


def track_clip(
    footage: Footage, settings: TrackSettings, progress: Progress = NO_PROGRESS
) -> Track:
    """Measure where ball and heavy body were, frame by frame.

    Raises
    ------
    TrackingError
        If no pair of bodies that could collide is found; the message says what was missing.
    UsageError
        If the region does not fit into the picture.
    """
    _check_region(footage, settings.region)
    bodies = find_bodies(_pilot(footage, settings))
    if isinstance(bodies, NotFound):
        # Bodies may creep, or show up far from any key frame: look at longer stretches.
        bodies = find_bodies(_evenly(footage, settings, SLOW_STRIDE))
    if isinstance(bodies, NotFound):
        _pass_over(footage, settings, progress)
        raise TrackingError(bodies.reason)
    frames, left, right = _follow(footage, bodies, settings, progress)
    return _track(bodies, frames, (left, right), settings)


def _check_region(footage: Footage, region: Region | None) -> None:
    if region is None:
        return
    x, y, width, height = region
    info = footage.info
    if x < 0 or y < 0 or x + width > info.width_px or y + height > info.height_px:
        raise UsageError(
            f"region {x},{y},{width},{height} does not fit into the picture of "
            f"{info.width_px} x {info.height_px} px; give one that lies inside"
        )


def _pilot(footage: Footage, settings: TrackSettings) -> list[list[Frame]]:
    """Take runs of frames spread over the clip; copies of pictures are left out.

    A small clip is decoded for it from end to end, which costs little and shows every phase; of a
    large one only what follows its key frames.
    """
    promised = footage.info.frames_promised
    small = promised is not None and promised < SMALL_CLIP_PIXELS / _pixels(footage)
    if small:
        return _evenly(footage, settings, 1)
    runs = pilot_frames(
        footage.info.path, budget=_budget(footage), start=settings.start, end=settings.end
    )
    fresh = [[cropped(f, settings.region) for f in run if not f.repeats_previous] for run in runs]
    return [piece for run in fresh for piece in _pieces(run)]


def _pixels(footage: Footage) -> int:
    return footage.info.width_px * footage.info.height_px


def _budget(footage: Footage) -> int:
    """How many pictures the pilot may hold."""
    return int(np.clip(PILOT_BYTES // _pixels(footage), PILOT_FRAMES_AT_LEAST, PILOT_FRAMES))


def _evenly(footage: Footage, settings: TrackSettings, stride: int) -> list[list[Frame]]:
    """Keep runs of every ``stride``-th frame, evenly spaced, of a clip that is decoded whole."""
    promised = footage.info.frames_promised or UNKNOWN_LENGTH_FRAMES
    last = promised if settings.end is None else min(settings.end, promised)
    span = RUN_FRAMES * stride
    spacing = max(span, -(-(last - settings.start) * RUN_FRAMES // _budget(footage)))
    runs: dict[int, list[Frame]] = {}
    held = 0
    for frame in footage.frames(settings.start, settings.end):
        number, place = divmod(frame.index - settings.start, spacing)
        wanted = place < span and place % stride == 0 and not frame.repeats_previous
        if wanted and held < _budget(footage):
            kept = replace(frame, luma=frame.luma.copy())
            runs.setdefault(number, []).append(cropped(kept, settings.region))
            held += 1
    return list(runs.values())


def _pieces(run: list[Frame]) -> list[list[Frame]]:
    """Split a long run: within a piece, the bodies are to move evenly."""
    count = max(1, round(len(run) / RUN_FRAMES))
    edges = [round(part * len(run) / count) for part in range(count + 1)]
    return [run[a:b] for a, b in pairwise(edges) if b > a]


def cropped(frame: Frame, region: Region | None) -> Frame:
    """Cut the region out of a frame."""
    if region is None:
        return frame
    x, y, width, height = region
    return replace(frame, luma=frame.luma[y : y + height, x : x + width])


def _pass_over(footage: Footage, settings: TrackSettings, progress: Progress) -> None:
    """Decode the footage all the same: what is damaged in it should be said."""
    progress.start(footage.info.frames_promised, "decoding")
    for _ in footage.frames(settings.start, settings.end):
        progress.advance(1)


def _follow(
    footage: Footage, bodies: Bodies, settings: TrackSettings, progress: Progress
) -> tuple[Floats, Follower, Follower]:
    slope = float(np.tan(np.radians(bodies.tilt_deg)))
    left, right = Follower(bodies.left, slope), Follower(bodies.right, slope)
    indices: list[float] = []
    progress.start(footage.info.frames_promised, "tracking")
    for frame in footage.frames(settings.start, settings.end):
        if not frame.repeats_previous:
            luma = cropped(frame, settings.region).luma
            picture = luma.T if bodies.upright else luma
            indices.append(float(frame.index))
            left.see(frame.index, picture)
            right.see(frame.index, picture)
        if frame.index % PROGRESS_STEP == PROGRESS_STEP - 1:
            progress.advance(PROGRESS_STEP)
    return np.array(indices), left, right


def _track(
    bodies: Bodies,
    frames: Floats,
    followers: tuple[Follower, Follower],
    settings: TrackSettings,
) -> Track:
    if len(frames) < FRAMES_AT_LEAST:
        raise TrackingError(f"only {len(frames)} different pictures: too few to show collisions")
    offset = _offset(settings.region, bodies.upright)
    x_px = [np.array(f.x_px) + offset for f in followers]
    unseen = [float(np.isnan(x).mean()) for x in x_px]
    if max(unseen) > 1 - SEEN_AT_LEAST:
        raise TrackingError("the bodies cannot be followed through the clip: they are lost")
    side = settings.wall_side or wall_side(
        x_px[0] + bodies.left.left_edge_px, x_px[1] + bodies.right.right_edge_px
    )
    if side is None:
        raise TrackingError("neither body bounces off anything on its far side: no wall is seen")
    ball, heavy = (0, 1) if side == "left" else (1, 0)
    both = (bodies.left, bodies.right)
    width = both[ball].right_edge_px - both[ball].left_edge_px
    face = both[heavy].left_edge_px if side == "left" else both[heavy].right_edge_px
    return Track(
        frame=frames,
        ball=BodyTrack(
            x_px[ball] + both[ball].left_edge_px + width / 2,
            np.array(followers[ball].sigma_px),
            -width / 2,
            width / 2,
        ),
        heavy=BodyTrack(
            x_px[heavy] + face,
            np.array(followers[heavy].sigma_px),
            both[heavy].left_edge_px - face,
            both[heavy].right_edge_px - face,
        ),
        wall_side=side,
        ball_diameter_px=width,
        line=_line(bodies, followers[ball], settings.region),
        warnings=tuple(_unseen_warnings(unseen, len(frames), ball)),
    )


def _offset(region: Region | None, upright: bool) -> float:
    if region is None:
        return 0.0
    return float(region[1] if upright else region[0])


def _line(bodies: Bodies, ball: Follower, region: Region | None) -> MotionLine:
    """Line of motion through the middle of the ball's places."""
    x = float(np.nanmedian(ball.x_px)) + ball.body.sprite.shape[1] / 2
    y = float(np.nanmedian(ball.y_px)) + ball.body.sprite.shape[0] / 2
    if bodies.upright:
        x, y = y, x
    if region is not None:
        x, y = x + region[0], y + region[1]
    return MotionLine(x, y, bodies.tilt_deg, bodies.upright)


def _unseen_warnings(unseen: Sequence[float], frames: int, ball: int) -> list[str]:
    names = ("ball", "cylinder") if ball == 0 else ("cylinder", "ball")
    return [
        f"the {name} is not seen in {round(share * frames)} of {frames} frames"
        for name, share in zip(names, unseen, strict=True)
        if share > 0
    ]

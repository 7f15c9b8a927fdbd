"""Follow the neighbour of a steady body by its silhouette, where its look told nothing.

Asked after a pair of bodies was followed by their looks. The steadier of them is taken for granted;
on its other side its neighbour is sought again.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from count_video.progress import Progress
from count_video.records import Floats, Frame
from count_video.tracking.follow import Follower
from count_video.tracking.pairs.bodies import Bodies, transposed
from count_video.tracking.silhouettes.silhouette import Backdrop, Beside, edges_by_frame
from count_video.tracking.silhouettes.unsteady import Line, find_unsteady
from count_video.tracking.steadying.camera import Motion
from count_video.tracking.view import View

PROGRESS_STEP = 16
STEADY_SHARE = 0.9
"""A steady body is seen in this share of the frames at least."""

Pass = tuple[Floats, tuple[Follower, Follower], Motion | None]
"""Frames, the left and the right body as they were followed, and how the camera moved."""


def follow_beside(
    view: View,
    runs: Sequence[Sequence[Frame]],
    bodies: Bodies,
    seen: Pass,
    progress: Progress,
) -> tuple[Bodies, Floats, tuple[Follower, Follower]] | None:
    """Follow the neighbour of the steadier body; None where there is none.

    None as well if the camera moves: its pictures share no backdrop.
    """
    frames, _, motion = seen
    steady = _steadier(seen)
    if steady is None or motion is not None:
        return None
    follower, toward = steady
    if bodies.upright:
        runs = [[transposed(frame) for frame in run] for run in runs]
    found = find_unsteady(runs, *_beside(frames, follower, toward))
    if found is None:
        return None
    other = Follower(found[0], follower.slope)
    _follow(view, other, found[1], bodies.upright, progress)
    pair = (follower, other) if toward > 0 else (other, follower)
    return replace(bodies, left=pair[0].body, right=pair[1].body), frames, pair


def _steadier(seen: Pass) -> tuple[Follower, int] | None:
    """Pick the body that was placed better; 1 or -1 tells where its neighbour is."""
    frames, followers, _ = seen
    steady = [
        (follower, toward)
        for follower, toward in zip(followers, (1, -1), strict=True)
        if np.isfinite(follower.x_px).sum() >= STEADY_SHARE * len(frames)
    ]
    return min(steady, key=lambda one: float(np.nanmedian(one[0].sigma_px)), default=None)


def _beside(frames: Floats, follower: Follower, toward: int) -> tuple[Beside, Line]:
    """Tell the part of the pictures beside a body, and the line on which it moves."""
    body, places = follower.body, np.array(follower.x_px)
    edge = body.right_edge_px if toward > 0 else body.left_edge_px
    height, width = body.sprite.shape
    middle = (
        float(np.nanmedian(places)) + width / 2,
        float(np.nanmedian(follower.y_px)) + height / 2,
    )
    return Beside(edges_by_frame(frames, places + edge), toward), Line(*middle, follower.slope)


def _follow(
    view: View, follower: Follower, backdrop: Backdrop, upright: bool, progress: Progress
) -> None:
    """Stream the footage once more."""
    progress.start(view.footage.info.frames_promised, "tracking")
    for frame in view.footage.frames(view.start, view.end):
        if not frame.repeats_previous:
            luma = view.of(frame).luma
            picture = np.ascontiguousarray(luma.T) if upright else luma
            follower.see(frame.index, backdrop.silhouette(frame.index, picture))
        if frame.index % PROGRESS_STEP == PROGRESS_STEP - 1:
            progress.advance(PROGRESS_STEP)

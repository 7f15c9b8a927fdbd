"""From two bodies that were followed to a track: which is the ball, and where each was."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from count_video.errors import TrackingError
from count_video.records import BodyTrack, Floats, MotionLine, Track, WallSide
from count_video.tracking.certainty import stated_sigmas
from count_video.tracking.follow import Follower
from count_video.tracking.moving.pairing import (
    FRAMES_AT_LEAST,
    UNSURE_FACTOR,
    unseen_warning,
    was_followed,
)
from count_video.tracking.pairs.bodies import Bodies
from count_video.tracking.roles import wall_side
from count_video.tracking.view import View


@dataclass(frozen=True)
class _Placed:
    """One body, in px of the picture along the line of motion; arrays have shape (n,)."""

    x_px: Floats
    """Where its look begins; NaN where it was not seen."""
    sigma_px: Floats
    left_px: float
    """From where its look begins to the body's left edge."""
    right_px: float
    """And to its right edge."""
    follower: Follower

    def track(self, place_px: float) -> BodyTrack:
        """Tell where a place of the body was, given from where its look begins."""
        return BodyTrack(
            self.x_px + place_px, self.sigma_px, self.left_px - place_px, self.right_px - place_px
        )


def track_of(
    bodies: Bodies,
    frames: Floats,
    followers: tuple[Follower, Follower],
    view_and_side: tuple[View, WallSide | None],
) -> Track:
    """Make the track of two bodies that were followed.

    Parameters
    ----------
    bodies
        What was followed, the one on the left (or above) first.
    frames
        Indices of the pictures in which they were looked for, shape (n,).
    followers
        What was seen of each.
    view_and_side
        The view they were looked for in, and where the wall is; None to tell it by the motion.

    Raises
    ------
    TrackingError
        If there are too few pictures, or a body was lost.
    """
    if len(frames) < FRAMES_AT_LEAST:
        raise TrackingError(f"only {len(frames)} different pictures: too few to show collisions")
    view, told = view_and_side
    left, right = _placed(bodies, frames, followers, view)
    if not (was_followed(left.x_px) and was_followed(right.x_px)):
        raise TrackingError("the bodies cannot be followed through the clip: they are lost")
    found = told or wall_side(left.x_px + left.left_px, right.x_px + right.right_px)
    side: WallSide = found or "left"
    ball, heavy = (left, right) if side == "left" else (right, left)
    return Track(
        frame=frames,
        ball=ball.track((ball.left_px + ball.right_px) / 2),
        heavy=heavy.track(heavy.left_px if side == "left" else heavy.right_px),
        wall_side=side,
        ball_diameter_px=ball.right_px - ball.left_px,
        line=_line(bodies, ball.follower, view),
        warnings=(*unseen_warning("ball", ball.x_px), *unseen_warning("cylinder", heavy.x_px)),
        wall_seen=found is not None,
    )


def _placed(
    bodies: Bodies, frames: Floats, followers: tuple[Follower, Follower], view: View
) -> list[_Placed]:
    x_px = [view.in_picture(_sure_places(f), upright=bodies.upright) for f in followers]
    sigma_px = stated_sigmas(frames, x_px, [view.factor * np.array(f.sigma_px) for f in followers])
    edges = [
        (view.factor * body.left_edge_px, view.factor * body.right_edge_px)
        for body in (bodies.left, bodies.right)
    ]
    return [
        _Placed(x, sigma, *edge, follower)
        for x, sigma, edge, follower in zip(x_px, sigma_px, edges, followers, strict=True)
    ]


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

"""From bodies that were followed to a track: which is the ball, and where each was.

Only the ball bounces off the wall: on the side away from its neighbour it reverses with a jump of
its velocity. The heavy body reverses on its far side too, when it swings back, but smoothly.
"""

from __future__ import annotations

import numpy as np

from count_video.errors import TrackingError
from count_video.records import BodyTrack, Floats, MotionLine, Track, WallSide
from count_video.signals import low_points, noise_px
from count_video.tracking.bodies import Movers
from count_video.tracking.following import FRAMES_AT_LEAST, Followed, was_followed
from count_video.tracking.view import View

REVERSAL_SIGMAS = 8.0
REVERSAL_AT_LEAST_PX = 0.4
SPAN_FRAMES = 3
"""The jump is read between the mean velocities over so many frames on either side."""


def pair_track(
    pair: tuple[Followed, Followed],
    movers: Movers,
    frames: Floats,
    view_and_side: tuple[View, WallSide | None],
) -> Track:
    """Make the track of two bodies, the one on the left (or above) first.

    Parameters
    ----------
    pair
        Where both were seen.
    movers
        What they belong to.
    frames
        Indices of the pictures in which they were searched for, shape (n,).
    view_and_side
        The view they were searched for in, and where the wall is; None to find it by the motion.

    Raises
    ------
    TrackingError
        If there are too few pictures, or a body was lost.
    """
    if len(frames) < FRAMES_AT_LEAST:
        raise TrackingError(f"only {len(frames)} different pictures: too few to show collisions")
    view, given = view_and_side
    places = [view.in_picture(seen.sure_x_px, upright=movers.upright) for seen in pair]
    if not all(was_followed(x_px) for x_px in places):
        raise TrackingError("the bodies cannot be followed through the clip: they are lost")
    sigmas = [view.factor * seen.sigma_px for seen in pair]
    edges = [
        (view.factor * seen.body.left_edge_px, view.factor * seen.body.right_edge_px)
        for seen in pair
    ]
    found = wall_side(places[0] + edges[0][0], places[1] + edges[1][1])
    side: WallSide = given or found or "left"
    ball, heavy = (0, 1) if side == "left" else (1, 0)
    face = edges[heavy][0] if side == "left" else edges[heavy][1]
    return Track(
        frame=frames,
        ball=_about(places[ball], sigmas[ball], edges[ball], sum(edges[ball]) / 2),
        heavy=_about(places[heavy], sigmas[heavy], edges[heavy], face),
        wall_side=side,
        ball_diameter_px=edges[ball][1] - edges[ball][0],
        line=_line(pair[ball], movers, view),
        warnings=(
            *unseen_warning("ball", places[ball]),
            *unseen_warning("cylinder", places[heavy]),
            *contradiction(given, found),
        ),
        shift_px=camera_shift(movers, view),
        wall_seen=bool(given or found),
    )


def camera_shift(movers: Movers, view: View) -> Floats | None:
    """How far the camera moved each picture, shape (n, 2), in px of the footage; None if not."""
    if movers.motion is None:
        return None
    # Where the shift is unknown no body has a place either.
    return np.asarray(view.factor * np.nan_to_num(movers.motion.shift_px), dtype=np.float64)


def _about(x_px: Floats, sigma_px: Floats, edges: tuple[float, float], place: float) -> BodyTrack:
    """Track of a place of a body, given as the edges are from where its template begins."""
    return BodyTrack(x_px + place, sigma_px, edges[0] - place, edges[1] - place)


def _line(ball: Followed, movers: Movers, view: View) -> MotionLine:
    """Line of motion through the middle of the ball's places."""
    left, top, right, bottom = ball.body.box
    along = view.in_picture(ball.x_px + (left + right) / 2, upright=movers.upright)
    across = view.in_picture(ball.y_px + (top + bottom) / 2, upright=not movers.upright)
    x, y = float(np.nanmedian(along)), float(np.nanmedian(across))
    if movers.upright:
        x, y = y, x
    return MotionLine(x, y, movers.tilt_deg, movers.upright)


def unseen_warning(name: str, x_px: Floats) -> list[str]:
    """Say in how many frames a body is not seen, if there are any."""
    unseen = int(np.isnan(x_px).sum())
    return [f"the {name} is not seen in {unseen} of {len(x_px)} frames"] if unseen else []


def contradiction(given: WallSide | None, found: WallSide | None) -> list[str]:
    """Say so if the ball bounces on another side than that on which the wall is said to stand."""
    if given is None or found is None or given == found:
        return []
    return [f"a body turns with jumps on the {found}, where no wall is said to be: check --wall"]


def wall_side(left_px: Floats, right_px: Floats) -> WallSide | None:
    """Find the side of the wall from the places of the left and the right body.

    Parameters
    ----------
    left_px, right_px
        Shape (n,), image position per frame, NaN where not seen.

    Returns
    -------
    str or None
        ``left`` if the left body is the ball; None if neither bounces on its far side.
    """
    left, right = far_side_jump(left_px), far_side_jump(-right_px)
    if left == right == 0.0:
        return None
    return "left" if left > right else "right"


def far_side_jump(distance_px: Floats) -> float:
    """Sum of the velocity jumps, in px per frame, at the low points of a distance."""
    depth = max(REVERSAL_AT_LEAST_PX, REVERSAL_SIGMAS * noise_px(distance_px))
    total = 0.0
    for place in low_points(distance_px, depth):
        before, after = place - SPAN_FRAMES, place + SPAN_FRAMES
        if before < 0 or after >= len(distance_px):
            continue
        jump = distance_px[after] - 2 * distance_px[place] + distance_px[before]
        total += float(np.nan_to_num(jump)) / SPAN_FRAMES
    return total

"""A ball alone that a heavy body strikes which is not seen.

Whatever makes the ball's velocity jump away from the wall is the heavy body. Where the ball is then
is its face, and of its momentum it gives what the ball takes: so the ball's path alone shows the
law of both, and the fit of the whole burst says whether it is that of a trial.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from count_video.motion.beginnings import struck_at_rest
from count_video.motion.burst import CLEAR_VELOCITY_SIGMAS
from count_video.motion.contacts import Kind, fit_contacts
from count_video.motion.flight import motion_of
from count_video.motion.gaps import CLEAR_SIGMAS
from count_video.motion.impacts import at_stop, find_turns, weigh_turns
from count_video.motion.priors import NO_BOUNCE
from count_video.motion.seen import SeenCollisions, marked
from count_video.motion.time_base import frames_per_picture, in_frames, in_pictures
from count_video.reasons import Cause, Reason
from count_video.records import BodyTrack, Collision, Floats, Track, WallSide
from count_video.signals import NOISE_AT_LEAST_PX


def struck_ball(track: Track) -> tuple[Track, SeenCollisions] | None:
    """Take a body alone for the ball of a trial, if something strikes it at rest.

    The wall stands where the blow sends it. Returns the track of two bodies, of which the heavy one
    is not seen, and the collisions that the ball shows; None if nothing strikes it.
    """
    pace = frames_per_picture(track)
    slow = in_pictures(track, pace)
    for sign in (1, -1):
        away_px = sign * slow.ball.position_px
        points = _contacts(slow.frame, away_px)
        if points is not None:
            break
    else:
        return None
    fitted = fit_contacts(slow.frame, [away_px], points, sign=sign)
    collisions = marked(fitted.collisions, slow.frame[np.isfinite(away_px)])
    shown = SeenCollisions(
        collisions=tuple(in_frames(one, pace) for one in collisions),
        burst=_burst(collisions, sign),
        shortcomings=(Reason(Cause.STRUCK, (pace * collisions[0].frame,)),),
        errors=(*fitted.errors, None),
    )
    return with_unseen_heavy(track, "left" if sign > 0 else "right"), shown


def with_unseen_heavy(track: Track, wall_side: WallSide) -> Track:
    """Add a heavy body that no frame shows to the track of a ball, and say where the wall is."""
    unseen = np.full(len(track.frame), np.nan)
    return replace(track, heavy=BodyTrack(unseen, unseen, 0.0, 0.0), wall_side=wall_side)


def _contacts(frame: Floats, away_px: Floats) -> list[tuple[float, Kind]] | None:
    """Find the contacts of a ball, by its places away from the wall; None if none is a first blow.

    At the wall all of its turns are at one place. Between sure contacts a turn is one unless it is
    clearly smooth.
    """
    motion = motion_of(frame, away_px, NOISE_AT_LEAST_PX)
    weighed, contact = weigh_turns(find_turns(motion, CLEAR_SIGMAS), motion, ())
    wall = [turn for turn in at_stop(weighed, -1, motion) if turn.log_odds >= NO_BOUNCE]
    bodies = [turn for turn in weighed if turn.side > 0 and turn.log_odds >= NO_BOUNCE]
    sure = [turn.frame for turn in wall if turn.likely]
    sure += [turn.frame for turn in bodies if turn.log_odds > 0]
    if not sure:
        return None
    blow = struck_at_rest(motion_of(frame, away_px), min(sure) - contact)
    if blow is None or blow.velocity > 0:
        return None
    turns: list[tuple[float, Kind]] = [(turn.frame, "wall") for turn in wall]
    turns += [(turn.frame, "bodies") for turn in bodies]
    inside = [turn for turn in turns if min(sure) <= turn[0] <= max(sure)]
    return [(blow.frame, "bodies"), *sorted(inside)]


def _burst(collisions: Sequence[Collision], sign: int) -> int:
    """Count the collisions before the heavy body, driven back, turns round again.

    Of the ball's velocities u and w, before and after it is struck, the mean lies between those of
    the heavy body, U and W: (u + w) / 2 = (U + W) / 2 for perfect elasticity. So the heavy body
    moves the way that the mean shows, away from the wall and later back to it. It turns midway.
    """
    leaves = np.inf
    for one in collisions:
        before, after = one.velocity_before, one.velocity_after
        mean = sign * (before.ball_px_frame + after.ball_px_frame) / 2
        sigma = np.hypot(before.ball_sigma_px_frame, after.ball_sigma_px_frame) / 2
        if one.kind == "bodies" and abs(mean) > CLEAR_VELOCITY_SIGMAS * sigma:
            if mean < 0 and np.isfinite(leaves):
                turn = (leaves + one.frame) / 2
                return sum(collision.frame < turn for collision in collisions)
            leaves = one.frame if mean > 0 else np.inf
    return len(collisions)

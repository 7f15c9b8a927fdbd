"""Impacts of one body alone, or of two without a wall.

Two bodies collide where the gap between them closes and opens by a jump.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from count_video.motion.contacts import Paths, collisions_of, fit_contacts
from count_video.motion.corners import weigh
from count_video.motion.errors_of_places import HALF_EXPOSURE
from count_video.motion.flight import motion_of
from count_video.motion.impacts import find_impacts, find_turns, usual_flight
from count_video.motion.priors import TURN_LOG_RATIO
from count_video.motion.seen import shows_motion
from count_video.motion.time_base import frames_per_picture, in_frames, in_pictures
from count_video.motion.weighing import SeenImpacts, until_rest, weighed
from count_video.reasons import Cause, Reason
from count_video.records import BodyTrack, Collision, Floats, Track


def seen_impacts(track: Track) -> SeenImpacts:
    """Find the impacts of one body alone (kind ``wall``), or of two on each other (``bodies``)."""
    if not shows_motion(track):
        return SeenImpacts((), (Reason(Cause.NO_IMPACT),), (), {})
    pace = frames_per_picture(track)
    slow = in_pictures(track, pace)
    if slow.heavy is not None:
        return seen_meetings(slow, slow.heavy, pace)
    motion = motion_of(slow.frame, slow.ball.position_px)
    found = find_impacts(motion)
    impacts = until_rest(found.impacts)
    found = replace(found, impacts=impacts)
    fitted = fit_contacts(
        Paths(slow.frame, slow.ball.position_px, None),
        ["wall" if impact.side < 0 else "far" for impact in impacts],
        [impact.frame for impact in impacts],
        found.contact,
    )
    collisions = [in_frames(collision, pace) for collision in collisions_of(fitted)]
    return replace(weighed(motion, found, pace, collisions), errors=fitted.errors)


SAME_CONTACT_PICTURES = 2.5
CLEAR_LOG_ODDS = 5.0
"""Of an impact of one body on something else than the other: what noise does not make."""
END_PICTURES = 3
LENGTH_FACTOR = 1.35
MASS_FACTOR = 1.6
"""Two bodies are of a kind if neither is longer, or heavier, than the other by such a factor."""
PARTED_SHARE = 0.3
"""At one end of the clip two bodies are at least this share as far apart as at the other."""
TOUCH_SHARE = 0.3
"""Two bodies touch where their outlines are this near, as a share of the smaller one's size."""


def seen_meetings(track: Track, heavy: BodyTrack, pace: float) -> SeenImpacts:
    """Find the impacts of two bodies on each other; neither may meet anything else.

    ``track`` counts in pictures, of which each takes ``pace`` frames; ``heavy`` is its second body.
    """
    gap = heavy.position_px - track.ball.position_px - track.ball.high_edge_px
    motion = motion_of(track.frame, gap)
    found = find_impacts(motion, TOUCH_SHARE * track.ball_diameter_px)
    impacts = found.impacts
    frames = [impact.frame for impact in impacts]
    fitted = fit_contacts(
        Paths(track.frame, track.ball.position_px, heavy.position_px),
        ["bodies"] * len(frames),
        frames,
        found.contact,
    )
    collisions = [in_frames(collision, pace) for collision in collisions_of(fitted)]
    judged = weighed(motion, found, pace, collisions)
    reasons = (
        *judged.shortcomings,
        *_elsewhere(frames, track, heavy),
        *_cut_off(gap),
        *_unlike(collisions, track, heavy),
    )
    shortcomings = reasons if impacts else judged.shortcomings
    return replace(judged, shortcomings=shortcomings, errors=fitted.errors)


def without_wall(track: Track) -> Track:
    """Call the body at smaller positions the ball, as where no wall decides."""
    if track.heavy is None or track.wall_side == "left":
        return replace(track, wall_seen=False)
    left, right = track.heavy, track.ball
    face = right.low_edge_px
    right = BodyTrack(right.position_px + face, right.sigma_px, 0.0, right.high_edge_px - face)
    return replace(track, ball=left, heavy=right, wall_side="left", wall_seen=False)


def only_turns(track: Track, collisions: Sequence[Collision]) -> bool:
    """Whether all that seem to be the ball's collisions with a wall are smooth turns of a swing.

    What no picture shows on either side is no smooth turn.
    """
    motion = motion_of(track.frame, track.ball.position_px)
    turns = find_turns(motion)
    flight = usual_flight(turns, motion)
    ends = [-np.inf, *(collision.frame for collision in collisions), np.inf]
    for before, collision, after in zip(ends[:-2], collisions, ends[2:], strict=True):
        if collision.kind != "wall":
            continue
        near = [t for t in turns if abs(t.frame - collision.frame) < SAME_CONTACT_PICTURES]
        weighed_ = [weigh(motion, t, (before, after), flight, HALF_EXPOSURE) for t in near]
        shown = [corner.log_odds for corner in weighed_ if corner.pictures]
        if not shown or max(shown) > -TURN_LOG_RATIO:
            return False
    return True


def _unlike(collisions: Sequence[Collision], track: Track, heavy: BodyTrack) -> list[Reason]:
    """Say if the two are not of a kind, by their lengths and by how their velocities change.

    Then they are the ball and the heavy body of a trial whose wall is not reached in the clip.
    """
    lengths = [body.high_edge_px - body.low_edge_px for body in (track.ball, heavy)]
    alike = abs(np.log(lengths[0] / lengths[1])) < np.log(LENGTH_FACTOR)
    ratios = [abs(float(np.log(_steps(collision)))) for collision in collisions]
    shown = [ratio for ratio in ratios if np.isfinite(ratio)]
    alike &= not shown or bool(np.median(shown) < np.log(MASS_FACTOR))
    return [] if alike else [Reason(Cause.UNLIKE)]


def _steps(collision: Collision) -> float:
    """Step of the first body's velocity over that of the second's; NaN where not known."""
    before, after = collision.velocity_before, collision.velocity_after
    other = abs(after.heavy_px_frame - before.heavy_px_frame)
    return abs(after.ball_px_frame - before.ball_px_frame) / other if other > 0 else np.nan


def _elsewhere(frames: Sequence[float], track: Track, heavy: BodyTrack) -> list[Reason]:
    """Say if one of two bodies also meets something that is not the other."""
    for body in (track.ball, heavy):
        for impact in find_impacts(motion_of(track.frame, body.position_px)).impacts:
            apart = [abs(impact.frame - frame) > SAME_CONTACT_PICTURES for frame in frames]
            if impact.log_odds > CLEAR_LOG_ODDS and all(apart):
                return [Reason(Cause.MEETS_OTHERS)]
    return []


def _cut_off(gap: Floats) -> list[Reason]:
    """Say if the clip begins or ends when the bodies are near each other: more may lie beyond."""
    parts = gap[:END_PICTURES], gap[-END_PICTURES:]
    if any(np.isnan(part).all() for part in parts):
        return []  # one of them comes into the picture, or leaves it
    ends = [float(np.nanmedian(part)) for part in parts]
    if ends[1] < PARTED_SHARE * ends[0]:
        return [Reason(Cause.ENDS_TOGETHER)]
    if ends[0] < PARTED_SHARE * ends[1]:
        return [Reason(Cause.STARTS_TOGETHER)]
    return []

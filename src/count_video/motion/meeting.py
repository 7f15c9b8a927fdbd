"""Impacts of one body alone, or of two without a wall.

Two bodies collide where the gap between them closes and opens by a jump.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple, replace

import numpy as np

from count_video.motion.beginnings import before_first
from count_video.motion.contacts import BodyErrors, Kind, fit_contacts
from count_video.motion.corners import weigh
from count_video.motion.errors_of_places import HALF_EXPOSURE
from count_video.motion.flight import LAW_SHARE, LAW_SIGMAS, MIDDLE_NOISE_PX, friction_of, motion_of
from count_video.motion.impacts import find_impacts, find_turns, usual_flight
from count_video.motion.priors import TURN_LOG_RATIO
from count_video.motion.seen import RESOLVED_FRAMES, SeenCollisions, shows_motion
from count_video.motion.time_base import frames_per_picture, in_frames, in_pictures
from count_video.motion.time_hypotheses import usual_times
from count_video.motion.weighing import weighed
from count_video.reasons import Cause, Reason
from count_video.records import BodyTrack, Collision, Floats, Track
from count_video.signals import noise_px

SWAYS_SHARE = 0.15
"""What moves by less than this share of its size does not bounce: heads and shoulders of people who
walk rise by some hundredths of a person. Bodies that bounce or swing move by half of it and more.
"""
LENGTH_FACTOR, MASS_FACTOR = 1.35, 1.6
"""Two bodies are of a kind if neither is longer, or heavier, than the other by such a factor."""
CLEAR_LOG_ODDS = 5.0
"""Of an impact of one body on something else than the other: what noise does not make."""
NEAR_SHARE, END_PICTURES = 0.3, 3
"""Two bodies touch where their outlines are this near, as a share of the smaller one's size. They
part as a clip begins if so many pictures there show a gap that is less than this share of what it
grows to before they meet."""


def seen_impacts(track: Track) -> SeenCollisions:
    """Find the impacts of one body alone (kind ``wall``), or of two on each other (``bodies``).

    Of two neither may meet anything else.
    """
    if not shows_motion(track):
        return SeenCollisions((), 0, (Reason(Cause.NO_IMPACT),))
    pace = frames_per_picture(track)
    slow = in_pictures(track, pace)
    ball, heavy = slow.ball, slow.heavy
    if heavy is None:
        motion = motion_of(slow.frame, ball.position_px)
        motion = replace(motion, friction=friction_of(slow.frame, ball.position_px))
        turns, contact = find_impacts(motion)
    else:
        gap_px = heavy.position_px - ball.position_px - ball.high_edge_px
        motion = motion_of(slow.frame, gap_px)
        turns, contact = find_impacts(motion, NEAR_SHARE * track.ball_diameter_px)
    impacts = [turn for turn in turns if turn.likely]
    frames = [impact.frame for impact in impacts]
    kinds: dict[int, Kind] = {-1: "wall" if heavy is None else "bodies", 1: "far"}
    contacts = [(impact.frame, kinds[impact.side]) for impact in impacts]
    places = [body.position_px for body in slow.bodies]
    earlier = before_first(motion, impacts) if impacts else []
    ends = [turn.frame for turn in turns if not turn.likely] + [one.frame for one in earlier]
    # What is held until it is let go obeys no law before, nor what rests at last.
    moves = motion.frame[motion.moving].tolist()
    ends += [*moves[:1], *moves[-1:]]
    fitted = fit_contacts(slow.frame, places, contacts, contact, ends=ends)
    collisions = [in_frames(collision, pace) for collision in fitted.collisions]
    seen = weighed(motion, turns, earlier, contact, pace, collisions)
    # What dies out bounces on where pictures show no flights any more.
    dying = any(doubt.cause is Cause.DIES_OUT for doubt in seen.doubts)
    stray = () if dying else _stray(places, fitted.errors)
    seen = replace(seen, errors=fitted.errors, shortcomings=seen.shortcomings or stray)
    if heavy is None and motion.way_px < SWAYS_SHARE * (ball.high_edge_px - ball.low_edge_px):
        seen = replace(seen, shortcomings=(Reason(Cause.SWAYS), *seen.shortcomings))
    if heavy is None or not frames:
        return seen
    against = _against_two(slow, heavy, frames, collisions)
    return replace(seen, shortcomings=(*seen.shortcomings, *against))


def without_wall(track: Track) -> Track:
    """Call the body at smaller positions the ball, as where no wall decides."""
    if track.heavy is None or track.wall_side == "left":
        return replace(track, wall_seen=False)
    left, right = track.heavy, track.ball
    middle, face = (left.low_edge_px + left.high_edge_px) / 2, right.low_edge_px
    return replace(
        track,
        ball=left.about(middle),
        heavy=right.about(face),
        wall_side="left",
        wall_seen=False,
    )


def only_turns(track: Track, collisions: Sequence[Collision]) -> bool:
    """Whether all that seem to be the ball's collisions with a wall are smooth turns of a swing.

    What no picture shows on either side is no smooth turn.
    """
    base = usual_times(track)
    track, collisions = base.evened(track), [base.timed(one) for one in collisions]
    pace = frames_per_picture(track)
    motion = motion_of(track.frame / pace, track.ball.position_px)
    side = -1 if track.wall_side == "left" else 1
    turns = find_turns(motion)
    flight = usual_flight(turns, motion)
    turns = [turn for turn in turns if turn.side == side]
    collisions = [in_frames(one, 1 / pace) for one in collisions]
    ends = [-np.inf, *(collision.frame for collision in collisions), np.inf]
    for before, collision, after in zip(ends[:-2], collisions, ends[2:], strict=True):
        if collision.kind != "wall":
            continue
        near = [t for t in turns if abs(t.frame - collision.frame) < RESOLVED_FRAMES]
        weighed_ = [weigh(motion, t, (before, after), flight, HALF_EXPOSURE) for t in near]
        shown = [corner.log_odds for corner in weighed_ if corner.pictures]
        if not shown or max(shown) > -TURN_LOG_RATIO:
            return False
    return True


def _stray(places: Sequence[Floats], errors: BodyErrors) -> tuple[Reason, ...]:
    """Say so if free flights between the impacts do not describe where a body was."""
    for place_px, error in zip(places, errors, strict=True):
        noise = max(noise_px(place_px), MIDDLE_NOISE_PX)
        way = float(np.nanmax(place_px) - np.nanmin(place_px))
        allowed = max(LAW_SIGMAS * noise, LAW_SHARE * way)
        if error is not None and error.sigma_px > allowed:
            return (Reason(Cause.MODEL_STRAYS, (error.sigma_px, allowed)),)
    return ()


def _against_two(
    track: Track, heavy: BodyTrack, frames: Sequence[float], collisions: Sequence[Collision]
) -> tuple[Reason, ...]:
    """Say what stands against two bodies that meet each other alone."""
    gap_px = heavy.position_px - track.ball.position_px - track.ball.high_edge_px
    causes = (
        Cause.MEETS_OTHERS if _meet_others(frames, track, heavy) else None,
        _cut_off(track.frame, gap_px, frames),
        # The ball of a trial would reach the wall before the heavy body meets it again.
        Cause.UNLIKE if len(frames) == 1 and _unlike(collisions[0], track, heavy) else None,
    )
    return tuple(Reason(cause) for cause in causes if cause is not None)


def _unlike(collision: Collision, track: Track, heavy: BodyTrack) -> bool:
    """Whether the two are not of a kind, by their lengths and by how their velocities change.

    Then they are the ball and the heavy body of a trial whose wall is not reached in the clip.
    """
    lengths = [body.high_edge_px - body.low_edge_px for body in (track.ball, heavy)]
    before, after = collision.velocity_before, collision.velocity_after
    jumps = np.subtract(astuple(after)[:2], astuple(before)[:2])
    with np.errstate(divide="ignore", invalid="ignore"):
        masses = np.abs(np.log(np.abs(jumps[0] / jumps[1])))
    heavier = np.isfinite(masses) and masses >= np.log(MASS_FACTOR)
    return bool(heavier or abs(np.log(lengths[0] / lengths[1])) >= np.log(LENGTH_FACTOR))


def _meet_others(frames: Sequence[float], track: Track, heavy: BodyTrack) -> bool:
    """Whether one of two bodies also meets something that is not the other."""
    return any(
        impact.log_odds > CLEAR_LOG_ODDS
        and np.abs(impact.frame - np.array(frames)).min() > RESOLVED_FRAMES
        for body in (track.ball, heavy)
        for impact in find_impacts(motion_of(track.frame, body.position_px))[0]
    )


def _cut_off(frames: Floats, gap_px: Floats, impacts: Sequence[float]) -> Cause | None:
    """Say if the bodies part as the clip begins, or near each other as it ends: more lie beyond.

    What happens before the first impact in order of time happens after the last one in the other.
    Where no picture shows the gap one of them comes into the picture, or leaves it.
    """
    before, after = gap_px[frames < min(impacts)], gap_px[frames > max(impacts)][::-1]
    if any(np.isnan(gap[:END_PICTURES]).all() for gap in (before, after)):
        return None
    starts, ends = (
        float(np.nanmedian(gap[:END_PICTURES])) < NEAR_SHARE * float(np.nanmax(gap))
        for gap in (before, after)
    )
    if ends:
        return Cause.ENDS_TOGETHER
    return Cause.STARTS_TOGETHER if starts else None

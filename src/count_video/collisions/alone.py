"""The impacts that a clip of one body shows, or of two without a wall, and what is in doubt."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from count_video.collisions.certainty import chances_of_sum
from count_video.collisions.flight import Motion, flies_freely, motion_of, straying
from count_video.collisions.impacts import FREE_POINTS_AT_LEAST, Impact, find_impacts
from count_video.collisions.onesided import HALF_EXPOSURE, fit_side, side_frames
from count_video.collisions.pace import frames_per_picture, in_frames, in_pictures
from count_video.collisions.resolution import RESOLVED_FRAMES
from count_video.records import BodyTrack, Collision, Floats, Track, Velocities
from count_video.signals import sigma_of

CLEAR_SIGMAS = 10.0
CERTAIN_SIGMAS = 20.0
CERTAIN_PICTURES = 4
"""One impact at least must be as clear as this, and shown by so many pictures on either side."""
CHANCE_CLEAR = 0.995
CHANCE_WEAK = 0.9
CHANCE_HARDLY_SHOWN = 0.6
"""Chances that an impact is one: its jump exceeds its uncertainty by this factor or not, or too
few pictures show the body before or after it."""
CHANCE_SINGLE = 0.8
"""And where it is the only one at its stop, so that nothing else tells where the stop is; two
bodies that touch tell it by their outlines."""
CHANCE_STRAYING = 0.4
"""Chance that a flight which strays from free flight hides one more."""
UNSEEN_SHARE = 0.3
LEAVING_SHARE = 0.2
CHANCE_LEAVING = 0.5
RELEASED_SHARE = 0.7
CHANCE_UNSEEN = 0.3
"""Chances that one lies before the first, where so many of the pictures before do not show the
body: it comes into sight on its way from the stop, or at a good part of its speed at the stop."""
FALLEN_BACK = 1.3
TAIL_PICTURES = 4.0
CHANCES_TAIL = (0.5, 0.25, 0.15)
"""A body that bounces lower and lower goes on to do so below what the pictures show: where its
last flight is shorter than this, these are the chances of one more, and each after it."""
STRAYING_AT_MOST = 0.4
"""Where a larger share of the flights strays, the turns are not those of a body that bounces."""
NO_IMPACT = "no impact is seen: what moves turns round smoothly, if at all, and jumps nowhere"
SAME_CONTACT_PICTURES = 2.5
END_PICTURES = 3
PARTED_SHARE = 0.3
"""At one end of the clip two bodies are at least this share as far apart as at the other."""
TOUCH_SHARE = 0.3
"""Two bodies touch where their outlines are this near, as a share of the smaller one's size."""


@dataclass(frozen=True)
class SeenImpacts:
    """What the frames of one clip show."""

    collisions: tuple[Collision, ...]
    """In order of time, numbered from 1; real times are not filled in."""
    shortcomings: tuple[str, ...]
    """Why the clip supports no count, in words for the user; empty if it does."""
    doubts: tuple[str, ...]
    """What lowers the probability, in words for the user."""
    probability: dict[int, float]
    """Of each count."""


def seen_impacts(track: Track) -> SeenImpacts:
    """Find the impacts of one body alone (kind ``wall``), or of two on each other (``bodies``)."""
    pace = frames_per_picture(track)
    slow = in_pictures(track, pace)
    if slow.heavy is not None:
        return _of_two(slow, slow.heavy, pace)
    motion = motion_of(slow.frame, slow.ball.position_px)
    impacts, contact = find_impacts(motion)
    collisions = [
        in_frames(_collision(number, impact), pace) for number, impact in enumerate(impacts, 1)
    ]
    return _judged(motion, impacts, (contact, pace), collisions)


def _collision(number: int, impact: Impact) -> Collision:
    return Collision(
        number=number,
        kind="wall",
        frame=impact.frame,
        frame_sigma=impact.frame_sigma,
        time_s=None,
        seen=True,
        position_px=impact.place_px,
        velocity_before=Velocities(impact.velocity_before, np.nan),
        velocity_after=Velocities(impact.velocity_after, np.nan),
    )


def _of_two(track: Track, heavy: BodyTrack, pace: float) -> SeenImpacts:
    """Impacts of two bodies on each other; neither may meet anything else."""
    gap = heavy.position_px - track.ball.position_px - track.ball.high_edge_px
    motion = motion_of(track.frame, gap)
    every, contact = find_impacts(motion)
    impacts = [impact for impact in every if _touches(impact, track.ball_diameter_px)]
    frames = [impact.frame for impact in impacts]
    collisions = [
        in_frames(_collision_of_two(number, track, heavy, frames), pace)
        for number in range(1, len(frames) + 1)
    ]
    judged = _judged(motion, impacts, (contact, pace), collisions)
    reasons = (*judged.shortcomings, *_elsewhere(frames, track, heavy), *_cut_off(gap))
    return replace(judged, shortcomings=reasons if impacts else judged.shortcomings)


def _touches(impact: Impact, size_px: float) -> bool:
    return impact.side < 0 and abs(impact.place_px) < TOUCH_SHARE * size_px


def _collision_of_two(
    number: int, track: Track, heavy: BodyTrack, frames: Sequence[float]
) -> Collision:
    ends = [-np.inf, *frames, np.inf]
    frame, limits = ends[number], (ends[number - 1], ends[number + 1])
    sides = [
        [_state(track.frame, body.position_px, frame, limit) for limit in limits]
        for body in (track.ball, heavy)
    ]
    (before, place), (after, _) = sides[0]
    return Collision(
        number=number,
        kind="bodies",
        frame=frame,
        frame_sigma=HALF_EXPOSURE,
        time_s=None,
        seen=True,
        position_px=place,
        velocity_before=Velocities(before, sides[1][0][0]),
        velocity_after=Velocities(after, sides[1][1][0]),
    )


def _state(frame: Floats, places: Floats, about: float, limit: float) -> tuple[float, float]:
    """Velocity and place of one body right before or after a contact; NaN if not shown."""
    chosen = side_frames(frame, places, about, limit)
    side = fit_side(frame[chosen], places[chosen], about, sigma_of(places))
    return (np.nan, np.nan) if side is None else (side.slope, side.value)


def _elsewhere(frames: Sequence[float], track: Track, heavy: BodyTrack) -> list[str]:
    """Say if one of two bodies also meets something that is not the other."""
    for body in (track.ball, heavy):
        for impact in find_impacts(motion_of(track.frame, body.position_px))[0]:
            if all(abs(impact.frame - frame) > SAME_CONTACT_PICTURES for frame in frames):
                return [
                    "one of the two bodies also bounces off something else: show the trial from "
                    "the ball at rest until the heavy body is driven back, or bodies that meet "
                    "nothing but each other"
                ]
    return []


def _cut_off(gap: Floats) -> list[str]:
    """Say if the clip begins or ends when the bodies are near each other: more may lie beyond."""
    parts = gap[:END_PICTURES], gap[-END_PICTURES:]
    if any(np.isnan(part).all() for part in parts):
        return []  # one of them comes into the picture, or leaves it
    ends = [float(np.nanmedian(part)) for part in parts]
    if ends[1] < PARTED_SHARE * ends[0]:
        return ["the clip ends before the bodies have parted; let it run longer"]
    if ends[0] < PARTED_SHARE * ends[1]:
        return ["the clip starts when the bodies are next to each other; start it earlier"]
    return []


def _judged(
    motion: Motion,
    impacts: Sequence[Impact],
    timing: tuple[float, float],
    collisions: Sequence[Collision],
) -> SeenImpacts:
    """Weigh what was found; ``timing`` is half the contact in pictures and the frames a picture."""
    contact, pace = timing
    frames = [impact.frame for impact in impacts]
    strays = straying(motion, frames, contact)
    chances = [
        _chance(impact, impacts, collision.kind)
        for impact, collision in zip(impacts, collisions, strict=True)
    ]
    doubts = []
    if strays:
        spans = ", ".join(f"{a * pace:.0f} to {b * pace:.0f}" for a, b in strays)
        doubts.append(f"the body does not fly freely in frames {spans}")
        chances += [CHANCE_STRAYING] * len(strays)
    if impacts and (unseen := _chance_before(motion, impacts)) > 0:
        doubts.append("what came before the first impact is not seen: one may be missing")
        chances.append(unseen)
    if any(b - a < RESOLVED_FRAMES for a, b in pairwise(frames)) or _in_a_tail(motion, impacts):
        doubts.append(
            "the last impacts follow each other faster than the pictures show: some may be missed"
        )
        chances += CHANCES_TAIL
    shortcomings = _shortcomings(impacts, len(strays))
    return SeenImpacts(
        tuple(collisions), tuple(shortcomings), tuple(doubts), chances_of_sum(chances)
    )


def _shortcomings(impacts: Sequence[Impact], strays: int) -> list[str]:
    if not impacts:
        return [NO_IMPACT]
    if not any(_is_certain(impact) for impact in impacts):
        return ["the few turns that are seen are too faint or too short to tell impacts by"]
    if strays > STRAYING_AT_MOST * max(len(impacts) - 1, 1):
        return [
            "the body's path between its turns is not that of one that bounces: impacts and smooth "
            "turns cannot be told apart"
        ]
    return []


def _is_certain(impact: Impact) -> bool:
    return impact.clarity > CERTAIN_SIGMAS and impact.pictures >= CERTAIN_PICTURES


def _chance(impact: Impact, impacts: Sequence[Impact], kind: str) -> float:
    if impact.clarity == 0:
        return CHANCE_HARDLY_SHOWN
    clear = CHANCE_CLEAR if impact.clarity > CLEAR_SIGMAS else CHANCE_WEAK
    alone = sum(other.side == impact.side for other in impacts) == 1
    return min(clear, CHANCE_SINGLE) if alone and kind == "wall" else clear


def _chance_before(motion: Motion, impacts: Sequence[Impact]) -> float:
    """Chance of an impact before the first one found, by how the body comes into sight."""
    first = impacts[0]
    rows = np.flatnonzero(np.isfinite(motion.place_px) & (motion.frame < first.frame))
    if len(rows) == 0:
        return 0.0
    while len(rows) > FREE_POINTS_AT_LEAST and not flies_freely(motion, rows):
        rows = rows[1:]
    begins = float(motion.frame[rows[0]])
    every = motion.frame < begins
    unseen = np.isnan(motion.place_px[every]).mean() if every.any() else 0.0
    if unseen < UNSEEN_SHARE:
        return 0.0
    speed = first.side * (first.velocity_before - motion.acceleration * (first.frame - begins))
    arrives = first.side * first.velocity_before
    if speed < -LEAVING_SHARE * arrives:
        return CHANCE_LEAVING
    flights = np.diff([impact.frame for impact in impacts])
    longest = float(flights.max()) if len(flights) else RESOLVED_FRAMES
    hidden = begins - float(motion.frame[0]) > longest
    return CHANCE_UNSEEN if hidden and speed > RELEASED_SHARE * arrives else 0.0


def _in_a_tail(motion: Motion, impacts: Sequence[Impact]) -> bool:
    """Whether impacts follow each other faster and faster until pictures no longer show them.

    So it is too where the body must have fallen back to the stop while the clip went on, by the
    velocity with which it left and the usual acceleration, and no impact was found.
    """
    if len(impacts) < 2:
        return False
    last = impacts[-1]
    if last.frame - impacts[-2].frame < TAIL_PICTURES:
        return True
    pull = last.side * motion.acceleration
    if pull <= 0 or not np.isfinite(last.velocity_after):
        return False
    back = -2 * last.side * last.velocity_after / pull
    return bool(last.frame + FALLEN_BACK * back < motion.frame[-1])

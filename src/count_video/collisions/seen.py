"""The collisions that the frames show: sign changes of a relative velocity, at a contact."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from count_video.collisions.burst import Rival, find_burst
from count_video.collisions.candidates import Candidate, find_candidates, sharpen
from count_video.collisions.contact import (
    is_contact,
    learn_contacts,
    never_touch,
    sharp_ones,
    touch_is_shown,
)
from count_video.collisions.gaps import Gaps, gaps_of
from count_video.collisions.onesided import side_of
from count_video.collisions.pace import (
    frames_per_picture,
    in_frames,
    in_pictures,
    swing_in_frames,
)
from count_video.collisions.resolution import shortest_interval, unexplained, unresolved
from count_video.collisions.swing import Swing, borne_out, fit_path, swing_of
from count_video.collisions.timing import with_true_sigmas
from count_video.records import Collision, Floats, Track, Velocities

NEVER_TOUCH = "the two bodies that move never touch: where they turn back, a gap stays between them"
STRAYS = (
    "the cylinder does not move as its swing and these collisions would have it: some were missed, "
    "or something else was taken for a body"
)
FEW_TO_BELIEVE = 2
"""Outlines can be learnt wrongly: against more collisions than this in a row they have no say."""


@dataclass(frozen=True)
class SeenCollisions:
    """What the frames of one clip show."""

    collisions: tuple[Collision, ...]
    """In order of time, numbered from 1; real times are not filled in."""
    burst: int
    """How many of them belong to the first burst."""
    rival: Rival | None
    """How many may belong to it just as well; None where that is clear."""
    shortcomings: tuple[str, ...]
    """Why the clip does not show the whole burst; empty if it does."""
    doubts: tuple[str, ...]
    """Why collisions may be missing between the frames; empty if all are resolved."""
    shortest_interval_frames: float
    """Between neighbours of the first burst; inf for fewer than two."""
    swing: Swing | None
    """The heavy body's path; None where the frames do not show all velocity steps."""
    outlines_apart_px: float
    """Gap between the outlines of ball and heavy body where these touch: about 0 where both were
    learnt rightly; NaN where no collision shows it."""
    borne_out: bool
    """Whether the heavy body's whole path follows from its swing and the collisions: then both
    bodies were followed rightly."""


def seen_collisions(track: Track, pace: float | None = None) -> SeenCollisions:
    """Find the collisions that a track of both bodies shows.

    ``pace`` is the number of frames from one picture to the next where the pictures are closest;
    if it is not given, the usual number.
    """
    pace = frames_per_picture(track) if pace is None else pace
    gaps = gaps_of(in_pictures(track, pace))
    found, elsewhere = _corroborated(gaps, track.ball_diameter_px)
    collisions = _collisions(with_true_sigmas(found, gaps), gaps)
    path = fit_path(gaps, collisions)
    right = borne_out(path, gaps)
    burst = find_burst(found, gaps, swing_of(path))
    inside = found[: burst.count]
    shortcomings = burst.shortcomings
    few = len(inside) <= FEW_TO_BELIEVE
    contacts = learn_contacts(inside, gaps)
    if few and never_touch(contacts, track.ball_diameter_px):
        shortcomings = (NEVER_TOUCH, *shortcomings)
    doubts = (*unresolved(inside, gaps, pace), *unexplained(elsewhere, inside, burst, pace))
    if right is False and not doubts:
        shortcomings = (*shortcomings, STRAYS)
    return SeenCollisions(
        collisions=tuple(in_frames(collision, pace) for collision in collisions),
        burst=burst.count,
        rival=burst.rival,
        shortcomings=shortcomings,
        doubts=doubts,
        shortest_interval_frames=shortest_interval(inside) * pace,
        swing=swing_in_frames(swing_of(fit_path(gaps, collisions[: burst.count])), pace),
        outlines_apart_px=contacts.bodies_gap_px if touch_is_shown(inside) else np.nan,
        borne_out=bool(right),
    )


def _corroborated(gaps: Gaps, ball_diameter_px: float) -> tuple[list[Candidate], list[Candidate]]:
    """Candidates with a jump of the velocity and a contact, their times sharpened.

    Also those that jump where there is no contact.
    """
    sharp = sharp_ones(sharpen(find_candidates(gaps), gaps), gaps)
    contacts = learn_contacts(sharp, gaps)
    touching = [is_contact(c, gaps, contacts, ball_diameter_px) for c in sharp]
    found = [c for c, touches in zip(sharp, touching, strict=True) if touches]
    elsewhere = [c for c, touches in zip(sharp, touching, strict=True) if not touches]
    found = sharpen(found, gaps, learn_contacts(found, gaps))
    return sorted(found, key=lambda candidate: candidate.frame), elsewhere


def _collisions(found: Sequence[Candidate], gaps: Gaps) -> list[Collision]:
    frames = [-np.inf, *(candidate.frame for candidate in found), np.inf]
    collisions = []
    for place, candidate in enumerate(found):
        limits = (frames[place], frames[place + 2])
        ball = _rates(gaps, gaps.ball_px, candidate.frame, limits)
        heavy = _rates(gaps, gaps.heavy_px, candidate.frame, limits)
        collisions.append(
            Collision(
                number=place + 1,
                kind=candidate.kind,
                frame=candidate.frame,
                frame_sigma=candidate.frame_sigma,
                time_s=None,
                seen=True,
                position_px=gaps.sign * _value(gaps, candidate.frame, limits),
                velocity_before=Velocities(gaps.sign * ball[0], gaps.sign * heavy[0]),
                velocity_after=Velocities(gaps.sign * ball[1], gaps.sign * heavy[1]),
            )
        )
    return collisions


def _rates(
    gaps: Gaps, signal: Floats, frame: float, limits: tuple[float, float]
) -> tuple[float, float]:
    """Velocity right before and right after a collision, by one-sided fits; NaN if not shown."""
    rates = []
    for limit in limits:
        side = side_of(gaps.frame, signal, frame, limit)
        rates.append(float("nan") if side is None else side.slope)
    return rates[0], rates[1]


def _value(gaps: Gaps, frame: float, limits: tuple[float, float]) -> float:
    """Distance of the ball at a collision: the mean of both sides, as far as shown."""
    values = []
    for limit in limits:
        side = side_of(gaps.frame, gaps.ball_px, frame, limit)
        if side is not None:
            values.append(side.value)
    if values:
        return float(np.mean(values))
    seen = np.isfinite(gaps.ball_px)
    return float(np.interp(frame, gaps.frame[seen], gaps.ball_px[seen]))

"""The collisions that the frames show: sign changes of a relative velocity, at a contact."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from count_video.motion.burst import find_burst
from count_video.motion.contacts import BodyErrors
from count_video.motion.errors_of_places import Errors
from count_video.motion.gaps import UNSEEN_FRAMES, Gaps, find_contacts, gaps_of, turns_alone
from count_video.motion.swing import Swing, fit_swing
from count_video.motion.time_base import frames_per_picture, in_frames, in_pictures
from count_video.reasons import LEFT_TO_THE_FIT, Cause, Reason
from count_video.records import BodyTrack, Collision, Floats, Track
from count_video.signals import sigma_of

FEW_TO_BELIEVE = 2
"""Outlines can be learnt wrongly: against more collisions than this in a row they have no say. If
they were wrong by more than all that they cover, the fit of the whole burst has to confirm these.
"""
SHOWN_SHARE = 0.25
"""The frames show a collision if they give its time to this share of the way to its neighbours: of
those that are closer they show a zigzag whose corners lie where the frames are."""
RESOLVED_FRAMES = 2.5
"""From this interval on every flight of the ball holds at least one frame clear of corners."""
APART_SHARE = 0.5
"""Bodies whose outlines stay this share of the ball's diameter apart do not touch: a camera that
sees them obliquely shows a gap at contact, but one small beside the ball."""


@dataclass(frozen=True)
class SeenCollisions:
    """What the frames of one clip show."""

    collisions: tuple[Collision, ...]
    """In order of time."""
    burst: int
    """How many of them belong to the first burst; all where no wall makes one."""
    shortcomings: tuple[Reason, ...] = ()
    """Why the clip does not show the whole burst, or supports no count; empty if it does."""
    doubts: tuple[Reason, ...] = ()
    """Why a fit of the whole burst has to confirm what is seen, or what lowers the probability."""
    swing: Swing | None = None
    """The heavy body's path; None where the frames do not show all velocity steps."""
    outlines_apart_px: float = np.nan
    """Gap between the outlines of ball and heavy body where these touch: about 0 where both were
    learnt rightly; NaN where no collision shows it."""
    errors: BodyErrors = (None, None)
    """Of the places of ball and heavy body."""
    probability: dict[int, float] = field(default_factory=dict)
    """Of each count, where impacts are weighed one by one; no burst is fitted then."""

    @property
    def path_fits(self) -> bool:
        """Whether the heavy body's path follows from its swing and the collisions of the burst.

        Then both bodies were followed rightly.
        """
        return self.swing is not None and self.swing.fits

    @property
    def is_whole(self) -> bool:
        """Whether the frames show the whole burst, and nothing is in doubt."""
        return not self.shortcomings and not self.doubts

    @property
    def fit_may_settle(self) -> bool:
        """Whether the fit of the whole burst may settle whatever stands against a count."""
        return all(shortcoming.cause in LEFT_TO_THE_FIT for shortcoming in self.shortcomings)

    @property
    def shown(self) -> int:
        """How many of the burst the frames show; the others follow from alternation alone."""
        return sum(collision.seen for collision in self.collisions[: self.burst])


def shows_motion(track: Track) -> bool:
    """Whether each body is seen in two frames at least, and the frames follow each other."""
    seen = min(int(np.isfinite(body.position_px).sum()) for body in track.bodies)
    return seen > 1 and bool(np.all(np.diff(track.frame) > 0))


def with_errors(track: Track, errors: BodyErrors) -> Track:
    """Enlarge the uncertainties of places until they cover how these scatter about the flights.

    The registration takes the noise of a picture for white; encoders move whole blocks by quarters
    of a pixel, which is like motion in every single picture. The law of motion reveals it. To the
    variance of every place of a body the same is added, never less than nothing. ``errors`` are
    those of the ball, then of the heavy body; where none are known, third differences do.
    """
    of_ball, of_heavy, *_ = (*errors, None, None)
    heavy = None if track.heavy is None else _with_error(track.heavy, of_heavy)
    return replace(track, ball=_with_error(track.ball, of_ball), heavy=heavy)


def _with_error(body: BodyTrack, error: Errors | None) -> BodyTrack:
    sigma_px = error.sigma_px if error else sigma_of(body.position_px)
    seen = np.isfinite(body.sigma_px)
    hidden = sigma_px**2 - float(np.mean(body.sigma_px[seen] ** 2)) if seen.any() else 0.0
    return replace(body, sigma_px=np.sqrt(body.sigma_px**2 + max(hidden, 0.0)))


def seen_collisions(track: Track, pace: float | None = None) -> SeenCollisions:
    """Find the collisions that a track of both bodies shows.

    ``pace`` is the number of frames from one picture to the next where the pictures are closest;
    if it is not given, the usual number.
    """
    pace = frames_per_picture(track) if pace is None else pace
    gaps = gaps_of(in_pictures(track, pace))
    contacts = find_contacts(gaps)
    collisions = marked(contacts.collisions, gaps.frame[np.isfinite(gaps.ball_px)])
    burst, shortcomings = find_burst(collisions, gaps)
    inside = collisions[:burst]
    in_clip = tuple(in_frames(collision, pace) for collision in collisions)
    swing = fit_swing(gaps_of(track), in_clip[:burst])
    doubts, not_reached = _without_turns(unresolved(inside, pace), gaps, pace)
    shortcomings = (*not_reached, *shortcomings)
    apart = contacts.distance_px - gaps.near_edge_px
    if len(inside) <= FEW_TO_BELIEVE and apart > APART_SHARE * track.ball_diameter_px:
        shortcomings = (Reason(Cause.NEVER_TOUCH), *shortcomings)
    elif apart > sum(body.high_edge_px - body.low_edge_px for body in track.bodies):
        doubts = (Reason(Cause.NEVER_TOUCH), *doubts)
    if swing and not swing.fits and not doubts:
        shortcomings = (*shortcomings, Reason(Cause.STRAYS))
    return SeenCollisions(
        collisions=in_clip,
        burst=burst,
        shortcomings=shortcomings,
        doubts=doubts,
        swing=swing if swing and swing.mass_ratio > 0 else None,
        outlines_apart_px=apart,
        errors=contacts.errors,
    )


def unresolved(candidates: Sequence[Collision], pace: float) -> list[Reason]:
    """Say which collisions may be missing; empty if the pictures show them all.

    Neighbours must be of different kinds, and far enough apart for the pictures to show each.
    Collisions count in pictures, of which each takes ``pace`` frames.
    """
    found = []
    for before, after in pairwise(candidates):
        if before.kind == after.kind:
            cause = Cause.BODY_MISSED if before.kind == "wall" else Cause.WALL_MISSED
            found.append(Reason(cause, (before.frame * pace, after.frame * pace)))
    shortest = min((b.frame - a.frame for a, b in pairwise(candidates)), default=np.inf)
    if shortest < RESOLVED_FRAMES:
        found.append(Reason(Cause.UNRESOLVED, (shortest, RESOLVED_FRAMES)))
    return found


def _without_turns(
    doubts: Sequence[Reason], gaps: Gaps, pace: float
) -> tuple[tuple[Reason, ...], tuple[Reason, ...]]:
    """Take the doubts off in which the ball turned round by itself: it did not reach the wall."""
    turned = [
        doubt
        for doubt in doubts
        if doubt.cause is Cause.WALL_MISSED
        and turns_alone(gaps, (doubt.figures[0] / pace, doubt.figures[1] / pace))
    ]
    left = tuple(doubt for doubt in doubts if doubt not in turned)
    return left, tuple(replace(doubt, cause=Cause.WALL_NOT_REACHED) for doubt in turned)


def marked(collisions: Sequence[Collision], pictures: Floats) -> list[Collision]:
    """Mark which collisions the frames show: surely in time, and with pictures next to them.

    ``pictures`` are the frame coordinates of those that show the ball.
    """
    frames = [collision.frame for collision in collisions]
    nearest = np.minimum(np.diff(frames, prepend=-np.inf), np.diff(frames, append=np.inf))
    ends = np.concatenate([[-np.inf], pictures, [np.inf]])
    after = np.searchsorted(pictures, frames) + 1
    apart = ends[after] - ends[after - 1]
    return [
        replace(one, seen=bool(one.frame_sigma <= SHOWN_SHARE * free and gap <= UNSEEN_FRAMES))
        for one, free, gap in zip(collisions, nearest.tolist(), apart.tolist(), strict=True)
    ]

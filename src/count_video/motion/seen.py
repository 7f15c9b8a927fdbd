"""The collisions that the frames show: sign changes of a relative velocity, at a contact."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from count_video.motion.burst import find_burst
from count_video.motion.contacts import BodyErrors, Contacts, Paths, collisions_of, fit_contacts
from count_video.motion.errors_of_places import HALF_EXPOSURE, Errors, flight_of
from count_video.motion.flight import motion_of
from count_video.motion.gaps import Gaps, gaps_of
from count_video.motion.impacts import find_impacts
from count_video.motion.priors import NO_BOUNCE
from count_video.motion.resolution import unresolved
from count_video.motion.swing import Swing, fit_path, path_fits, swing_of
from count_video.motion.time_base import (
    frames_per_picture,
    in_frames,
    in_pictures,
    swing_in_frames,
)
from count_video.reasons import Cause, Reason
from count_video.records import BodyTrack, Collision, CollisionKind, Floats, Track
from count_video.signals import NOISE_AT_LEAST_PX, sigma_of

FEW_TO_BELIEVE = 2
"""Outlines can be learnt wrongly: against more collisions than this in a row they have no say. If
they were wrong by more than all that they cover, the fit of the whole burst has to confirm these.
"""
SHOWN_SHARE = 0.25
"""The frames show a collision if they give its time to this share of the way to its neighbours: of
those that are closer they show a zigzag whose corners lie where the frames are."""
APART_SHARE = 0.5
"""Bodies whose outlines stay this share of the ball's diameter apart do not touch: a camera that
sees them obliquely shows a gap at contact, but one small beside the ball."""


@dataclass(frozen=True)
class SeenCollisions:
    """What the frames of one clip show."""

    collisions: tuple[Collision, ...]
    """In order of time, numbered from 1; real times are not filled in."""
    burst: int
    """How many of them belong to the first burst."""
    shortcomings: tuple[Reason, ...]
    """Why the clip does not show the whole burst; empty if it does."""
    doubts: tuple[Reason, ...]
    """Why the fit of the whole burst has to confirm what is seen; empty if all is resolved."""
    swing: Swing | None
    """The heavy body's path; None where the frames do not show all velocity steps."""
    outlines_apart_px: float
    """Gap between the outlines of ball and heavy body where these touch: about 0 where both were
    learnt rightly; NaN where no collision shows it."""
    path_fits: bool
    """Whether the heavy body's whole path follows from its swing and the collisions: then both
    bodies were followed rightly."""
    errors: BodyErrors
    """Of the places of ball and heavy body."""

    @property
    def is_whole(self) -> bool:
        """Whether the frames show the whole burst, and nothing is in doubt."""
        return not self.shortcomings and not self.doubts

    @property
    def shown(self) -> int:
        """How many of the burst the frames show; the others follow from alternation alone."""
        return sum(collision.seen for collision in self.collisions[: self.burst])


NOTHING_SEEN = SeenCollisions((), 0, (), (), None, np.nan, False, (None, None))
"""Of a track that shows no motion of two bodies."""


def shows_motion(track: Track) -> bool:
    """Whether each body is seen in two frames at least, and the frames follow each other."""
    bodies = [track.ball] if track.heavy is None else [track.ball, track.heavy]
    seen = min(int(np.isfinite(body.position_px).sum()) for body in bodies)
    return seen > 1 and bool(np.all(np.diff(track.frame) > 0))


def with_errors(track: Track, errors: BodyErrors) -> Track:
    """Enlarge the uncertainties of places until they cover how these scatter about the flights.

    The registration takes the noise of a picture for white. Encoders leave errors that neighbouring
    pixels share and that last for many frames: whole blocks are moved by quarters of a pixel, or
    stay where they were until it is worth the bits to move them. Such an error is like motion in
    every single picture; the law of motion reveals it. To the variance of every place of a body the
    same is added, never less than nothing. ``errors`` are those of the ball, then of the heavy
    body; where none are known, third differences do.
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
    collisions = _shown(collisions_of(contacts, gaps.sign), gaps)
    path = fit_path(gaps, collisions)
    right = path_fits(path, gaps)
    burst = find_burst(collisions, contacts, gaps)
    inside = collisions[: burst.count]
    shortcomings, doubts = burst.shortcomings, tuple(unresolved(inside, pace))
    apart = contacts.distance_px - gaps.near_edge_px
    if len(inside) <= FEW_TO_BELIEVE and apart > APART_SHARE * track.ball_diameter_px:
        shortcomings = (Reason(Cause.NEVER_TOUCH), *shortcomings)
    elif apart > _lengths_px(track):
        doubts = (Reason(Cause.NEVER_TOUCH), *doubts)
    if right is False and not doubts:
        shortcomings = (*shortcomings, Reason(Cause.STRAYS))
    return SeenCollisions(
        collisions=tuple(in_frames(collision, pace) for collision in collisions),
        burst=burst.count,
        shortcomings=shortcomings,
        doubts=doubts,
        swing=swing_in_frames(swing_of(fit_path(gaps, inside)), pace),
        outlines_apart_px=apart,
        path_fits=bool(right),
        errors=contacts.errors,
    )


KINDS: tuple[CollisionKind, CollisionKind] = ("bodies", "wall")
CORNER_ROWS, CORNERS_TRIED = 10, 400
"""Rows that show a corner at least, and about how many of them are tried at most."""
UNSEEN_FRAMES = 3.0
"""What happens between pictures that are farther apart is not shown."""
CLEAR_SIGMAS = 6.0
"""A turn is as deep as so many standard deviations of a place, or, where it is shallower, a corner
as clear: of 10 000 independent frames none strays from its neighbours by so much."""


def find_contacts(gaps: Gaps) -> Contacts:
    """Find the contacts of ball, heavy body and wall: impacts of either gap that closes.

    Between sure ones a turn is a contact unless it is clearly smooth: where flights hold too few
    pictures nothing shows that the ball bounces, but it can hardly turn otherwise.
    """
    sure: list[tuple[float, CollisionKind]] = []
    unsure: list[tuple[float, CollisionKind]] = []
    for kind in KINDS:  # that of the bodies strikes the ball on its way to the wall and back
        motion = motion_of(gaps.frame, gaps.closing(kind), NOISE_AT_LEAST_PX)
        struck = [frame for frame, _ in sure]
        found = find_impacts(motion, depth_sigmas=CLEAR_SIGMAS, struck=struck)
        sure += [(one.frame, kind) for one in found.impacts if one.side < 0]
        turns = (one for one in found.open if one.side < 0 and one.log_odds >= NO_BOUNCE)
        unsure += [(one.frame, kind) for one in turns]
    first, last = min(sure, default=(np.inf,))[0], max(sure, default=(-np.inf,))[0]
    points = sorted([*sure, *(one for one in unsure if first < one[0] < last)])
    points = sorted([*points, *_missing(points, gaps)])
    paths = Paths(gaps.frame, gaps.ball_px, gaps.heavy_px)
    return fit_contacts(paths, [kind for _, kind in points], [frame for frame, _ in points])


def _missing(
    points: Sequence[tuple[float, CollisionKind]], gaps: Gaps
) -> list[tuple[float, CollisionKind]]:
    """Where two contacts of one kind follow each other, the clearest corner of the other gap.

    The ball cannot come to one side twice but by a contact on the other, nor from rest to the wall.
    Such a contact may be no deeper than the noise, and make no turn.
    Where none with the wall is shown, as where two balls meet far from any, none is missing.
    """
    found, shown = [], {kind for _, kind in points}
    for before, after in zip([(-np.inf, "wall"), *points], points, strict=False):
        kind = KINDS[after[1] == "bodies"]
        if after[1] == before[1] and (kind == "bodies" or kind in shown):
            corner = _corner(gaps.frame, gaps.closing(kind), before[0], after[0])
            found += [] if corner is None else [(corner, kind)]
    return found


def _corner(frame: Floats, signal: Floats, low: float, high: float) -> float | None:
    """Frame between two others at which a signal most clearly turns from closing to opening.

    Before and after it obeys x'' = g - w^2 (x - x0), so that with a ramp for the jump it is linear
    in five unknowns. None where too few places are seen, or none is clear.
    """
    inside = (frame > low + HALF_EXPOSURE) & (frame < high - HALF_EXPOSURE)
    flight = flight_of(frame[inside], signal[inside])
    if flight is None or len(flight.clock) < CORNER_ROWS:
        return None
    time, place = flight.clock, flight.place_px
    law = np.column_stack([flight.own, flight.shared])
    basis, triangle = np.linalg.qr(law)
    tried = np.arange(1, len(time) - 1, 1 + len(time) // CORNERS_TRIED)
    ramps = np.maximum(time[:, None] - time[tried], 0.0)
    shared = basis.T @ ramps
    ramps -= basis @ shared
    squares = (ramps**2).sum(axis=0)
    clear = place @ ramps
    best = int(np.argmax(clear / np.sqrt(squares)))
    jump, row = clear[best] / squares[best], tried[best]
    unseen = time[row + 1] - time[row - 1] > UNSEEN_FRAMES
    if unseen or clear[best] < CLEAR_SIGMAS * sigma_of(place) * np.sqrt(squares[best]):
        return None
    free = np.linalg.solve(triangle, basis.T @ place - jump * shared[:, best])
    closing = np.gradient(law @ free, time)[row]
    return float(time[row]) if closing < 0 < closing + jump else None


def _lengths_px(track: Track) -> float:
    """Lengths of all bodies together."""
    bodies = [track.ball] if track.heavy is None else [track.ball, track.heavy]
    return sum(body.high_edge_px - body.low_edge_px for body in bodies)


def _shown(collisions: Sequence[Collision], gaps: Gaps) -> list[Collision]:
    """Mark which collisions the frames show: surely in time, and with pictures next to them."""
    frames = [collision.frame for collision in collisions]
    nearest = np.minimum(np.diff(frames, prepend=-np.inf), np.diff(frames, append=np.inf))
    pictures = gaps.frame[np.isfinite(gaps.ball_px)]
    ends = np.concatenate([[-np.inf], pictures, [np.inf]])
    after = np.searchsorted(pictures, frames) + 1
    apart = ends[after] - ends[after - 1]
    return [
        replace(one, seen=bool(one.frame_sigma <= SHOWN_SHARE * free and gap <= UNSEEN_FRAMES))
        for one, free, gap in zip(collisions, nearest.tolist(), apart.tolist(), strict=True)
    ]

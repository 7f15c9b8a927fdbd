"""Gaps between ball, heavy body and wall, and the contacts at which these close.

Distances grow away from the wall, whichever side of the picture it stands on. A contact is an
impact of a gap that closes: of the ball's distance from the wall, or of that between the bodies.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from count_video.motion.contacts import Contacts, fit_contacts
from count_video.motion.errors_of_places import HALF_EXPOSURE, flight_of
from count_video.motion.flight import motion_of
from count_video.motion.impacts import find_impacts
from count_video.motion.priors import NO_BOUNCE, STOP_SHARE
from count_video.records import CollisionKind, Floats, Track
from count_video.signals import NOISE_AT_LEAST_PX, low_points, sigma_of

KINDS: tuple[CollisionKind, CollisionKind] = ("bodies", "wall")
CORNER_ROWS, CORNERS_TRIED = 10, 400
"""Rows that show a corner at least, and about how many of them are tried at most."""
UNSEEN_FRAMES = 3.0
"""What happens between pictures that are farther apart is not shown."""
CLEAR_SIGMAS = 6.0
"""A turn is as deep as so many standard deviations of a place, or, where it is shallower, a corner
as clear: of 10 000 independent frames none strays from its neighbours by so much."""
SMOOTH_SIGMAS = 3.0
"""A corner that is less clear is none, if pictures show the whole flight."""


@dataclass(frozen=True)
class Gaps:
    """Distances away from the wall and the gap between the bodies; arrays have shape (n,)."""

    frame: Floats
    """Frame coordinates."""
    ball_px: Floats
    """The ball's centre, away from the wall, from an arbitrary origin; NaN where not seen."""
    heavy_px: Floats
    """The heavy body's face turned to the ball, from the same origin."""
    near_edge_px: float
    """From the ball's centre to its outline on the heavy body's side."""
    sign: int
    """+1 where distances grow with the position in the picture, -1 where they fall."""

    def closing(self, kind: CollisionKind) -> Floats:
        """Gap that closes in a collision of a kind: the ball's distance, for the wall.

        Between the bodies it is that of their outlines, about 0 at contact.
        """
        if kind == "wall":
            return self.ball_px
        return self.heavy_px - self.ball_px - self.near_edge_px


def gaps_of(track: Track) -> Gaps:
    """Turn a track with both bodies over into distances from the wall."""
    ball, heavy = track.bodies
    sign = 1 if track.wall_side == "left" else -1
    return Gaps(
        frame=track.frame,
        ball_px=sign * ball.position_px,
        heavy_px=sign * heavy.position_px,
        near_edge_px=ball.high_edge_px if sign > 0 else -ball.low_edge_px,
        sign=sign,
    )


def find_contacts(gaps: Gaps) -> Contacts:
    """Find the contacts of ball, heavy body and wall: impacts of either gap that closes.

    Between sure ones a turn is a contact unless it is clearly smooth: where flights hold too few
    pictures nothing shows that the ball bounces, but it can hardly turn otherwise.
    """
    found: list[tuple[float, CollisionKind, bool]] = []
    for kind in KINDS:  # that of the bodies strikes the ball on its way to the wall and back
        motion = motion_of(gaps.frame, gaps.closing(kind), NOISE_AT_LEAST_PX)
        struck = [frame for frame, _, sure in found if sure]
        turns, _ = find_impacts(motion, depth_sigmas=CLEAR_SIGMAS, struck=struck)
        near = [one for one in turns if one.side < 0 and one.log_odds >= NO_BOUNCE]
        found += [(one.frame, kind, one.likely) for one in near]
    clear = [frame for frame, _, sure in found if sure] or [np.inf]
    first, last = min(clear), max(clear)
    points = sorted((frame, kind) for frame, kind, _ in found if first <= frame <= last)
    points = sorted([*points, *_missing(points, gaps)])
    return fit_contacts(gaps.frame, (gaps.ball_px, gaps.heavy_px), points, sign=gaps.sign)


def _missing(
    points: Sequence[tuple[float, CollisionKind]], gaps: Gaps
) -> list[tuple[float, CollisionKind]]:
    """Where two contacts of one kind follow each other, the clearest corner of the other gap.

    The ball comes to one side twice by a contact on the other, if its thread does not bring it back
    (see ``turns_alone``), and never from rest to the wall. Such a contact may be no deeper than the
    noise, and make no turn. One with the wall is where the others are; where none is shown, as
    where two balls meet far from any wall, none is missing.
    """
    found, below = [], {"bodies": np.inf}
    walls = [frame for frame, kind in points if kind == "wall"]
    if walls:
        seen = np.isfinite(gaps.ball_px)
        place = np.interp(walls, gaps.frame[seen], gaps.ball_px[seen])
        below["wall"] = float(np.median(place) + STOP_SHARE * np.ptp(gaps.ball_px[seen]))
    for before, after in zip([(-np.inf, "wall"), *points], points, strict=False):
        kind = KINDS[after[1] == "bodies"]
        if after[1] == before[1] and kind in below:
            corner = _corner(gaps.frame, gaps.closing(kind), (before[0], after[0]), below[kind])
            found += [] if corner is None else [(corner, kind)]
    return found


def turns_alone(gaps: Gaps, between: tuple[float, float]) -> bool:
    """Whether the ball turns round between two contacts without one: its thread brings it back."""
    clearest = _clearest(gaps.frame, gaps.ball_px, between, np.inf)
    if clearest is None or clearest.sigmas > SMOOTH_SIGMAS:
        return False
    inside = (gaps.frame > between[0]) & (gaps.frame < between[1]) & np.isfinite(gaps.ball_px)
    place, shown = gaps.ball_px[inside], np.diff(gaps.frame[inside]).max() <= UNSEEN_FRAMES
    return bool(shown and len(low_points(place, CLEAR_SIGMAS * sigma_of(place))))


def _corner(
    frame: Floats, signal: Floats, between: tuple[float, float], below: float
) -> float | None:
    """Frame between two others at which a signal turns from closing to opening by a corner.

    None where too few places are seen, or none of those ``below`` is clear.
    """
    best = _clearest(frame, signal, between, below)
    if best is None or not best.shown or best.sigmas < CLEAR_SIGMAS:
        return None
    return best.frame if best.closing < 0 < best.closing + best.jump else None


@dataclass(frozen=True)
class _Corner:
    """The clearest corner of a flight."""

    frame: float
    shown: bool
    """Whether the pictures next to it are close."""
    sigmas: float
    """How clear it is, in standard deviations."""
    closing: float
    """Velocity before it, in px per frame."""
    jump: float
    """What it adds to that."""


def _clearest(
    frame: Floats, signal: Floats, between: tuple[float, float], below: float
) -> _Corner | None:
    """Find the clearest corner between two frames, where the signal is below a place.

    Before and after it obeys x'' = g - w^2 (x - x0), so that with a ramp for the jump it is linear
    in five unknowns. None where too few places are seen.
    """
    low, high = between
    inside = (frame > low + HALF_EXPOSURE) & (frame < high - HALF_EXPOSURE)
    flight = flight_of(frame[inside], signal[inside])
    if flight is None or len(flight.clock) < CORNER_ROWS:
        return None
    time, place = flight.clock, flight.place_px
    law = np.column_stack([flight.own, flight.shared])
    basis, triangle = np.linalg.qr(law)
    tried = np.arange(1, len(time) - 1, 1 + len(time) // CORNERS_TRIED)
    at = signal[inside]
    tried = tried[at[np.isfinite(at)][tried] <= below]
    if len(tried) == 0:
        return None
    ramps = np.maximum(time[:, None] - time[tried], 0.0)
    shared = basis.T @ ramps
    ramps -= basis @ shared
    squares = (ramps**2).sum(axis=0)
    clear = place @ ramps
    best = int(np.argmax(clear / np.sqrt(squares)))
    jump, row = float(clear[best] / squares[best]), tried[best]
    free = np.linalg.solve(triangle, basis.T @ place - jump * shared[:, best])
    return _Corner(
        frame=float(time[row]),
        shown=bool(time[row + 1] - time[row - 1] <= UNSEEN_FRAMES),
        sigmas=float(clear[best] / np.sqrt(squares[best])) / sigma_of(place),
        closing=float(np.gradient(law @ free, time)[row]),
        jump=jump,
    )

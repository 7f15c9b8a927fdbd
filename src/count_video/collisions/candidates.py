"""Where collisions may be: closings of the two gaps, with their corners at sub-frame times.

The ball stands between two gaps, one to the wall and one to the heavy body. Each collision is a
low point of one of them. First the low points are found, then every corner is sharpened by fits
on both sides that end at the neighbouring corners, whichever gap those belong to.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from count_video.collisions.gaps import Gaps
from count_video.collisions.onesided import Corner, Side, crossing, fit_side, widest_needed
from count_video.records import CollisionKind, Floats
from count_video.signals import low_points, sigma_of

HYSTERESIS_SIGMAS = 6.0
"""Of 10 000 independent frames none strays from its neighbours by so much."""
ROUNDS = 4
"""Corners limit each other's sides; after so many rounds their times stand still."""
CORNER_MOVES_AT_MOST = 1.5
"""Pictures between the lowest sample of a well sampled gap and the corner of the fits."""
FEW_POINTS = 3
"""A side with fewer frames of its own also takes the contact at its far end as a point."""


@dataclass(frozen=True)
class Candidate:
    """A closing of one gap."""

    kind: CollisionKind
    lowest: float
    """Frame coordinate of the lowest sample."""
    frame: float
    """Best frame coordinate so far."""
    frame_sigma: float
    corner: Corner | None
    """None where the frames do not show both sides."""


@dataclass(frozen=True)
class Contacts:
    """Where the gaps are closed, learnt from the clearest corners."""

    wall_ball_px: float
    """Distance of the ball's centre at the wall."""
    bodies_gap_px: float
    bodies_gap_slope: float
    """Gap by the outlines at contact, at the distance ``bodies_about_px`` of the ball, and its
    change with the distance: a camera close by sees the face's rim and the ball in parallax."""
    bodies_about_px: float

    def gap_at(self, ball_px: float) -> float:
        """Gap by the outlines, at contact, for a distance of the ball."""
        return self.bodies_gap_px + self.bodies_gap_slope * (ball_px - self.bodies_about_px)


def find_candidates(gaps: Gaps) -> list[Candidate]:
    """Low points of both gaps, in order of time."""
    found: list[Candidate] = []
    signals: tuple[tuple[CollisionKind, Floats], ...] = (
        ("wall", gaps.ball_px),
        ("bodies", gaps.gap_px),
    )
    for kind, signal in signals:
        depth = HYSTERESIS_SIGMAS * sigma_of(signal)
        for place in low_points(signal, depth):
            frame = float(gaps.frame[place])
            found.append(Candidate(kind, frame, frame, 0.5, None))
    return sorted(found, key=lambda candidate: candidate.frame)


def sharpen(
    candidates: Sequence[Candidate], gaps: Gaps, contacts: Contacts | None = None
) -> list[Candidate]:
    """Give the candidates their corners; with contacts known, crowded ones profit from them."""
    sharp = list(candidates)
    for _ in range(ROUNDS):
        frames = [-np.inf, *(candidate.frame for candidate in sharp), np.inf]
        sharp = [
            _sharpened(place, sharp, gaps, (frames[place], frames[place + 2]), contacts)
            for place in range(len(sharp))
        ]
    return sharp


def _sharpened(
    place: int,
    candidates: Sequence[Candidate],
    gaps: Gaps,
    limits: tuple[float, float],
    contacts: Contacts | None,
) -> Candidate:
    candidate = candidates[place]
    sides = [
        _side(candidate, gaps, limit, _anchor(candidates, place + step, candidate, gaps, contacts))
        for limit, step in zip(limits, (-1, 1), strict=True)
    ]
    before, after = sides
    if before is not None and after is not None:
        corner = crossing(before, after, candidate.frame)
        if corner is None or not limits[0] < corner.frame < limits[1]:
            return candidate
        if abs(corner.frame - candidate.lowest) > _moves_at_most(candidate, gaps, corner):
            return candidate
        return replace(candidate, frame=corner.frame, frame_sigma=corner.frame_sigma, corner=corner)
    one = before or after
    if one is None or contacts is None or one.slope == 0.0:
        return candidate
    step = (_closed(candidate, gaps, contacts) - one.value) / one.slope
    if abs(candidate.frame + step - candidate.lowest) > _moves_at_most(candidate, gaps):
        return candidate
    sigma = float(np.sqrt(one.covariance[0, 0])) / abs(one.slope)
    return replace(candidate, frame=candidate.frame + step, frame_sigma=max(sigma, 0.1))


def _moves_at_most(candidate: Candidate, gaps: Gaps, corner: Corner | None = None) -> float:
    """How far a contact may lie from the lowest sample, in frames.

    It lies in one of the steps next to it, which take longer where pictures were left out. Slow
    contacts are lowest anywhere near the corner; the fits know better than one sample.
    """
    place = int(np.searchsorted(gaps.frame, candidate.lowest))
    longest = float(np.diff(gaps.frame[max(0, place - 1) : place + 2]).max(initial=1.0))
    return CORNER_MOVES_AT_MOST * longest + (4.0 * corner.frame_sigma if corner else 0.0)


def _side(
    candidate: Candidate, gaps: Gaps, limit: float, anchor: tuple[float, float] | None
) -> Side | None:
    signal = signal_of(candidate.kind, gaps)
    sigma = sigma_of(signal)
    chosen = widest_needed(gaps.frame, signal, candidate.frame, limit, sigma)
    frame, values = gaps.frame[chosen], signal[chosen]
    if len(chosen) < FEW_POINTS and anchor is not None:
        frame, values = np.append(frame, anchor[0]), np.append(values, anchor[1])
    return fit_side(frame, values, candidate.frame, sigma)


def signal_of(kind: CollisionKind, gaps: Gaps) -> Floats:
    """Return the gap that closes in such a collision (for the wall, the ball's distance)."""
    return gaps.ball_px if kind == "wall" else gaps.gap_px


def _anchor(
    candidates: Sequence[Candidate],
    neighbour: int,
    candidate: Candidate,
    gaps: Gaps,
    contacts: Contacts | None,
) -> tuple[float, float] | None:
    """Frame and value, in the candidate's gap, of the contact next to it."""
    if contacts is None or not 0 <= neighbour < len(candidates):
        return None
    frame = candidates[neighbour].frame
    heavy = heavy_at(gaps, frame)
    near_edge = float(np.nanmedian(gaps.heavy_px - gaps.ball_px - gaps.gap_px))
    if candidates[neighbour].kind == "wall":
        ball = contacts.wall_ball_px
    else:
        ball = heavy - near_edge - contacts.gap_at(heavy - near_edge)
    return frame, ball if candidate.kind == "wall" else heavy - near_edge - ball


def heavy_at(gaps: Gaps, frame: float) -> float:
    """Distance of the heavy body's face at a frame coordinate, by linear interpolation."""
    seen = np.isfinite(gaps.heavy_px)
    return float(np.interp(frame, gaps.frame[seen], gaps.heavy_px[seen]))


def ball_at(gaps: Gaps, frame: float) -> float:
    """Distance of the ball's centre at a frame coordinate, by linear interpolation."""
    seen = np.isfinite(gaps.ball_px)
    return float(np.interp(frame, gaps.frame[seen], gaps.ball_px[seen]))


def _closed(candidate: Candidate, gaps: Gaps, contacts: Contacts) -> float:
    if candidate.kind == "wall":
        return contacts.wall_ball_px
    return contacts.gap_at(ball_at(gaps, candidate.frame))

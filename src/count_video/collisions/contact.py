"""Corroborate that a gap is closed where the relative velocity changes its sign.

A pendulum or a thrown ball turns round smoothly and touches nothing. A collision has both a jump
of the velocity and a contact: all wall contacts happen at one distance of the ball, all contacts
of the bodies at one gap (which may drift slowly across the picture by parallax).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from count_video.collisions.candidates import Candidate, Contacts, ball_at, signal_of
from count_video.collisions.gaps import Gaps
from count_video.collisions.kink import FLIGHT_FRAMES, has_kink
from count_video.collisions.onesided import Corner
from count_video.records import Floats
from count_video.signals import sigma_of

JUMP_SIGMAS = 4.0
"""A jump of the velocity must exceed its uncertainty by this factor."""
CONTACT_SHARE = 0.05
"""Outline and contact agree to this share of the ball's diameter."""
CONTACT_AT_LEAST_PX = 1.5
APART_SHARE = 0.5
"""Bodies whose outlines stay this share of the ball's diameter apart do not touch."""


def is_sharp(candidate: Candidate, gaps: Gaps, limits: tuple[float, float]) -> bool:
    """Whether the gap closes and opens with a jump of its rate; unsampled corners pass.

    ``limits`` are the frames of the neighbouring candidates.
    """
    corner = candidate.corner
    if corner is None:
        # Sides that the frames show well and that do not cross make a turn, not a corner.
        flights = candidate.frame - limits[0], limits[1] - candidate.frame
        return min(flights) < FLIGHT_FRAMES
    jump = corner.slope_after - corner.slope_before
    closes = corner.slope_before < 0 < corner.slope_after
    if not closes or jump <= JUMP_SIGMAS * corner.slope_sigma:
        return False
    return has_kink(gaps.frame, signal_of(candidate.kind, gaps), corner, limits)


def sharp_ones(candidates: Sequence[Candidate], gaps: Gaps) -> list[Candidate]:
    """Keep the candidates whose gap closes and opens with a jump of its rate."""
    frames = [-np.inf, *(candidate.frame for candidate in candidates), np.inf]
    return [
        candidate
        for place, candidate in enumerate(candidates)
        if is_sharp(candidate, gaps, (frames[place], frames[place + 2]))
    ]


def learn_contacts(candidates: Sequence[Candidate], gaps: Gaps) -> Contacts:
    """Learn where the gaps are closed, from the candidates that have corners."""
    wall = [c.corner for c in candidates if c.kind == "wall" and c.corner]
    bodies = [c for c in candidates if c.kind == "bodies" and c.corner]
    places = np.array([ball_at(gaps, c.frame) for c in bodies])
    values = np.array([c.corner.value for c in bodies if c.corner])
    about = float(places.mean()) if len(places) else 0.0
    gap, slope = _robust_line(places - about, values)
    return Contacts(
        wall_ball_px=_level(wall) if wall else _lowest(gaps.ball_px),
        bodies_gap_px=gap,
        bodies_gap_slope=slope,
        bodies_about_px=about,
    )


def _level(corners: Sequence[Corner]) -> float:
    """Median of the corners' values, each with the weight of its jump: hard bounces tell best."""
    values = np.array([corner.value for corner in corners])
    jumps = np.array([abs(corner.slope_after - corner.slope_before) for corner in corners])
    order = np.argsort(values)
    share = np.cumsum(jumps[order])
    return float(values[order][np.searchsorted(share, share[-1] / 2)])


def _lowest(signal: Floats) -> float:
    return float(np.nanmin(signal))


def _robust_line(x: Floats, y: Floats) -> tuple[float, float]:
    """Offset and slope by medians (Theil 1950, Sen 1968); a level for fewer than four points."""
    if len(x) == 0:
        return 0.0, 0.0
    if len(x) < 4 or np.ptp(x) == 0:
        return float(np.median(y)), 0.0
    first, second = np.triu_indices(len(x), k=1)
    apart = np.abs(x[second] - x[first]) > 0.2 * np.ptp(x)
    run, rise = (x[second] - x[first])[apart], (y[second] - y[first])[apart]
    slope = float(np.median(rise / run)) if len(run) else 0.0
    return float(np.median(y - slope * x)), slope


def touch_is_shown(candidates: Sequence[Candidate]) -> bool:
    """Whether any of the collisions tells the gap at which the bodies touch."""
    return any(candidate.kind == "bodies" and candidate.corner for candidate in candidates)


def never_touch(contacts: Contacts, ball_diameter_px: float) -> bool:
    """Whether the outlines stay apart where the gap is said to be closed.

    A camera that looks obliquely shows a gap at contact, but one small beside the ball.
    """
    return contacts.bodies_gap_px > APART_SHARE * ball_diameter_px


def is_contact(
    candidate: Candidate, gaps: Gaps, contacts: Contacts, ball_diameter_px: float
) -> bool:
    """Whether the gap is closed, within the tolerance, where the candidate has its corner."""
    signal = signal_of(candidate.kind, gaps)
    if candidate.kind == "wall":
        closed = contacts.wall_ball_px
    else:
        closed = contacts.gap_at(ball_at(gaps, candidate.frame))
    tolerance = max(CONTACT_AT_LEAST_PX, CONTACT_SHARE * ball_diameter_px)
    tolerance += 4 * sigma_of(signal)
    if candidate.corner is not None:
        return abs(candidate.corner.value - closed) < tolerance
    # Between two frames the gap was lower than any sample shows, by up to one frame's motion.
    place = int(np.argmin(np.abs(gaps.frame - candidate.lowest)))
    around = signal[max(0, place - 2) : place + 3]
    moved = np.abs(np.diff(around))
    motion = float(moved[np.isfinite(moved)].max(initial=0.0))
    return -tolerance < float(signal[place]) - closed < tolerance + motion

"""Impacts that a clip may have and does not show: before the first, between, and after the last."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from count_video.motion.finding import JUMP_SIGMAS
from count_video.motion.flight import POINTS_AT_LEAST, Motion, flies_freely
from count_video.motion.impacts import (
    HYSTERESIS_SIGMAS,
    Impact,
    find_turns,
    stop_of,
    stop_tolerance,
    unseen_around,
)
from count_video.motion.priors import CHANCE_LEAVING, CHANCE_UNSEEN
from count_video.records import Floats

UNSEEN_SHARE = 0.3
"""An impact may lie before the first one, in pictures of which this share do not show the body."""
CONTACT_PICTURES = 1.0
SHORTER_AT_MOST = 1.6
"""A flight is not longer than the longest after it by more: bodies that lose 60 % of their speed at
an impact are hardly said to bounce."""
FALLEN_BACK = 1.3
TAIL_PICTURES = 4.0
"""A flight shorter than this holds too few pictures clear of its ends to show its impacts, as does
one lower than the noise of both its ends."""
LOG2_APART = 0.5
"""Half way, in binary logarithms, between a flight as expected and one of twice its length."""
FLIGHTS_AT_LEAST = 3
"""Fewer flights do not show that they shrink by a constant share."""
SAME_TURN_PICTURES = 2.0
"""A turn this near to an impact is that impact, pictures that do not show the body apart."""
END_PICTURES = 2.0
"""A turn at one end of the clip shows once the body has moved on for so many pictures."""
END_POINTS = 4
SHORT_STEP = 0.75
"""A last step shorter than this share of those before it hides a turn."""
AT_STOP_PICTURES = 0.6
"""A body that would touch its stop in so small a part of a picture may have done so."""


def chance_before(motion: Motion, impacts: Sequence[Impact]) -> float:
    """Chance of an impact before the first one found, in the time that does not show the body.

    The flight that ends at the first impact is followed back to where it would have begun at the
    stop. If that lies within the clip and the body is not seen then, it may have bounced there;
    more likely so if it still moves away from the stop when it comes into sight.
    """
    first = impacts[0]
    rows = np.flatnonzero(np.isfinite(motion.place_px) & (motion.frame < first.frame))
    while len(rows) > POINTS_AT_LEAST and not flies_freely(motion, rows):
        rows = rows[1:]
    if len(rows) == 0 or not np.isfinite(first.velocity_before):
        return CHANCE_UNSEEN
    begins, clip = float(motion.frame[rows[0]]), float(motion.frame[0])
    left = first.frame - _flight_time(motion, impacts)
    hidden = (motion.frame >= left - CONTACT_PICTURES) & (motion.frame < begins)
    if left < clip - CONTACT_PICTURES or not hidden.any():
        return 0.0
    if float(np.isnan(motion.place_px[hidden]).mean()) < UNSEEN_SHARE:
        return 0.0
    speed = first.side * (first.velocity_before - motion.acceleration * (first.frame - begins))
    return CHANCE_LEAVING if speed < 0 else CHANCE_UNSEEN


def _flight_time(motion: Motion, impacts: Sequence[Impact]) -> float:
    """How long the flight before the first impact took if it began at the stop, in pictures."""
    first = impacts[0]
    pull = first.side * motion.acceleration
    back = 2 * first.side * first.velocity_before / pull if pull > 0 else np.inf
    flights = np.diff([impact.frame for impact in impacts])
    # Without a pull, or with a weak one, the body comes from another stop, as it does later on.
    return float(min(back, SHORTER_AT_MOST * flights.max())) if len(flights) else float(back)


def lost_after(motion: Motion, impacts: Sequence[Impact]) -> bool:
    """Whether the body must have fallen back to the stop after the last impact that was found.

    It did, by the velocity with which it left, if the clip goes on for long enough. Under a
    constant pull flights last as long as they begin fast, those of a pendulum longer: the one
    before says how long.
    """
    if len(impacts) < 2:
        return False
    last = impacts[-1]
    pull = last.side * motion.acceleration
    if pull <= 0 or not np.isfinite(last.velocity_after):
        return False
    before = impacts[-2]
    if before.side == last.side and -before.side * before.velocity_after > 0:
        back = (last.frame - before.frame) * last.velocity_after / before.velocity_after
    else:
        back = -2 * last.side * last.velocity_after / pull
    return bool(last.frame + FALLEN_BACK * back < motion.frame[-1])


def dies_out(motion: Motion, impacts: Sequence[Impact]) -> bool:
    """Whether the flights shrink by a nearly constant share until pictures show none any more.

    A body that bounces on one stop keeps the same share e of its speed at every impact, so its
    flights under a constant pull form a geometric series: endlessly many within a finite time, of
    which pictures show the first ones. ``e`` is the median ratio of neighbours, which most must be
    near; by it each flight says how long the next one after the last would be, and the median of
    them is taken.
    """
    flights = np.diff([impact.frame for impact in impacts])
    if len({impact.side for impact in impacts}) != 1 or len(flights) < FLIGHTS_AT_LEAST:
        return False
    share = _share_kept(flights)
    if share >= 1.0 or _continue(flights).mean() <= 0.5:
        return False
    following = flights * share ** np.arange(len(flights), 0, -1)
    # A flight of t pictures rises by pull t^2 / 8.
    pull = abs(motion.acceleration)
    known = pull > motion.acceleration_spread
    noisy = np.sqrt(8 * 2 * HYSTERESIS_SIGMAS * motion.sigma_px / pull) if known else 0.0
    return float(np.median(following)) < max(TAIL_PICTURES, noisy)


def until_rest(impacts: Sequence[Impact]) -> Sequence[Impact]:
    """Leave out what noise makes of a body that lies at rest after its bounces have died out.

    There, nothing clear comes after a flight longer than all that the series has left to last.
    """
    flights = np.diff([impact.frame for impact in impacts])
    for last in range(FLIGHTS_AT_LEAST, len(flights)):
        share, later = _share_kept(flights[:last]), impacts[last + 1 :]
        left = flights[last - 1] * share / (1 - share) if share < 1.0 else np.inf
        if flights[last] > left and all(impact.clarity < JUMP_SIGMAS for impact in later):
            return impacts[: last + 1]
    return impacts


def in_series(impacts: Sequence[Impact]) -> list[bool]:
    """Whether each impact ends a flight that continues the geometric series of those before it.

    An impact that is missed doubles a flight, one too many halves one: the ratio of neighbours is
    nearer to ``e`` than to either. The first impact begins the series.
    """
    return [True, True, *_continue(np.diff([impact.frame for impact in impacts])).tolist()]


def _continue(flights: Floats) -> NDArray[np.bool_]:
    """Whether each flight but the first is as long as the one before lets expect."""
    strays = np.abs(np.log2(flights[1:] / flights[:-1] / _share_kept(flights)))
    return np.asarray(strays < LOG2_APART)


def _share_kept(flights: Floats) -> float:
    return float(np.median(flights[1:] / flights[:-1]))


def passed_over(motion: Motion, impacts: Sequence[Impact]) -> list[float]:
    """Frames of turns at a stop that are not known for impacts, between the first and the end."""
    if not impacts:
        return []
    tolerance = stop_tolerance(motion)
    found = np.array([impact.frame for impact in impacts])
    over = []
    for turn in find_turns(motion):
        here = [impact for impact in impacts if impact.side == turn.side]
        same = SAME_TURN_PICTURES + unseen_around(motion, turn.outermost)
        if not here or np.abs(found - turn.frame).min() <= same:
            continue
        near = motion.place_px[np.abs(motion.frame - turn.outermost) <= 1.0]
        place = float(motion.place_px[motion.frame == turn.outermost][0])
        # The picture nearest to a turn shows the body by up to half a step away from it.
        slack = tolerance + AT_STOP_PICTURES * float(np.nanmax(np.abs(near - place)))
        if turn.side * (stop_of(here) - place) < slack:
            over.append(turn.frame)
    return over


def ends_at_stop(motion: Motion, impacts: Sequence[Impact]) -> int:
    """At how many ends of the clip an impact may lie that no turn shows.

    There the body comes to the stop and is at it in the last picture, or its last step is too short
    to lead on: it has turned back meanwhile.
    """
    seen = np.flatnonzero(np.isfinite(motion.place_px))
    number = 0
    for rows in (seen[:END_POINTS], seen[::-1][:END_POINTS]) if len(seen) > 1 else ():
        frame, place = float(motion.frame[rows[0]]), motion.place_px[rows]
        steps = np.abs(np.diff(place) / np.diff(motion.frame[rows]))
        speed = float(steps.max())
        for side in {impact.side for impact in impacts}:
            here = [impact for impact in impacts if impact.side == side]
            away = side * (stop_of(here) - float(place[0]))
            known = min(abs(impact.frame - frame) for impact in here) <= END_POINTS
            nearing = side * float(place[0] - place[-1]) > 0
            turned = away < END_PICTURES * speed and steps[0] < SHORT_STEP * speed
            if nearing and not known and (turned or away < AT_STOP_PICTURES * speed):
                number += 1
    return number

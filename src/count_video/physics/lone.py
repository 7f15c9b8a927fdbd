"""One body alone between two stops, one stop or none: every impact and the state at any time.

A ball on a table, a cart that runs to and fro, a pendulum against a wall: the body follows its law
of motion until it meets a stop, and leaves it with a part of its speed. As in the trial of two
bodies the state is exact at the last event and everything is computed from there.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from count_video.errors import UsageError
from count_video.physics.contacts import Mover, contact_s
from count_video.physics.flights import REST, Law
from count_video.records import Floats

MOST_IMPACTS = 100_000
"""A run with more is refused before it fills the memory."""


@dataclass(frozen=True)
class Stops:
    """What the body strikes. Positions are those of the face that touches, in metres.

    Raises
    ------
    UsageError
        If the stops are in the wrong order or a number is out of its range.
    """

    low_m: float = 0.0
    """Lower stop; −inf for none."""
    high_m: float = math.inf
    """Upper stop; inf for none."""
    restitution: float = 1.0
    """Speed after an impact over the speed before it."""
    slow_m_s: float = 0.0
    """An impact no faster than this is no bounce: the body stays. Without it an inelastic ball
    would bounce infinitely often before it rests."""

    def __post_init__(self) -> None:
        if not self.low_m < self.high_m:
            raise UsageError(f"stops at {self.low_m:g} and {self.high_m:g} m: give low, then high")
        if not 0.0 <= self.restitution <= 1.0:
            raise UsageError(f"restitution is {self.restitution:g}; it must lie between 0 and 1")
        if not 0.0 <= self.slow_m_s < math.inf:
            raise UsageError(f"slow_m_s is {self.slow_m_s:g}; it must be finite and not negative")


@dataclass(frozen=True, slots=True)
class LoneImpact:
    """One bounce; velocities are positive toward higher positions."""

    time_s: float
    place_m: float
    """The stop that was struck."""
    before_m_s: float
    after_m_s: float


class LoneAnchor(NamedTuple):
    """State just after an event."""

    time_s: float
    position_m: float
    velocity_m_s: float
    resting: bool
    """True for a body that stays at a stop from now on."""


@dataclass(frozen=True)
class LoneMotion:
    """A simulated run."""

    law: Law
    until_s: float
    """Simulated up to here."""
    impacts: tuple[LoneImpact, ...]
    anchors: tuple[LoneAnchor, ...]
    """State after each event, the start first."""

    def sample(self, times_s: Floats) -> tuple[Floats, Floats]:
        """Position and velocity at times of any shape, up to ``until_s``.

        Before time 0 the body is held at its start. At the very time of an impact the velocity is
        the one after it.

        Raises
        ------
        UsageError
            If a time is not finite or later than ``until_s``.
        """
        times = np.asarray(times_s, dtype=np.float64)
        if not (np.isfinite(times).all() and times.max(initial=0.0) <= self.until_s):
            raise UsageError(f"the motion is known up to {self.until_s:g} s; simulate it longer")
        rows = np.maximum(np.searchsorted(self._states[0], times, side="right") - 1, 0)
        start_s, position, velocity, resting = self._states[:, rows]
        rise, now = self.law.advance_many(position, velocity, np.maximum(times - start_s, 0.0))
        still = (resting > 0) | (times < 0)
        return position + np.where(still, 0.0, rise), np.where(still, 0.0, now)

    @cached_property
    def _states(self) -> Floats:
        """Shape (4, anchors), in the order of the fields of an anchor."""
        return np.array(self.anchors, dtype=np.float64).T.copy()


def simulate_lone(
    law: Law, position_m: float, velocity_m_s: float, stops: Stops, until_s: float
) -> LoneMotion:
    """Run one body from time 0 to ``until_s``.

    Raises
    ------
    UsageError
        If the body does not start between the stops, ``until_s`` is no time, or there are more
        than ``MOST_IMPACTS`` impacts.
    """
    if not stops.low_m <= position_m <= stops.high_m:
        raise UsageError(f"the body starts at {position_m:g} m, which is not between its stops")
    if not 0.0 <= until_s < math.inf:
        raise UsageError(f"cannot simulate until {until_s} s; give a finite time from 0 on")
    anchors = [LoneAnchor(0.0, position_m, velocity_m_s, resting=False)]
    impacts: list[LoneImpact] = []
    for anchor, impact in _events(law, anchors[0], stops):
        if anchor.time_s > until_s:
            break
        anchors.append(anchor)
        if impact is not None:
            impacts.append(impact)
        if len(impacts) > MOST_IMPACTS:
            raise UsageError(f"more than {MOST_IMPACTS} impacts; end sooner or raise slow_m_s")
    return LoneMotion(law, until_s, tuple(impacts), tuple(anchors))


def _events(
    law: Law, anchor: LoneAnchor, stops: Stops
) -> Iterator[tuple[LoneAnchor, LoneImpact | None]]:
    """Every event after ``anchor``, with its impact if it is one; ends when none can follow."""
    while not anchor.resting:
        flight_s, stop_m = _next_stop(law, anchor, stops)
        if flight_s == math.inf:
            return
        rise, velocity = law.advance(anchor.position_m, anchor.velocity_m_s, flight_s)
        time_s = anchor.time_s + flight_s
        if stop_m is None:
            anchor = LoneAnchor(time_s, anchor.position_m + rise, velocity, resting=False)
            yield anchor, None
        elif abs(velocity) <= stops.slow_m_s:
            # A law that draws the body off the stop takes it along; any other leaves it there.
            pull = law.acceleration(stop_m, 0.0)
            resting = pull <= 0.0 if stop_m == stops.low_m else pull >= 0.0
            anchor = LoneAnchor(time_s, stop_m, 0.0, resting)
            yield anchor, None
        else:
            after = -stops.restitution * velocity
            anchor = LoneAnchor(time_s, stop_m, after, resting=False)
            yield anchor, LoneImpact(time_s, stop_m, velocity, after)


def _next_stop(law: Law, anchor: LoneAnchor, stops: Stops) -> tuple[float, float | None]:
    """Time of flight to the next event, and the stop that it is at; None where the law ends."""
    body = Mover(law, anchor.position_m, anchor.velocity_m_s)
    flight_s, place_m = law.valid_for_s(anchor.velocity_m_s), None
    if math.isfinite(stops.low_m):
        low_s = contact_s(body, Mover(REST, stops.low_m, 0.0), flight_s)
        if low_s <= flight_s and low_s < math.inf:
            flight_s, place_m = low_s, stops.low_m
    if math.isfinite(stops.high_m):
        high_s = contact_s(Mover(REST, stops.high_m, 0.0), body, flight_s)
        if high_s <= flight_s and high_s < math.inf:
            flight_s, place_m = high_s, stops.high_m
    return flight_s, place_m

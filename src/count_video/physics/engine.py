"""From one event to the next: flights, impacts, and bodies that come to rest on each other.

The state is exact at the last event (the *anchor*) and everything is computed from there, so it
does not matter in how many pieces a run is asked for.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from count_video.physics.contacts import WALL, Mover, contact_s
from count_video.physics.setup import Apparatus, Hold
from count_video.records import CollisionKind, Floats

Contact = Literal["bodies", "wall", "parting", "none"]
Restitution = Callable[[CollisionKind], float]
"""Draws the restitution of the next bounce of a kind."""


class Anchor(NamedTuple):
    """State just after an event; the next flight starts here.

    ``heavy_m`` is the cylinder's face less a ball diameter, ``ball_m`` the ball's wall-side face:
    0 ≤ ball_m ≤ heavy_m, and equality is contact, exactly.
    """

    time_s: float
    heavy_m: float
    heavy_velocity_m_s: float
    ball_m: float
    ball_velocity_m_s: float
    hold: Hold


@dataclass(frozen=True, slots=True)
class SimulatedCollision:
    """One bounce, exactly; velocities are positive away from the wall."""

    time_s: float
    kind: CollisionKind
    heavy_before_m_s: float
    heavy_after_m_s: float
    light_before_m_s: float
    light_after_m_s: float
    """Velocities after the bounce itself, before bodies settle on each other."""
    energy_after_j: float
    """Kinetic energy of both bodies and, on threads, their potential energy above rest."""
    restitution: float
    """Relative speed after over before, as drawn for this bounce."""


def events(
    apparatus: Apparatus, anchor: Anchor, restitution: Restitution
) -> Iterator[tuple[Anchor, SimulatedCollision | None]]:
    """Every event after ``anchor``, in order of time: the state after it, and the bounce if any.

    Events without a bounce are those where bodies come to rest on each other, part, stop on the
    floor, or meet nothing for a while. Ends when nothing can ever happen again.
    """
    while True:
        flight_s, contact = _next_event(apparatus, anchor)
        if flight_s == math.inf:
            return
        arrived = _fly(apparatus, anchor, flight_s, contact)
        anchor, impact = _meet(apparatus, arrived, contact, restitution)
        yield anchor, impact


def settle(apparatus: Apparatus, state: Anchor) -> Anchor:
    """Decide which bodies in contact stay together: those without speed or pull to part."""
    time_s, heavy_m, heavy_velocity, ball_m, ball_velocity, _ = state
    slow = apparatus.resting_speed_m_s
    slight = apparatus.resting_acceleration_m_s2
    heavy_velocity = apparatus.heavy.settled(heavy_velocity, slow)
    ball_velocity = apparatus.light.settled(ball_velocity, slow)
    on_wall = ball_m == 0.0 and abs(ball_velocity) <= slow
    leaning = heavy_m == ball_m and abs(heavy_velocity - ball_velocity) <= slow
    if leaning and on_wall:
        return Anchor(time_s, 0.0, 0.0, 0.0, 0.0, _hold_at_wall(apparatus))
    if on_wall:
        pressed = apparatus.light.acceleration(0.0, 0.0) <= slight
        hold = Hold.BALL_ON_WALL if pressed else Hold.APART
        return Anchor(time_s, heavy_m, heavy_velocity, 0.0, 0.0, hold)
    if leaning:
        momentum = apparatus.heavy_kg * heavy_velocity + apparatus.light_kg * ball_velocity
        common = momentum / (apparatus.heavy_kg + apparatus.light_kg)
        common = apparatus.together.settled(common, slow)
        pull = apparatus.heavy.acceleration(heavy_m, common)
        pull -= apparatus.light.acceleration(ball_m, common)
        hold = Hold.TOGETHER if pull <= slight else Hold.APART
        return Anchor(time_s, heavy_m, common, ball_m, common, hold)
    return Anchor(time_s, heavy_m, heavy_velocity, ball_m, ball_velocity, Hold.APART)


def _hold_at_wall(apparatus: Apparatus) -> Hold:
    """Decide who stays where wall, ball and cylinder touch and nothing moves."""
    heavy = apparatus.heavy.acceleration(0.0, 0.0)
    light = apparatus.light.acceleration(0.0, 0.0)
    joint = apparatus.heavy_kg * heavy + apparatus.light_kg * light
    joint /= apparatus.heavy_kg + apparatus.light_kg
    slight = apparatus.resting_acceleration_m_s2
    if heavy <= slight and joint <= slight:
        return Hold.PINNED
    if heavy - light <= slight:
        return Hold.TOGETHER
    return Hold.BALL_ON_WALL if light <= slight else Hold.APART


_LASTING: dict[Hold, tuple[Contact, ...]] = {
    Hold.APART: (),
    Hold.BALL_ON_WALL: ("wall",),
    Hold.TOGETHER: ("bodies",),
}
"""Contacts that a hold keeps up, so that they cannot be what happens next."""


def _next_event(apparatus: Apparatus, anchor: Anchor) -> tuple[float, Contact]:
    """Time of flight to the next event and what it is; inf if nothing will ever happen."""
    _, heavy_m, heavy_velocity, ball_m, ball_velocity, hold = anchor
    if hold is Hold.PINNED:
        return math.inf, "none"
    heavy_law, ball_law = apparatus.laws(hold)
    flight_s = min(heavy_law.valid_for_s(heavy_velocity), ball_law.valid_for_s(ball_velocity))
    heavy = Mover(heavy_law, heavy_m, heavy_velocity)
    ball = Mover(ball_law, ball_m, ball_velocity)
    bodies = heavy, ball
    if hold is Hold.APART and apparatus.relative is not None:
        gap = Mover(apparatus.relative, heavy_m - ball_m, heavy_velocity - ball_velocity)
        bodies = gap, WALL
    pairs: list[tuple[Contact, Mover, Mover]] = [("wall", ball, WALL), ("bodies", *bodies)]
    if ball_m == 0.0:  # bodies that touch now seldom meet next: they come last, with least to seek
        pairs.reverse()
    contact: Contact = "none"
    for kind, upper, lower in pairs:
        if kind not in _LASTING[hold]:
            touch_s = contact_s(upper, lower, flight_s)
            if touch_s <= flight_s:  # also true if both are inf, and then harmless
                flight_s, contact = touch_s, kind
    if hold is Hold.TOGETHER:
        parting_s = apparatus.parting_s(heavy_m, heavy_velocity, flight_s)
        if parting_s < flight_s:
            return parting_s, "parting"
    return flight_s, contact


def _fly(apparatus: Apparatus, anchor: Anchor, flight_s: float, contact: Contact) -> Anchor:
    """State at the end of a flight; bodies that touch are set to touch exactly."""
    time_s, heavy_m, heavy_velocity, ball_m, ball_velocity, hold = anchor
    heavy_law, ball_law = apparatus.laws(hold)
    heavy_rise, heavy_velocity = heavy_law.advance(heavy_m, heavy_velocity, flight_s)
    ball_rise, ball_velocity = ball_law.advance(ball_m, ball_velocity, flight_s)
    together = hold is Hold.TOGETHER
    ball_m = 0.0 if contact == "wall" else max(0.0, ball_m + ball_rise)
    heavy_m = ball_m if together or contact == "bodies" else max(ball_m, heavy_m + heavy_rise)
    return Anchor(time_s + flight_s, heavy_m, heavy_velocity, ball_m, ball_velocity, hold)


def _meet(
    apparatus: Apparatus, arrived: Anchor, contact: Contact, restitution: Restitution
) -> tuple[Anchor, SimulatedCollision | None]:
    """Bounce if the contact is quick enough, then see who stays together."""
    if contact == "parting":  # found from the pull itself, not to be judged again from roundings
        return arrived._replace(hold=Hold.APART), None
    _, _, heavy_velocity, _, ball_velocity, _ = arrived
    approach = -ball_velocity if contact == "wall" else ball_velocity - heavy_velocity
    if contact == "none" or approach <= apparatus.resting_speed_m_s:
        return settle(apparatus, arrived), None
    bounce = restitution(contact)
    if contact == "wall":
        heavy_after, ball_after = heavy_velocity, -bounce * ball_velocity
    else:
        # Equal and opposite impulses: (1 + e) times the reduced mass times the approach.
        push = (1.0 + bounce) * approach / (apparatus.heavy_kg + apparatus.light_kg)
        heavy_after = heavy_velocity + apparatus.light_kg * push
        ball_after = ball_velocity - apparatus.heavy_kg * push
    time_s, heavy_m, _, ball_m, _, _ = arrived
    impact = SimulatedCollision(
        time_s=time_s,
        kind=contact,
        heavy_before_m_s=heavy_velocity,
        heavy_after_m_s=heavy_after,
        light_before_m_s=ball_velocity,
        light_after_m_s=ball_after,
        energy_after_j=apparatus.energy_j(heavy_m, heavy_after, ball_m, ball_after),
        restitution=bounce,
    )
    after = Anchor(time_s, heavy_m, heavy_after, ball_m, ball_after, Hold.APART)
    return settle(apparatus, after), impact


def states_at(apparatus: Apparatus, anchors: Sequence[Anchor], times_s: Floats) -> Floats:
    """State at times of shape (n,), the first or any later event being the last before them.

    Returns position (m) and velocity (m/s) of the cylinder, then of the ball, as an anchor has
    them; shape (4, n). At the very time of an event the state after it.
    """
    starts_s = np.array([anchor.time_s for anchor in anchors])
    rows = np.maximum(np.searchsorted(starts_s, times_s, side="right") - 1, 0)
    tau_s = times_s - starts_s[rows]
    states = np.array([anchor[1:5] for anchor in anchors], dtype=np.float64).T[:, rows]
    holds = np.array([int(anchor.hold) for anchor in anchors])[rows]
    for hold in {anchor.hold for anchor in anchors}:
        part = holds == hold
        for law, body in zip(apparatus.laws(hold), (slice(0, 2), slice(2, 4)), strict=True):
            position, velocity = states[body, part]
            rise, now = law.advance(position, velocity, tau_s[part])
            states[body, part] = position + rise, now
    return states

"""From one event to the next: flights, impacts, and bodies that come to rest on each other.

The state is exact at the last event (the *anchor*) and everything is computed from there, so it
does not matter in how many pieces a run is asked for.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Literal, NamedTuple

from count_video.physics.contacts import WALL, Mover, contact_s
from count_video.physics.mountings import Apparatus, Hold
from count_video.records import CollisionKind


class Anchor(NamedTuple):
    """State just after an event; the next flight starts here.

    ``heavy_m`` is the cylinder's face less a ball diameter, ``ball_m`` the ball's wall-side face.
    """

    time_s: float
    heavy_m: float
    heavy_velocity_m_s: float
    ball_m: float
    ball_velocity_m_s: float
    hold: Hold


class Impact(NamedTuple):
    """What a bounce did, beside the state after it."""

    kind: CollisionKind
    heavy_before_m_s: float
    ball_before_m_s: float
    restitution: float


Restitution = Callable[[CollisionKind], float]
"""Draws the restitution of the next bounce of a kind."""


def events(
    apparatus: Apparatus, anchor: Anchor, restitution: Restitution
) -> Iterator[tuple[Anchor, Impact | None]]:
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
    time_s, heavy_m, heavy_v, ball_m, ball_v, _ = state
    slow = apparatus.resting_speed_m_s
    on_wall = ball_m == 0.0 and abs(ball_v) <= slow
    leaning = heavy_m == ball_m and abs(heavy_v - ball_v) <= slow
    if leaning and on_wall:
        return _settle_both(apparatus, time_s)
    if on_wall:
        pressed = apparatus.light.acceleration(0.0, 0.0) <= apparatus.resting_acceleration_m_s2
        hold = Hold.BALL_ON_WALL if pressed else Hold.APART
        return Anchor(time_s, heavy_m, heavy_v, 0.0, 0.0, hold)
    if leaning:
        heavy_kg, light_kg = apparatus.heavy_kg, apparatus.light_kg
        common = (heavy_kg * heavy_v + light_kg * ball_v) / (heavy_kg + light_kg)
        pull = apparatus.heavy.acceleration(heavy_m, common) - apparatus.light.acceleration(
            ball_m, common
        )
        pressed = pull <= apparatus.resting_acceleration_m_s2
        hold = Hold.TOGETHER if pressed else Hold.APART
        return Anchor(time_s, heavy_m, common, ball_m, common, hold)
    return Anchor(time_s, heavy_m, heavy_v, ball_m, ball_v, Hold.APART)


def _settle_both(apparatus: Apparatus, time_s: float) -> Anchor:
    """Decide the same where wall, ball and cylinder touch and nothing moves."""
    heavy = apparatus.heavy.acceleration(0.0, 0.0)
    light = apparatus.light.acceleration(0.0, 0.0)
    joint = apparatus.heavy_kg * heavy + apparatus.light_kg * light
    joint /= apparatus.heavy_kg + apparatus.light_kg
    slight = apparatus.resting_acceleration_m_s2
    if heavy <= slight and joint <= slight:
        hold = Hold.PINNED
    elif heavy - light <= slight:
        hold = Hold.TOGETHER
    elif light <= slight:
        hold = Hold.BALL_ON_WALL
    else:
        hold = Hold.APART
    return Anchor(time_s, 0.0, 0.0, 0.0, 0.0, hold)


Contact = Literal["bodies", "wall", "parting", "none"]


def _next_event(apparatus: Apparatus, anchor: Anchor) -> tuple[float, Contact]:
    """Time of flight to the next event and what touches then; inf if nothing will happen."""
    _, heavy_m, heavy_v, ball_m, ball_v, hold = anchor
    if hold is Hold.PINNED:
        return math.inf, "none"
    heavy_law, ball_law = apparatus.laws(hold)
    window_s = min(heavy_law.valid_for_s(heavy_v), ball_law.valid_for_s(ball_v))
    heavy = Mover(heavy_law, heavy_m, heavy_v)
    ball = Mover(ball_law, ball_m, ball_v)
    flight_s = window_s
    contact: Contact = "none"
    if hold is not Hold.BALL_ON_WALL:
        wall_s = contact_s(ball, WALL, flight_s)
        if wall_s <= flight_s and wall_s < math.inf:
            flight_s, contact = wall_s, "wall"
    if hold is Hold.TOGETHER:
        parting_s = apparatus.parting_s(heavy_m, heavy_v, flight_s)
        return (parting_s, "parting") if parting_s < flight_s else (flight_s, contact)
    bodies_s = contact_s(heavy, ball, flight_s)
    if bodies_s <= flight_s and bodies_s < math.inf:
        flight_s, contact = bodies_s, "bodies"
    return flight_s, contact


def _fly(apparatus: Apparatus, anchor: Anchor, flight_s: float, contact: Contact) -> Anchor:
    """State at the end of a flight; bodies that touch are set to touch exactly."""
    time_s, heavy_m, heavy_v, ball_m, ball_v, hold = anchor
    heavy_law, ball_law = apparatus.laws(hold)
    rise, heavy_v = heavy_law.advance(heavy_m, heavy_v, flight_s)
    fall, ball_v = ball_law.advance(ball_m, ball_v, flight_s)
    heavy_m = heavy_m + rise
    ball_m = heavy_m if hold is Hold.TOGETHER else ball_m + fall
    if contact == "wall":
        heavy_m = 0.0 if hold is Hold.TOGETHER else max(0.0, heavy_m)
        ball_m = 0.0
    elif contact == "bodies":
        ball_m = max(0.0, ball_m)
        heavy_m = ball_m
    return Anchor(time_s + flight_s, heavy_m, heavy_v, ball_m, ball_v, hold)


def _meet(
    apparatus: Apparatus, arrived: Anchor, contact: Contact, restitution: Restitution
) -> tuple[Anchor, Impact | None]:
    """Bounce if the contact is quick enough, then see who stays together."""
    time_s, heavy_m, heavy_v, ball_m, ball_v, _ = arrived
    if contact == "wall":
        if -ball_v <= apparatus.resting_speed_m_s:
            return settle(apparatus, arrived._replace(ball_velocity_m_s=0.0)), None
        bounce = restitution("wall")
        after = Anchor(time_s, heavy_m, heavy_v, ball_m, -bounce * ball_v, Hold.APART)
        return settle(apparatus, after), Impact("wall", heavy_v, ball_v, bounce)
    if contact == "bodies":
        approach = ball_v - heavy_v
        if approach <= apparatus.resting_speed_m_s:
            return settle(apparatus, arrived), None
        bounce = restitution("bodies")
        # Equal and opposite impulses: (1 + e) times the reduced mass times the approach.
        impulse = (1.0 + bounce) * approach / (apparatus.heavy_kg + apparatus.light_kg)
        after_heavy = heavy_v + apparatus.light_kg * impulse
        after_ball = ball_v - apparatus.heavy_kg * impulse
        after = Anchor(time_s, heavy_m, after_heavy, ball_m, after_ball, Hold.APART)
        return settle(apparatus, after), Impact("bodies", heavy_v, ball_v, bounce)
    if contact == "parting":  # known, not to be judged again from rounded numbers
        return arrived._replace(hold=Hold.APART), None
    return settle(apparatus, arrived), None

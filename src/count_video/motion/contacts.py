"""Contacts fitted one by one: when each was, and how fast the bodies were before and after it.

Each contact takes a step after another by its own equations (see ``contact_equations``), by Gauss's
and Newton's method; what the others of its kind say of where it is counts as one observation more.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from count_video.motion.contact_equations import JUMP, VELOCITY, WIDTH, Body, Equations
from count_video.motion.descent import weights_of
from count_video.motion.errors_of_places import HALF_EXPOSURE, Errors, errors_about
from count_video.motion.flight import motion_of
from count_video.motion.priors import CONTACT_STRAY_SHARE, TIME_MOVES_FRAMES
from count_video.records import Collision, Floats, Velocities
from count_video.signals import sigma_of, weighted_quantile

Kind = Literal["wall", "far", "bodies"]
"""What touches: the ball and a wall at smaller places, one at larger places, or both bodies."""
BodyErrors = tuple[Errors | None, ...]
"""How the places of each body vary together; None where its flights say too little."""

STEPS_AT_MOST, SETTLED_FRAMES = 6, 0.02
"""Steps are taken until the times move by less than this; in all but the first one contacts are
held to the place that they share."""


@dataclass(frozen=True)
class Contacts:
    """All contacts as fitted."""

    collisions: tuple[Collision, ...]
    """In order of time, all of them seen; velocities are NaN where not shown."""
    distance_px: float
    """Between the bodies' reference points where they touch; NaN where none is seen to."""
    errors: BodyErrors
    """Of the places of each body."""


class _Fitted(NamedTuple):
    """One contact: values and standard uncertainties; rates before and after, (2, bodies)."""

    moved: float
    """By how much it is later than it was taken to be, in frames."""
    moved_sigma: float
    ball_px: float
    touch_px: float
    """Place of the ball, or distance of the bodies where they touch, by this contact alone."""
    touch_sigma: float
    rate: Floats
    rate_sigma: Floats


def fit_contacts(
    frame: Floats,
    places: Sequence[Floats],
    contacts: Sequence[tuple[float, Kind]],
    touching: float = HALF_EXPOSURE,
    sign: int = 1,
    ends: Sequence[float] = (),
) -> Contacts:
    """Fit contacts of known kinds, in order of time, from rough frame coordinates.

    Parameters
    ----------
    frame, places
        Frame coordinates, and the places in px of the ball, then of the heavy body where there is
        one; shape (n,) each, NaN where not seen.
    contacts
        Rough frame coordinate and kind of each.
    touching
        Frames on either side of a contact that may show it; more of them for soft bodies.
    sign
        -1 where the collisions have places and velocities of the other sign.
    ends
        Frame coordinates at which flights of the ball may end too.
    """
    kinds = [kind for _, kind in contacts]
    times = np.array([time for time, _ in contacts], dtype=np.float64)
    bodies = _bodies(frame, places, kinds, times, touching, ends)
    fitted: list[_Fitted] = []
    for number in range(STEPS_AT_MOST):
        shared = _shared(kinds, fitted, bodies) if number else {}
        fitted = [
            _step(bodies, times, n, shared.get(kind), touching) for n, kind in enumerate(kinds)
        ]
        moved = np.array([one.moved for one in fitted])
        times = times + np.clip(moved, *_reach(times))
        if number and np.abs(moved).max(initial=0.0) < SETTLED_FRAMES:
            break
    found = zip(kinds, times.tolist(), fitted, strict=True)
    return Contacts(
        collisions=tuple(_collision(sign, *one) for one in found),
        distance_px=_shared(kinds, fitted, bodies).get("bodies", (np.nan, np.nan))[0],
        errors=tuple(body.errors for body in bodies),
    )


def _bodies(
    frame: Floats,
    places: Sequence[Floats],
    kinds: Sequence[Kind],
    times: Floats,
    touching: float,
    ends: Sequence[float],
) -> list[Body]:
    """Describe the paths; the errors of places are measured about the flights between contacts."""
    found = []
    for number, place in enumerate(places):
        jumps = np.array([number == 0 or kind == "bodies" for kind in kinds], dtype=bool)
        errors = errors_about(frame, place, times[jumps].tolist(), touching)
        sigma = max(sigma_of(place), errors.sigma_px if errors else 0.0)
        others = np.array([] if number else ends, dtype=np.float64)
        found.append(Body(motion_of(frame, place), errors, sigma, jumps, others))
    return found


def _reach(times: Floats) -> tuple[Floats, Floats]:
    """How far contacts may move in one step, backward and forward; their order stays."""
    between = 0.45 * np.diff(times)
    before, after = np.append(np.inf, between), np.append(between, np.inf)
    return -np.minimum(before, TIME_MOVES_FRAMES), np.minimum(after, TIME_MOVES_FRAMES)


def _shared(
    kinds: Sequence[Kind], fitted: Sequence[_Fitted], bodies: Sequence[Body]
) -> dict[Kind, tuple[float, float]]:
    """Place (distance, of bodies) that the contacts of each kind share, and its uncertainty.

    The surest contacts say most; those of two bodies of which one is not seen say nothing. Of one
    alone the uncertainty is infinite: no other bears it out.
    """
    shared: dict[Kind, tuple[float, float]] = {}
    stray = CONTACT_STRAY_SHARE * max(body.sigma_px for body in bodies)
    for kind in set(kinds) - ({"bodies"} if len(bodies) == 1 else set()):
        own = [one for one, its in zip(fitted, kinds, strict=True) if its == kind]
        places = np.array([one.touch_px for one in own])
        weights = np.array([1 / (one.touch_sigma**2 + stray**2) for one in own])
        level = weighted_quantile(places, weights, 0.5)
        scatter = float(np.sqrt(weights @ (places - level) ** 2 / weights.sum()))
        sigma = float(np.hypot(stray, scatter / np.sqrt(len(own))))
        shared[kind] = level, sigma if len(own) > 1 else np.inf
    return shared


def _step(
    bodies: Sequence[Body],
    times: Floats,
    number: int,
    held: tuple[float, float] | None,
    touching: float,
) -> _Fitted:
    """Take one step of one contact, which may be held to a place with its uncertainty."""
    equations = Equations(bodies, times, number, touching)
    values = equations.solved()
    weight = weights_of(equations.design @ values - equations.place)
    values, covariance = equations.solved(weight), equations.covariance(weight)
    touch = equations.touch(values)
    touch_px, touch_sigma = equations.touch_px(values), float(np.sqrt(touch @ covariance @ touch))
    if held is not None and np.isfinite(held[1]):
        equations.hold(*held, values)
        values, covariance = equations.solved(weight), equations.covariance(weight)
    # Velocities before and after the contact are sums of these coefficients.
    sums = np.zeros((2, len(bodies), len(values)))
    for k in range(len(bodies)):
        sums[:, k, WIDTH * k + VELOCITY] = sums[1, k, WIDTH * k + JUMP] = 1.0
    sums *= equations.scale
    variances = np.einsum("abi,ij,abj->ab", sums, covariance, sums)
    return _Fitted(
        moved=float(values[-1]) * TIME_MOVES_FRAMES,
        moved_sigma=float(np.sqrt(covariance[-1, -1])) * TIME_MOVES_FRAMES,
        ball_px=float(values[0] * equations.scale[0] + equations.middle_px[0]),
        touch_px=touch_px,
        touch_sigma=touch_sigma,
        rate=np.where(equations.shown, sums @ values, np.nan),
        rate_sigma=np.where(equations.shown, np.sqrt(np.maximum(variances, 0.0)), np.nan),
    )


def _collision(sign: int, kind: Kind, frame: float, fitted: _Fitted) -> Collision:
    velocities, bodies = np.full((2, 4), np.nan), fitted.rate.shape[1]
    velocities[:, :bodies], velocities[:, 2 : 2 + bodies] = sign * fitted.rate, fitted.rate_sigma
    before, after = (Velocities(*each) for each in velocities.tolist())
    return Collision(
        kind="bodies" if kind == "bodies" else "wall",
        frame=frame,
        frame_sigma=fitted.moved_sigma,
        seen=True,
        position_px=sign * fitted.ball_px,
        velocity_before=before,
        velocity_after=after,
    )

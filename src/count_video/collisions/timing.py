"""How sure the time of a collision is, where errors of places last for more than a frame.

The time lies where the fits of both sides cross, so its error is a sum of the errors of all places
that support them, weighted by the fits. What lasts as long as both sides moves them alike and
shifts no crossing; what lasts for a few frames does, by more than white noise of the same size.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from count_video.collisions.candidates import FEW_POINTS, Candidate, signal_of
from count_video.collisions.gaps import Gaps
from count_video.collisions.onesided import HALF_EXPOSURE, fit_weights, widest_needed
from count_video.lasting import Errors, errors_of, flight_of
from count_video.records import CollisionKind, Floats
from count_video.signals import sigma_of

KINDS: tuple[CollisionKind, ...] = ("wall", "bodies")


def with_true_sigmas(found: Sequence[Candidate], gaps: Gaps) -> list[Candidate]:
    """Enlarge the uncertainties of the times by what lasts of the errors, in order of time."""
    errors = {kind: _errors(found, gaps.frame, signal_of(kind, gaps)) for kind in KINDS}
    frames = [-np.inf, *(candidate.frame for candidate in found), np.inf]
    return [
        _with_true_sigma(candidate, gaps, (frames[place], frames[place + 2]), errors)
        for place, candidate in enumerate(found)
    ]


def _errors(found: Sequence[Candidate], frame: Floats, signal: Floats) -> Errors | None:
    """Measure the errors of a gap about its flights from collision to collision."""
    if not np.isfinite(signal).any():
        return None
    centred = signal - np.nanmean(signal)
    limits = [-np.inf, *(candidate.frame for candidate in found), np.inf]
    flights = []
    for before, after in pairwise(limits):
        rows = (frame > before + HALF_EXPOSURE) & (frame < after - HALF_EXPOSURE)
        flight = flight_of(frame[rows], centred[rows])
        if flight is not None:
            flights.append(flight)
    return errors_of(flights)


def _with_true_sigma(
    candidate: Candidate,
    gaps: Gaps,
    limits: tuple[float, float],
    errors: dict[CollisionKind, Errors | None],
) -> Candidate:
    error = errors[candidate.kind]
    corner = candidate.corner
    if error is None or corner is None:
        return candidate
    signal = signal_of(candidate.kind, gaps)
    sigma = sigma_of(signal)
    sides = [widest_needed(gaps.frame, signal, candidate.frame, limit, sigma) for limit in limits]
    if min(len(rows) for rows in sides) < FEW_POINTS:
        return candidate
    before, after = (
        fit_weights(gaps.frame[rows], signal[rows], candidate.frame, sigma) for rows in sides
    )
    weights = np.concatenate([before, -after]) / (corner.slope_after - corner.slope_before)
    variance = error.variance_of(gaps.frame[np.concatenate(sides)], weights)
    return replace(candidate, frame_sigma=max(candidate.frame_sigma, float(np.sqrt(variance))))

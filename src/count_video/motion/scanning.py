r"""Contacts whose rows are held to the wrong side of them, and where these contacts belong.

Least squares holds each row to one flight, and leaves out those that a contact's exposure may
touch. Where contacts follow each other within three frames a flight has one row or two. One that is
held to the wrong side of a contact keeps the contact there: a local minimum, from which no small
step leads away. So each contact is also tried at other times between its neighbours, these and all
else as they are, and every row counts wherever the contact is. Rows near it are means over an
exposure that is not known: with J the step of the velocity and h half the longest exposure they lie

    x(f) .. x(f) + J (h - |f - t|)^2 / (4 h)

between the sharp corner and what the longest exposure makes of it; no place in between costs
anything.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from count_video.motion.model import Model
from count_video.motion.pieces import WINDOW_FRAMES
from count_video.motion.priors import CAUCHY_SIGMAS, TIME_MOVES_FRAMES
from count_video.records import Floats

STEP_FRAMES = 0.125
"""Between times that are tried: the fit that follows has but to find the right rows."""

FLIGHT_FRAMES = 2.2
"""Where flights take less on average, frames show fewer rows than there are unknowns: they catch a
zigzag, and where its corners are they do not tell. Then all is left to a model of the burst."""


@dataclass(frozen=True)
class _Flown:
    """What the scan takes from a solution and leaves as it is."""

    frame: Floats
    """Frames that show the ball, shape (n,)."""
    place_px: Floats
    """Its places less what a swing adds to its path, shape (n,)."""
    bend: Floats
    """Accelerations of its flights, shape (contacts + 1,)."""
    sigma_px: float


def scanned(model: Model, values: Floats) -> Floats:
    """Move contacts in a crowd to where all rows around them fit best, one after the other.

    Parameters
    ----------
    model, values
        A model and its parameters, shape (columns,).

    Returns
    -------
    array
        Times of all contacts, shape (contacts,).
    """
    count = len(model.times)
    times = values[:count].copy()
    # Four flights are two before a contact and two after it, or all that are there.
    first, last = (np.clip(np.arange(1, count - 1) + by, 0, count - 1) for by in (-2, 2))
    if np.any(times[last] - times[first] < FLIGHT_FRAMES * (last - first)):
        return times
    apart, flights = np.diff(times), times[2:] - times[:-2]
    shown = np.minimum(apart[1:], apart[:-1]) > model.touching
    crowded = np.flatnonzero(shown & (flights < WINDOW_FRAMES)) + 1
    if len(crowded) == 0:
        return times
    flown, place = _flown(model, values), model.nodes(values)[0][0].copy()
    path = _heavy_path(model, values)
    offsets = np.arange(-TIME_MOVES_FRAMES, TIME_MOVES_FRAMES + STEP_FRAMES / 2, STEP_FRAMES)
    for contact in crowded.tolist():
        before, now, after = times[contact - 1 : contact + 2]
        tried = now + offsets
        tried = tried[(tried - before > model.touching) & (after - tried > model.touching)]
        tried = np.append(now, tried)
        there = np.full(len(tried), place[contact])
        if model.meets[contact]:
            step = np.interp(tried, *path) - np.interp(now, *path)
            there += step * (1 - values[model.parallax])
        ends = np.array([[before, place[contact - 1]], [after, place[contact + 1]]])
        best = int(np.argmin(_losses(flown, contact, (tried, there), ends, model.touching)))
        times[contact], place[contact] = tried[best], there[best]
    return times


def _flown(model: Model, values: Floats) -> _Flown:
    signal, own = model.paths.ball_px, model.body[model.piece_of] == 0
    seen = np.isfinite(signal)
    frame = model.paths.frame[seen]
    ends = model.times
    at = np.concatenate([model.frame[own], ends])
    order = np.argsort(at)
    swung = np.append(model.swung[own], np.zeros(len(ends)))[order]
    bend = np.full(len(ends) + 1, 0.0)
    for number, piece in enumerate(model.pieces):
        if piece.body == 0 and piece.spans:
            bend[piece.ends[1]] = values[model.bends + number]
    fallen = values[model.swings] * np.interp(frame, at[order], swung)
    return _Flown(frame, signal[seen] - fallen, bend, float(model.sigma[0]))


def _heavy_path(model: Model, values: Floats) -> tuple[Floats, Floats]:
    """Frames and modelled places of the heavy body, with its contacts."""
    if len(model.paths.signals) == 1:
        return np.zeros(1), np.zeros(1)
    own = model.body[model.piece_of] == 1
    frame = np.concatenate([model.frame[own], values[: len(model.times)][model.meets]])
    place = np.concatenate([model.modelled(values)[0][own], values[model.heavy[model.meets]]])
    order = np.argsort(frame)
    return frame[order], place[order]


def _losses(
    flown: _Flown, contact: int, tried: tuple[Floats, Floats], ends: Floats, touching: float
) -> Floats:
    """Robust sums of squares of the rows between two contacts, shape (tried,).

    ``tried`` are times and places of the contact between them.
    """
    inside = slice(*np.searchsorted(flown.frame, ends[:, 0] + [touching, -touching]))
    frame, time, place = flown.frame[inside], tried[0][:, None], tried[1][:, None]
    paths, rates = [], []
    for end, bend, side in zip(ends, flown.bend[contact : contact + 2], (1, -1), strict=True):
        rate = (place - end[1]) / (time - end[0])
        paths.append(end[1] + (frame - end[0]) * (rate + bend / 2 * (frame - time)))
        rates.append(rate + side * bend / 2 * np.abs(time - end[0]))
    sharp = np.where(frame < time, *paths) - flown.place_px[inside]
    near = np.maximum(touching - np.abs(frame - time), 0.0)
    blurred = sharp + (rates[1] - rates[0]) * near**2 / (4 * touching)
    off = np.where(sharp * blurred < 0, 0.0, np.minimum(np.abs(sharp), np.abs(blurred)))
    unit = off / flown.sigma_px / CAUCHY_SIGMAS
    return np.asarray(np.log1p(unit**2).sum(axis=1))

"""Long clips in batches of contacts: the fit of many contacts at once costs their number cubed.

Contacts far apart have in common only where they happen and how large the errors of places are,
and some dozens give both. Each batch also fits some contacts of its neighbours, whose flights its
outermost contacts need, and leaves them to these.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from count_video.motion.joint import USUAL, Contacts, Fitting, Motion, fit_together
from count_video.motion.model import Kind, Paths
from count_video.signals import Errors

BATCH_CONTACTS = 64
"""More contacts than this are fitted in batches of about so many."""
OF_CONTACTS = ("frame", "frame_sigma", "ball_px", "stray_px", "stray_sigma")
OF_MOTIONS = ("rate", "sigma", "jump_sigma", "rows")
"""What contacts and the motions of bodies have one value a contact of."""
SHARED_CONTACTS = 4
"""Contacts of each neighbour that a batch fits too: both bodies' flights to either side."""


def fit_contacts(
    paths: Paths, kinds: Sequence[Kind], frames: Sequence[float], how: Fitting = USUAL
) -> Contacts:
    """Fit contacts of known kinds, in order of time, from rough frame coordinates."""
    count = len(frames)
    ends = np.linspace(0, count, -(-count // BATCH_CONTACTS) + 1).astype(int).tolist()
    if len(ends) <= 2:
        return fit_together(paths, kinds, frames, how)
    parts = []
    for first, last in pairwise(ends):
        low, high = max(0, first - SHARED_CONTACTS), min(count, last + SHARED_CONTACTS)
        before = frames[low - 1] + how.touching if low else -np.inf
        after = frames[high] - how.touching if high < count else np.inf
        near = _between(paths, before, after)
        if not all(np.isfinite(signal).any() for signal in near.signals):
            return fit_together(paths, kinds, frames, how)
        found = fit_together(near, kinds[low:high], frames[low:high], how)
        parts.append(_part(found, slice(first - low, last - low)))
    return _joined(parts)


def _between(paths: Paths, before: float, after: float) -> Paths:
    rows = slice(*np.searchsorted(paths.frame, [before, after], side="right").tolist())
    heavy = None if paths.heavy_px is None else paths.heavy_px[rows]
    return Paths(paths.frame[rows], paths.ball_px[rows], heavy)


def _part(found: Contacts, kept: slice) -> Contacts:
    """Keep some of the contacts of a batch."""
    return replace(
        found,
        kinds=found.kinds[kept],
        bodies=tuple(
            Motion(*(getattr(body, name)[kept] for name in OF_MOTIONS)) for body in found.bodies
        ),
        **{name: getattr(found, name)[kept] for name in OF_CONTACTS},
    )


def _joined(parts: Sequence[Contacts]) -> Contacts:
    """Join the contacts of all batches, which stray from places that all of them share."""
    kinds = tuple(kind for part in parts for kind in part.kinds)
    frame, frame_sigma, ball, stray, stray_sigma = (
        np.concatenate([getattr(part, name) for part in parts]) for name in OF_CONTACTS
    )
    distances = np.concatenate([np.full(len(part.kinds), part.distance_px) for part in parts])
    distance = float(np.median(distances[np.isfinite(distances)])) if "bodies" in kinds else np.nan
    for kind in set(kinds):
        own = np.array([one == kind for one in kinds])
        place = -distances[own] if kind == "bodies" else (ball - stray)[own]
        stray[own] += place - np.median(place)
    return Contacts(
        kinds=kinds,
        frame=frame,
        frame_sigma=frame_sigma,
        ball_px=ball,
        stray_px=stray,
        stray_sigma=stray_sigma,
        bodies=tuple(map(_motion, zip(*(part.bodies for part in parts), strict=True))),
        distance_px=distance,
        errors=tuple(map(_mean, zip(*(part.errors for part in parts), strict=True))),
    )


def _motion(parts: Sequence[Motion]) -> Motion:
    return Motion(*(np.concatenate([getattr(part, name) for part in parts]) for name in OF_MOTIONS))


def _mean(errors: Sequence[Errors | None]) -> Errors | None:
    """Take the mean errors of those batches that have any."""
    known = [one for one in errors if one is not None]
    if not known:
        return None
    white = float(np.mean([one.white_px2 for one in known]))
    return Errors(white, np.asarray(np.mean([one.lasting_px2 for one in known], axis=0)))

"""Paths of bodies that are roughly known: their direction, and which pictures to learn from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from count_video.records import Floats, Indices
from count_video.tracking.shape import Box, Shape, known_of

PICTURES = 30
"""A template is learnt from so many: those that show something new of a body. Pictures in which it
rests, or two move along side by side, are many and show nothing new."""
PLACE_NOISE_PX, STRAIGHT_SHARE = 1.0, 0.1
"""Paths of regions are right to about so much, and bodies on threads leave a straight line by such
a share of their way: a longer path is no straighter one."""
PLACE_BIN_PX = 3.0
"""Pictures with the same bin of places, or of distances to the neighbour, are alike."""
STEADY_PX = 0.3
"""From one sample to the next but one a body moves steadily but for about so much, as corners are
followed; where it is struck, by far more."""


@dataclass(frozen=True, eq=False)
class Rough:
    """A body as its corners show it; positions are those of a point that moves with it."""

    path_px: Floats
    """Image x and y of that point in each sample, shape (samples, 2); NaN where it is not seen."""
    box: Box
    """Around the corners, from that point."""
    fence: tuple[float, float]
    """Image x, from that point, beyond which the neighbours' corners begin."""
    corners: Shape
    """Its outermost corners."""
    blurred: bool = False
    """Whether the path is that of a region, right to some px only."""
    sure: bool = True
    """Whether many corners show it: its path is exact and its box that of a body."""
    again: bool = False
    """Whether it was learnt before, so that its box and its places are known."""


def direction_deg(roughs: Sequence[Rough]) -> float:
    """Find the direction of most paths, in (-90, 90] degrees from image x.

    Each counts by how much likelier it is along its own line than without any direction: so do the
    straight paths of bodies that many samples show, and not the far and winding one of a hand. What
    only a region or few corners show counts where nothing else does: threads and what bodies hide
    in turn make regions that seem to move in any direction.
    """
    turned = 0j
    for rough in [rough for rough in roughs if rough.sure] or roughs:
        path = known_of(rough.path_px)
        away = path - path.mean(axis=0)
        moments = away.T @ away
        across, along = np.linalg.eigvalsh(moments) / len(path) + PLACE_NOISE_PX**2
        across = max(across, STRAIGHT_SHARE**2 * along)
        twice = np.angle(moments[0, 0] - moments[1, 1] + 2j * moments[0, 1])
        turned += len(path) / 2 * np.log(along / across) * np.exp(1j * twice)
    return float(np.degrees(np.angle(turned) / 2))


def unsteadiness(paths_px: Sequence[Floats], frames: Indices) -> float:
    """How unlikely paths are of bodies that move steadily between samples, but where struck.

    It is the negative logarithm of the likelihood if their places depart from those half-way
    between two others by Cauchy errors, but for a constant. The two are next to each, or twice as
    far, and so on: slow motion shows between distant ones, of which so many fewer are independent.
    Paths have shape (samples, 2), NaN where not known; ``frames`` are those of the samples, shape
    (samples,).
    """
    total = 0.0
    for path in paths_px:
        known = np.flatnonzero(np.isfinite(path[:, 0]))
        time, place, apart = frames[known].astype(np.float64), path[known], 1
        while 2 * apart < len(known):
            before, here, after = (
                slice(k * apart, k * apart - 2 * apart or None) for k in range(3)
            )
            later = ((time[here] - time[before]) / (time[after] - time[before]))[:, None]
            away = place[here] - place[before] * (1 - later) - place[after] * later
            total += float(np.log1p((away / STEADY_PX) ** 2).sum()) / apart
            apart *= 2
    return total


def only(path_px: Floats, samples: Indices) -> Floats:
    """Leave out all places of a path but those in some samples."""
    some = np.full(path_px.shape, np.nan)
    some[samples] = path_px[samples]
    return some


def choose(path_px: Floats, others_px: Sequence[Floats]) -> Indices:
    """Choose samples to learn from, evenly spread by their rarity.

    ``path_px`` is that of the body, ``others_px`` are those by which samples are known to be alike.
    """
    samples = np.flatnonzero(np.isfinite(path_px[:, 0]))
    if len(samples) <= PICTURES:
        return samples
    share = np.cumsum(_inclusion(_rarity(path_px, others_px)[samples]))
    picked = np.searchsorted(share, np.arange(PICTURES) + 0.5)
    return np.asarray(samples[np.unique(picked)])


def _inclusion(weight: Floats) -> Floats:
    """Probability of each picture to be among those chosen: by its weight, but never above 1.

    Where n of them are certain, the others share what is left (Sarndal, Swensson and Wretman
    1992, section 3.6):

        p_k = min(1, (PICTURES - n) w_k / sum of w over the others).
    """
    order = np.argsort(-weight, kind="stable")
    others = np.cumsum(weight[order][::-1])[::-1][:PICTURES]
    each = (PICTURES - np.arange(PICTURES)) / others
    certain = int(np.argmax(each * weight[order[:PICTURES]] <= 1))
    return np.asarray(np.minimum(each[certain] * weight, 1.0))


def _rarity(path_px: Floats, others_px: Sequence[Floats]) -> Floats:
    """Weight of each sample: rare places and rare distances from other bodies count more."""
    weight, x = np.ones(len(path_px)), path_px[:, 0]
    for place in (x, *(other[:, 0] - x for other in others_px)):
        known = np.isfinite(place)
        bins = np.rint(place[known] / PLACE_BIN_PX)
        _, each, count = np.unique(bins, return_inverse=True, return_counts=True)
        weight[known] *= 1 / count[each]
    return weight

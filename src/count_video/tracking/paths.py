"""Paths of bodies that are roughly known: their direction, and which pictures to learn from."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from count_video.records import Floats
from count_video.tracking.shape import Box, Place, Shape

PICTURES = 30
"""A template is learnt from so many: those that show something new of a body. Pictures in which it
rests, or two move along side by side, are many and show nothing new."""
PLACE_NOISE_PX, STRAIGHT_SHARE = 1.0, 0.1
"""Paths of regions are right to about so much, and bodies on threads leave a straight line by such
a share of their way: a longer path is no straighter one."""
PLACE_BIN_PX = 3.0
"""Pictures with the same bin of places, or of distances to the neighbour, are alike."""


@dataclass(frozen=True)
class Rough:
    """A body as its corners show it; positions are those of a point that moves with it."""

    path_px: Mapping[int, Place]
    """Frame index -> image x and y of that point."""
    box: Box
    """Around the corners, from that point."""
    fence: tuple[float, float]
    """Image x, from that point, beyond which the neighbours' corners begin."""
    blurred: bool = False
    """Whether the path is that of a region, right to some px only."""
    sure: bool = True
    """Whether many corners show it: its path is exact and its box that of a body."""
    corners: Shape | None = None
    """Its outermost corners."""


def line_tilt_deg(roughs: Sequence[Rough]) -> float:
    """Find the common direction of paths, in (-90, 90] degrees from image x."""
    moments = np.sum([_moments(rough) for rough in roughs], axis=0)
    return _direction_deg(moments)


def common_direction_deg(roughs: Sequence[Rough]) -> float:
    """Find the direction of most paths, in (-90, 90] degrees from image x.

    Each counts by how much likelier it is along its own line than without any direction: so do the
    straight paths of bodies that many samples show, and not the far and winding one of a hand. What
    only a region or few corners show counts where nothing else does: threads and what bodies hide
    in turn make regions that seem to move in any direction.
    """
    turned = 0j
    for rough in [rough for rough in roughs if rough.sure] or roughs:
        count, moments = len(rough.path_px), _moments(rough)
        across, along = np.linalg.eigvalsh(moments) / count + PLACE_NOISE_PX**2
        across = max(across, STRAIGHT_SHARE**2 * along)
        twice = 2 * np.radians(_direction_deg(moments))
        turned += count / 2 * np.log(along / across) * np.exp(1j * twice)
    return float(np.degrees(np.angle(turned) / 2))


def _moments(rough: Rough) -> Floats:
    """Sum squares and products of a path's places about their mean, shape (2, 2)."""
    path = np.array(list(rough.path_px.values()))
    away = path - path.mean(axis=0)
    return np.asarray(away.T @ away)


def _direction_deg(moments: Floats) -> float:
    return float(np.degrees(0.5 * np.arctan2(2 * moments[0, 1], moments[0, 0] - moments[1, 1])))


def choose(path: Mapping[int, Place], others: Sequence[Mapping[int, Place]]) -> list[int]:
    """Choose pictures to learn from, by their frame index, evenly spread by their rarity.

    ``path`` is that of the body, ``others`` are those by which pictures are known to be alike.
    """
    rarity = _rarity(path, others)
    frames = sorted(rarity)
    if len(frames) <= PICTURES:
        return frames
    share = np.cumsum(_inclusion(np.array([rarity[frame] for frame in frames])))
    picked = np.searchsorted(share, np.arange(PICTURES) + 0.5)
    return [frames[place] for place in np.unique(picked)]


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


def _rarity(path: Mapping[int, Place], others: Sequence[Mapping[int, Place]]) -> dict[int, float]:
    """Weight of each picture: rare places and rare distances from other bodies count more."""
    bins = [{k: round(x / PLACE_BIN_PX) for k, (x, _) in path.items()}]
    for other in others:
        apart = {k: other[k][0] - x for k, (x, _) in path.items() if k in other}
        bins.append({k: round(x / PLACE_BIN_PX) for k, x in apart.items()})
    counts = [Counter(binned.values()) for binned in bins]
    return {
        k: float(np.prod([1 / c[b[k]] for b, c in zip(bins, counts, strict=True) if k in b]))
        for k in path
    }

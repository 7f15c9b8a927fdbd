"""Which pictures a template is learnt from: those that show something new of a body.

Pictures in which a body rests, or two move along side by side, are many and show nothing new.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence

import numpy as np

from count_video.tracking.shape import Place

PICTURES = 40
"""A template is learnt from so many."""
PLACE_BIN_PX = 3.0
"""Pictures with the same bin of places, or of distances to the neighbour, are alike."""


def choose(path: Mapping[int, Place], others: Sequence[Mapping[int, Place]]) -> list[int]:
    """Choose pictures to learn from, by their frame index, evenly spread by their rarity.

    ``path`` is that of the body, ``others`` are those by which pictures are told to be alike.
    """
    rarity = _rarity(path, others)
    frames = sorted(rarity)
    if len(frames) <= PICTURES:
        return frames
    share = np.cumsum([rarity[frame] for frame in frames])
    picked = np.searchsorted(share, (np.arange(PICTURES) + 0.5) / PICTURES * share[-1])
    return [frames[place] for place in np.unique(picked)]


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

"""What may be a body: by its corners where there are many, else by the region that moves."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from count_video.records import Floats
from count_video.tracking.corners import Trajectories
from count_video.tracking.paths import Rough
from count_video.tracking.regions import Regions, moving_regions
from count_video.tracking.rigid import RigidGroup, rigid_groups
from count_video.tracking.shape import Box, Shape

OUTER_CORNERS = (0.03, 0.08)
"""So many corners on each side, by x and by y, are left out of a body's box: a thread that moves
with it has some as well."""
BEYOND_CORNERS = 0.2
CORNER_MARGIN_PX = 4.0
"""The outline lies within this share of the height of the corners, and so many px, beyond them."""
FENCE_MARGIN_PX = 3.0
"""Corners lie so near to the edges they belong to."""
NEIGHBOUR_CORNERS = 8
"""A neighbour with fewer corners than this sets no bound to an outline."""
REGIONS_AT_MOST = 8
"""So many of the regions that change most are proposed."""
CHANGE_SHARE = 0.002
"""What makes a smaller share of all that changes in a clip is no body of its experiment."""


def propose(
    corners: Trajectories, regions: Regions, scene_px: Floats, all_change: float
) -> list[RigidGroup]:
    """Bodies by their corners where there are many, then moving regions and the other corners.

    Of these the ones that change most come first. ``scene_px`` is how far the camera has moved each
    sample, shape (samples, 2). Only what makes a fair share of ``all_change``, in grey levels times
    px, is proposed.
    """
    groups = rigid_groups(corners, scene_px)
    many = [group for group in groups if len(group.corners_px) >= NEIGHBOUR_CORNERS]
    few = [group for group in groups if len(group.corners_px) < NEIGHBOUR_CORNERS]
    proposed = [*many, *moving_regions(regions), *few]
    changes = [regions.change(one.path_px, box_of(one)) for one in proposed]
    order = sorted(range(len(proposed)), key=lambda k: (k >= len(many), -changes[k]))
    beyond = [k for k in order if proposed[k].blurred][REGIONS_AT_MOST:]
    clear = (k for k in order if changes[k] > CHANGE_SHARE * all_change)
    return [proposed[k] for k in clear if k not in beyond]


def box_of(group: RigidGroup) -> Box:
    """Box around most of a group's corners, from its path."""
    each = zip(group.corners_px.T, OUTER_CORNERS, strict=True)
    low, high = np.transpose([np.quantile(places, (part, 1 - part)) for places, part in each])
    margin = BEYOND_CORNERS * float(high[1] - low[1]) + CORNER_MARGIN_PX
    return (*(low - margin).tolist(), *(high + margin).tolist())


def roughly(
    proposals: Sequence[RigidGroup], scale: int, corner_px: tuple[int, int], *, turned: bool
) -> list[Rough]:
    """Turn px of samples into those of the pictures, whose x and y are swapped if ``turned``.

    Where the neighbours' corners begin is found as well.
    """
    axes = [1, 0] if turned else [0, 1]
    begin = np.add(corner_px, (scale - 1) / 2)
    whole = [
        RigidGroup(
            (one.path_px * scale + begin)[:, axes], (one.corners_px * scale)[:, axes], one.blurred
        )
        for one in proposals
    ]
    roughs = []
    for number, one in enumerate(whole):
        sure = not one.blurred and len(one.corners_px) >= NEIGHBOUR_CORNERS
        low, high = one.corners_px.min(axis=0).tolist(), one.corners_px.max(axis=0).tolist()
        corners = Shape(one.path_px, (*low, *high))
        ends = scale * np.reshape(box_of(proposals[number]), (2, 2))
        box: Box = tuple(ends[:, axes].ravel().tolist())
        fence = _fence(whole, number, box)
        roughs.append(Rough(one.path_px, box, fence, corners, one.blurred, sure))
    return roughs


def _fence(groups: Sequence[RigidGroup], number: int, box: Box) -> tuple[float, float]:
    """Image x, from the path of a body, between which its outline lies."""
    own = groups[number].corners_px
    left, _, right, _ = box
    begin, end = -np.inf, np.inf
    for other in groups:
        apart = other.path_px - groups[number].path_px
        known = np.isfinite(apart[:, 0])
        if other is groups[number] or len(other.corners_px) < NEIGHBOUR_CORNERS or not known.any():
            continue
        typical = np.median(apart[known], axis=0)
        above, below = other.corners_px[:, 1].min(), other.corners_px[:, 1].max()
        if typical[1] + below < own[:, 1].min() or typical[1] + above > own[:, 1].max():
            continue
        if typical[0] + float(other.corners_px[:, 0].mean()) > (left + right) / 2:
            nearest = float((apart[known, 0] + other.corners_px[:, 0].min()).min())
            end = min(end, max(nearest, float(own[:, 0].max())) + FENCE_MARGIN_PX)
        else:
            nearest = float((apart[known, 0] + other.corners_px[:, 0].max()).max())
            begin = max(begin, min(nearest, float(own[:, 0].min())) - FENCE_MARGIN_PX)
    return begin, end

"""From moving features to the line of motion and to the bodies that move along it.

In a run of a few frames a rigid body is a patch of features that share one velocity. The two
bodies of the experiment are neighbours on the line of motion and, in most runs, move at different
velocities: that is all that is used to tell them from each other and from what stands still.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from count_video.records import Floats
from count_video.tracking.pairs.features import MovingFeatures

FEATURES_AT_LEAST = 5
"""Fewer features with a common velocity are not taken for a body."""
DIRECTION_BIN_DEG = 2.0
OFF_LINE_DEG = 12.0
"""Features that move in another direction than this are not on the line of motion."""
TRAVEL_SCATTER_PX = 0.33
SPEED_SCATTER_RELATIVE = 0.06
"""Features of one rigid body agree to this much in their travel over a run, and to this share."""
SPACING_OVER_WIDTH = 0.08
"""Features of one body leave no wider gap between them, as a share of the picture's width."""

OVERLAP_PX = 4.0
"""Features are placed to half a window: boxes of bodies that touch may overlap so much."""
PATCHES_ACROSS = 12
"""So many of the best patches are paired across runs."""


@dataclass(frozen=True)
class Patch:
    """Features of one run that move together: a body, or a part of one."""

    frame: float
    """Frame coordinate of the middle of the run."""
    span_frames: float
    """From the first frame of the run to its last."""
    speed_px_frame: float
    """Common velocity along the line of motion."""
    left_px: float
    right_px: float
    top_px: float
    bottom_px: float
    """The box that holds the features' centres at ``frame``."""
    features: int
    grain_px: float = 1.0
    """That of the features."""

    @property
    def width_px(self) -> float:
        """Width of the box."""
        return self.right_px - self.left_px

    @property
    def height_px(self) -> float:
        """Height of the box."""
        return self.bottom_px - self.top_px


@dataclass(frozen=True)
class PatchPair:
    """Two neighbouring patches of one run, the left one first."""

    left: Patch
    right: Patch
    score: float
    """Number of features of the poorer patch, weighted by how well the velocities differ."""


def motion_direction_deg(runs: Sequence[MovingFeatures]) -> float | None:
    """Most common direction of motion, in (-90, 90] degrees from image x; None if nothing moves.

    Each feature votes with its speed, so that slow jitter has little to say.
    """
    x = np.concatenate([run.speed_x_px_frame for run in runs] or [np.empty(0)])
    y = np.concatenate([run.speed_y_px_frame for run in runs] or [np.empty(0)])
    if len(x) < FEATURES_AT_LEAST:
        return None
    angle = np.degrees(np.arctan2(y, x)) % 180.0
    weight = np.hypot(x, y)
    bins = int(180 / DIRECTION_BIN_DEG)
    votes = np.bincount((angle // DIRECTION_BIN_DEG).astype(int) % bins, weight, minlength=bins)
    votes = votes + np.roll(votes, 1) + np.roll(votes, -1)
    mode = (int(np.argmax(votes)) + 0.5) * DIRECTION_BIN_DEG
    away = (angle - mode + 90.0) % 180.0 - 90.0
    near = np.abs(away) < 3 * DIRECTION_BIN_DEG
    order = np.argsort(away[near])
    share = np.cumsum(weight[near][order])
    median = float(away[near][order][np.searchsorted(share, share[-1] / 2)])
    return 90.0 - (90.0 - (mode + median)) % 180.0


def patches(features: MovingFeatures, tilt_deg: float, width_px: int) -> list[Patch]:
    """Group the features of one run that move along the line into rigid patches, left to right.

    Parameters
    ----------
    features
        Of a picture whose line of motion is nearer to image x than to y.
    tilt_deg
        Direction of the line of motion.
    width_px
        Width of the picture, which sets how far features of one body may lie apart.
    """
    angle = np.degrees(np.arctan2(features.speed_y_px_frame, features.speed_x_px_frame))
    off = np.abs((angle - tilt_deg + 90.0) % 180.0 - 90.0)
    left = np.flatnonzero(off < OFF_LINE_DEG)
    found: list[Patch] = []
    while len(left) >= FEATURES_AT_LEAST:
        members = _largest_group(features, left, SPACING_OVER_WIDTH * width_px)
        if len(members) < FEATURES_AT_LEAST:
            break
        found.append(_patch(features, members))
        left = np.setdiff1d(left, members)
    return _join(sorted(_absorb(found), key=lambda patch: patch.left_px))


def _largest_group(
    features: MovingFeatures, candidates: NDArray[np.intp], spacing_px: float
) -> NDArray[np.intp]:
    """Find the candidates that share the most common velocity and lie together."""
    speed = features.speed_x_px_frame[candidates]
    tolerance = (
        TRAVEL_SCATTER_PX * features.grain_px / max(features.span_frames, 1.0)
        + SPEED_SCATTER_RELATIVE * np.abs(speed)
        + features.speed_sigma_px_frame[candidates]
    )
    agree = np.abs(speed[None, :] - speed[:, None]) < tolerance[:, None]
    best: NDArray[np.intp] = np.empty(0, dtype=np.intp)
    for row in agree[np.argsort(-agree.sum(axis=1))[:8]]:
        for group in _contiguous(features.x_px, candidates[row], spacing_px):
            if len(group) > len(best):
                best = group
    return best


def _contiguous(
    x_px: Floats, members: NDArray[np.intp], spacing_px: float
) -> list[NDArray[np.intp]]:
    """Split members where neighbours in x lie further apart than the spacing."""
    ordered = members[np.argsort(x_px[members])]
    breaks = np.flatnonzero(np.diff(x_px[ordered]) > spacing_px) + 1
    return list(np.split(ordered, breaks))


def _patch(features: MovingFeatures, members: NDArray[np.intp]) -> Patch:
    x, y = features.x_px[members], features.y_px[members]
    # Threads and shadows move along with a body; the box ends where the bulk of it does.
    top, bottom = np.quantile(y, (0.05, 0.95))
    return Patch(
        frame=features.frame,
        span_frames=features.span_frames,
        speed_px_frame=float(np.median(features.speed_x_px_frame[members])),
        left_px=float(x.min()),
        right_px=float(x.max()),
        top_px=float(top),
        bottom_px=float(bottom),
        features=len(members),
        grain_px=features.grain_px,
    )


def _absorb(found: Sequence[Patch]) -> list[Patch]:
    """Merge patches that overlap: reflections in a polished body lag behind the body itself.

    The velocity kept is that of the patch with more features.
    """
    merged: list[Patch] = []
    for patch in sorted(found, key=lambda p: -p.features):
        for place, host in enumerate(merged):
            shared = min(patch.right_px, host.right_px) - max(patch.left_px, host.left_px)
            if shared > 0.5 * min(patch.width_px, host.width_px):
                merged[place] = replace(
                    host,
                    left_px=min(patch.left_px, host.left_px),
                    right_px=max(patch.right_px, host.right_px),
                    features=host.features + patch.features,
                )
                break
        else:
            merged.append(patch)
    return merged


def _join(found: Sequence[Patch]) -> list[Patch]:
    """Merge neighbours that move alike: the two ends of a long body with a plain middle."""
    joined: list[Patch] = []
    for patch in found:
        last = joined[-1] if joined else None
        if last is not None and _alike(last, patch):
            joined[-1] = replace(
                last,
                right_px=max(last.right_px, patch.right_px),
                features=last.features + patch.features,
            )
        else:
            joined.append(patch)
    return joined


def _alike(one: Patch, other: Patch) -> bool:
    return abs(one.speed_px_frame - other.speed_px_frame) < _speed_noise(one, other)


def _speed_noise(one: Patch, other: Patch) -> float:
    fastest = max(abs(one.speed_px_frame), abs(other.speed_px_frame))
    span = max(min(one.span_frames, other.span_frames), 1.0)
    grain_px = max(one.grain_px, other.grain_px)
    return TRAVEL_SCATTER_PX * grain_px / span + SPEED_SCATTER_RELATIVE * fastest


def rank_pairs(runs: Sequence[Sequence[Patch]]) -> list[PatchPair]:
    """Pairs of patches, from all runs, that could be ball and cylinder; the best first."""
    pairs = [
        PatchPair(left, right, _score(left, right))
        for run in runs
        for left, right in pairwise(run)
        if left.right_px <= right.left_px + OVERLAP_PX and _level(left, right)
    ]
    return sorted((pair for pair in pairs if pair.score > 0), key=lambda pair: -pair.score)


def pairs_across_runs(runs: Sequence[Sequence[Patch]]) -> list[PatchPair]:
    """Pairs of patches from different runs, the best first: where the bodies move in turns.

    With equal masses one body stands while the other moves, and no run shows both moving.
    """
    every = sorted((patch for run in runs for patch in run), key=lambda patch: -patch.features)
    pairs = [
        PatchPair(left, right, float(min(left.features, right.features)))
        for left in every[:PATCHES_ACROSS]
        for right in every[:PATCHES_ACROSS]
        if left.frame != right.frame and left.right_px < right.left_px and _level(left, right)
    ]
    return sorted(pairs, key=lambda pair: -pair.score)


def _level(left: Patch, right: Patch) -> bool:
    """Bodies that can meet stand at the same height: half the lower one's height is shared."""
    shared = min(left.bottom_px, right.bottom_px) - max(left.top_px, right.top_px)
    return shared > 0.5 * min(left.height_px, right.height_px)


def _score(left: Patch, right: Patch) -> float:
    difference = abs(left.speed_px_frame - right.speed_px_frame) / _speed_noise(left, right)
    return min(left.features, right.features) * min(difference, 10.0) if difference > 3 else 0.0

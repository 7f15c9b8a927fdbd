"""A body whose look changes, found and followed by its silhouette beside a body that is steady.

A ball that spins shows another face in every picture, and no picture of it can be learnt. Of two
such neighbours the steady one is learnt and followed as ever. On its side towards the other,
whatever differs from the backdrop and lies on the line of motion is the body that was missed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from count_video.records import Floats, Frame
from count_video.tracking.looks.learning import NEAR_FRAMES, Body, learn
from count_video.tracking.looks.sightings import AGREEMENT_SHARE, Seed
from count_video.tracking.looks.sprite import look
from count_video.tracking.patches.blobs import disc
from count_video.tracking.patches.scenery import Luma
from count_video.tracking.silhouettes.silhouette import DARK, LIT, Backdrop, Beside, learn_backdrop

THREADS_PX = 7
"""Threads are thinner, and a ball is not: an opening by so much takes them off."""
CLEAR_PX = 4.0
"""A patch this far from the steady body is seen whole."""
CLEAR_AT_LEAST = 8
USUAL_SHARE = 0.5
"""Half of the patches show the body whole, or no more than its own half is learnt."""
SEEDS = 5
"""So many patches are learnt from in turn: the first may lie next to a collision."""
MARGIN_SHARE = 0.15
MARGIN_PX = 4
"""The box around a patch is larger on all sides by a share of its height and by some px."""
LOOKS = 4
"""The backdrop is learnt again from where the body does not hide it, and once more where the first
look saw no more than a part of the body."""
WHOLE_QUANTILE = 0.9
"""Patches are seen in parts or whole: among the larger ones is the size of the whole."""

Patch = tuple[int, int, int, int]
"""Left, top, right and bottom px of what is before the backdrop; the last two are beyond it."""


@dataclass(frozen=True)
class Line:
    """A line of motion in the picture."""

    x_px: float
    y_px: float
    slope: float

    def row(self, x_px: float) -> float:
        """Image y of the line at an image x."""
        return self.y_px + self.slope * (x_px - self.x_px)


def find_unsteady(
    runs: Sequence[Sequence[Frame]], beside: Beside, line: Line
) -> tuple[Body, Backdrop] | None:
    """Find a body by its silhouette, from runs of frames; None where there is none.

    None as well where its look does not change: such a body is followed better by its look.
    """
    runs = [[seen for seen in run if seen.index in beside.edge_px] for run in runs]
    runs = [run for run in runs if run]
    frames = [seen for run in runs for seen in run]
    if not frames:
        return None
    patches: dict[int, Patch] = {}
    for _ in range(LOOKS):
        backdrop = learn_backdrop(frames, beside, _hidden(patches, beside))
        shown = [[_shown(seen, backdrop) for seen in run] for run in runs]
        patches = _patches([seen for run in shown for seen in run], line)
    tilt_deg = float(np.degrees(np.arctan(line.slope)))
    for seed in _seeds(patches, beside):
        learnt = learn(shown, [seed], tilt_deg)
        if learnt is not None:
            return (learnt[0], backdrop) if _changes(frames, learnt[0]) else None
    return None


def _shown(seen: Frame, backdrop: Backdrop) -> Frame:
    silhouette = backdrop.silhouette(seen.index, seen.luma)
    return replace(seen, luma=silhouette)


def _patches(shown: Sequence[Frame], line: Line) -> dict[int, Patch]:
    """Largest patch on the line of motion in each frame that has one."""
    found = {seen.index: _patch(seen.luma, line) for seen in shown}
    return {index: patch for index, patch in found.items() if patch is not None}


def _patch(silhouette: Luma, line: Line) -> Patch | None:
    mask = (silhouette > (LIT + DARK) / 2).astype(np.uint8)
    mask = np.asarray(cv2.morphologyEx(mask, cv2.MORPH_OPEN, disc(THREADS_PX)), dtype=np.uint8)
    _, _, stats, _ = cv2.connectedComponentsWithStats(mask)
    best: tuple[int, Patch | None] = (0, None)
    for left, top, width, height, area in stats[1:].tolist():
        if top <= line.row(left + width / 2) <= top + height and area > best[0]:
            best = area, (left, top, left + width, top + height)
    return best[1]


def _hidden(patches: Mapping[int, Patch], beside: Beside) -> dict[int, Patch]:
    """Tell where the body may hide the backdrop, if each patch is no more than a part of it."""
    clear = [patch for index, patch in patches.items() if _clear(index, patch, beside)]
    if not clear:
        return {}
    sizes = [(p[2] - p[0], p[3] - p[1]) for p in clear]
    width, height = np.quantile(sizes, WHOLE_QUANTILE, axis=0, method="nearest").tolist()
    width = max(width, height)
    return {
        index: _wider(
            (
                min(left, right - width),
                min(top, bottom - height),
                max(right, left + width),
                max(bottom, top + height),
            )
        )
        for index, (left, top, right, bottom) in patches.items()
    }


def _wider(patch: Patch) -> Patch:
    left, top, right, bottom = patch
    margin = round(MARGIN_SHARE * (bottom - top)) + MARGIN_PX
    return left - margin, top - margin, right + margin, bottom + margin


def _seeds(patches: Mapping[int, Patch], beside: Beside) -> list[Seed]:
    """Take some patches of the most usual size, those first that are seen to move evenly."""
    clear = {index: patch for index, patch in patches.items() if _clear(index, patch, beside)}
    if len(clear) < CLEAR_AT_LEAST:
        return []
    sizes = np.array([(p[2] - p[0], p[3] - p[1]) for p in clear.values()], dtype=np.float64)
    unusual = np.abs(sizes - np.median(sizes, axis=0)).sum(axis=1)
    usual = unusual <= np.quantile(unusual, USUAL_SHARE)
    whole = {index: clear[index] for index, good in zip(clear, usual, strict=True) if good}
    motions = {index: _motion(whole, index) for index in whole}
    order = sorted(motions, key=lambda index: -abs(motions[index][0]) / (1.0 + motions[index][1]))
    apart = [index for index in order if _first_nearby(index, order)]
    return [_seed(index, whole[index], motions[index][0]) for index in apart[:SEEDS]]


def _first_nearby(index: int, order: Sequence[int]) -> bool:
    """Whether no frame nearby comes before one."""
    before = order[: order.index(index)]
    return all(abs(other - index) > NEAR_FRAMES for other in before)


def _seed(frame: int, patch: Patch, speed: float) -> Seed:
    left, top, right, bottom = (float(edge) for edge in _wider(patch))
    a, b, c, d = (float(edge) for edge in patch)
    return Seed(frame, (left, top, right, bottom), (a, b, c, d), speed, (left, right))


def _clear(index: int, patch: Patch, beside: Beside) -> bool:
    near = patch[0] if beside.toward > 0 else patch[2]
    return beside.toward * (near - beside.edge_px[index]) > CLEAR_PX


def _motion(patches: Mapping[int, Patch], frame: int) -> tuple[float, float]:
    """Speed of a patch in px per frame, and how it strays in px, by its places nearby."""
    near = [index for index in patches if abs(index - frame) <= NEAR_FRAMES]
    if len(near) < 3:
        return 0.0, 0.0
    middle = np.array([(patches[index][0] + patches[index][2]) / 2 for index in near])
    speed, start = np.polyfit(near, middle, 1)
    return float(speed), float(np.abs(middle - start - speed * np.array(near)).max())


def _changes(frames: Sequence[Frame], body: Body) -> bool:
    """Whether the pictures of a body disagree with their mean as other bodies' would."""
    luma = {seen.index: seen.luma for seen in frames}
    inside = body.sprite.weight > 0
    pieces: Floats = np.array(
        [look(luma[i], x, y, body.sprite.shape)[inside] for i, (x, y) in body.sightings.items()],
        dtype=np.float64,
    )
    return _agreement(pieces) < AGREEMENT_SHARE


def _agreement(pieces: Floats) -> float:
    """Median correlation of pieces with their mean, shape (pieces, pixels)."""
    centred = pieces - pieces.mean(axis=1, keepdims=True)
    mean = centred.mean(axis=0)
    size: NDArray[np.float64] = np.sqrt((centred**2).sum(axis=1) * float(mean @ mean))
    return float(np.median(centred @ mean / np.maximum(size, 1e-9)))

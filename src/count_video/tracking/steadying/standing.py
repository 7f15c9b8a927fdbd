"""Find what stands still in a clip, from the runs of its pilot.

Corners of one picture are followed to pictures all over the clip. Those of the backdrop, the wall
and the table stay within the reach of a shaken camera and keep their distances from each other;
those of the bodies move away, and further than the camera does. With the pictures laid upon each
other by that motion, whatever is sharp and steady in them stands still.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from count_video.records import Floats, Frame
from count_video.tracking.flow import Luma, as_bytes, flow, prepare
from count_video.tracking.steadying.camera import Camera
from count_video.tracking.steadying.clear_places import clear_places
from count_video.tracking.steadying.displacement import Shift, measure
from count_video.tracking.steadying.landmarks import (
    WINDOW_PX,
    Landmarks,
    make_landmarks,
)

PICTURES_AT_MOST = 16
CORNERS_AT_MOST = 200
CORNER_QUALITY = 0.0005
SPACING_SHARE = 0.03
"""Corners are spread out: they lie this share of the picture's width apart."""
SEEN_SHARE = 0.7
"""A corner that is lost in more of the pictures is hidden too often."""
RETURN_ERROR_PX = 0.5
TOGETHER_PX = 0.7
"""Corners of one rigid scene move together to this RMS."""
SHAKE_AT_MOST_PX = 16.0
"""What moves further than this is no backdrop."""
SCATTER_AT_MOST_PX = 0.15
"""Windows of one rigid scene leave their joint shift open by some hundredths of a pixel, by a tenth
where they are faint or compressed. Where it
is more, some lie on what moves by itself, and the camera's motion is not told from theirs."""
REFINEMENTS = 3
GROUP_SHARE = 0.15
"""A rigid scene has this share of the corners that the largest one has."""
GROUP_AT_LEAST = 2
"""Before a plain wall hardly anything but the bodies has corners. Two that keep their distance all
over the clip are no accident, and if they stay where they are, so does the camera."""


def steadied(runs: Sequence[Sequence[Frame]]) -> tuple[list[list[Frame]], Camera]:
    """Shift the pictures of runs back to where a camera at rest had seen them.

    Returns
    -------
    tuple
        The runs (of a camera at rest as they are; pictures whose shift is not known are left out)
        and the camera, ready to be followed from the clip's first frame on.
    """
    landmarks = learn_landmarks(runs)
    camera = Camera(landmarks)
    for run in runs:
        for seen in run:
            camera.see(seen.luma)
    motion = camera.motion()
    if motion is None:
        return [list(run) for run in runs], Camera(landmarks)
    shifts = iter(motion.shift_px)
    known = [[(seen, next(shifts)) for seen in run] for run in runs]
    steady = [
        [replace(seen, luma=_moved_back(seen.luma, s)) for seen, s in run if np.isfinite(s[0])]
        for run in known
    ]
    return [run for run in steady if run], Camera(landmarks)


def _moved_back(luma: Luma, shift: Floats) -> Luma:
    back = np.array([[1.0, 0.0, -shift[0]], [0.0, 1.0, -shift[1]]])
    size = luma.shape[1], luma.shape[0]
    flags, border = cv2.INTER_LANCZOS4, cv2.BORDER_REPLICATE
    return as_bytes(cv2.warpAffine(luma, back, size, flags=flags, borderMode=border))


def learn_landmarks(runs: Sequence[Sequence[Frame]]) -> Landmarks | None:
    """Learn windows that stand still from runs of frames; None as :func:`landmarks_of` says."""
    return landmarks_of([seen.luma for run in runs for seen in run])


def landmarks_of(pictures: Sequence[Luma]) -> Landmarks | None:
    """Learn windows that stand still from pictures all over a clip, shape (height, width) each.

    None where too few are found to measure the camera's motion.
    """
    pictures = _some(pictures)
    if len(pictures) < 2:
        return None
    small, scale = prepare(pictures)
    shifts = _rough_shifts(small)
    places = [(scale * x, scale * y) for x, y in clear_places(small, shifts, WINDOW_PX / scale)]
    known = [(float(x), float(y)) for x, y in scale * shifts]
    for _ in range(REFINEMENTS):
        landmarks = make_landmarks(places, pictures, known)
        if landmarks is None:
            return None
        measured = [measure(p, landmarks, s) for p, s in zip(pictures, known, strict=True)]
        seen = [(p, s.place) for p, s in zip(pictures, measured, strict=True) if s is not None]
        if len(seen) < SEEN_SHARE * len(pictures):
            return None
        pictures, known = [p for p, _ in seen], [s for _, s in seen]
    return None if _scatter(measured) > SCATTER_AT_MOST_PX else landmarks


def _scatter(shifts: Sequence[Shift | None]) -> float:
    """By how much windows usually leave the shift open, in the direction that shows less of it."""
    sigma = [(shift.sigma_x_px, shift.sigma_y_px) for shift in shifts if shift is not None]
    return float(np.median(sigma, axis=0).max())


def _some(pictures: Sequence[Luma]) -> list[Luma]:
    """Take some of the pictures, evenly spread."""
    count = min(len(pictures), PICTURES_AT_MOST)
    return [pictures[place * len(pictures) // count] for place in range(count)]


def _rough_shifts(pictures: Sequence[Luma]) -> Floats:
    """How far each picture is displaced, shape (pictures, 2); 0 where nothing tells it."""
    middle = len(pictures) // 2
    spacing = SPACING_SHARE * pictures[middle].shape[1]
    corners = cv2.goodFeaturesToTrack(pictures[middle], CORNERS_AT_MOST, CORNER_QUALITY, spacing)
    nothing = np.zeros((len(pictures), 2))
    if corners is None:
        return nothing
    travel = _travel(pictures, middle, np.asarray(corners, dtype=np.float32))
    still = _still(travel)
    if not still.any():
        return nothing
    shifts = _common(travel[:, still])
    shifts = shifts - np.nanmedian(shifts, axis=0)
    return nothing if np.nanmax(np.abs(shifts)) > SHAKE_AT_MOST_PX else np.nan_to_num(shifts)


def _travel(pictures: Sequence[Luma], reference: int, start: NDArray[np.float32]) -> Floats:
    """How far each corner has moved in each picture, shape (pictures, corners, 2); NaN if lost."""
    found = []
    for picture in pictures:
        there, seen = flow(pictures[reference], picture, start)
        back, returned = flow(picture, pictures[reference], there)
        good = seen & returned & (np.hypot(*(back - start)[:, 0].T) < RETURN_ERROR_PX)
        found.append(np.where(good[:, None], (there - start)[:, 0], np.nan))
    return np.array(found, dtype=np.float64)


def _still(travel: Floats) -> NDArray[np.bool_]:
    """Which corners belong to the scene that moves least, shape (corners,).

    Corners that keep their distances make a rigid scene; of all that are large enough the backdrop
    is the calmest, for bodies travel further than any camera shakes.
    """
    still = np.zeros(travel.shape[1], dtype=bool)
    usable = np.flatnonzero(np.isfinite(travel[:, :, 0]).mean(axis=0) >= SEEN_SHARE)
    if len(usable) == 0:
        return still
    paths = travel[:, usable]
    together = np.array([_rms(paths - path[:, None]) for path in paths.transpose(1, 0, 2)])
    together = together < TOGETHER_PX
    size = together.sum(axis=1)
    large = np.flatnonzero(size >= max(GROUP_AT_LEAST, GROUP_SHARE * int(size.max())))
    if len(large) == 0:
        return still
    unrest = _rms(paths[:, large] - np.nanmedian(paths[:, large], axis=0))
    calmest = large[int(np.argmin(unrest))]
    still[usable[together[calmest]]] = True
    return still


def _common(travel: Floats) -> Floats:
    """Median of the corners in each picture, shape (pictures, 2); NaN where none is seen."""
    common = np.full((len(travel), 2), np.nan)
    seen = np.isfinite(travel[:, :, 0]).any(axis=1)
    common[seen] = np.nanmedian(travel[seen], axis=1)
    return common


def _rms(away: Floats) -> Floats:
    """RMS length over the pictures that show it, inf where none does; pictures come first."""
    square = (away**2).sum(axis=-1)
    count = np.isfinite(square).sum(axis=0)
    total = np.nansum(square, axis=0)
    return np.asarray(np.sqrt(np.where(count > 0, total / np.maximum(count, 1), np.inf)))

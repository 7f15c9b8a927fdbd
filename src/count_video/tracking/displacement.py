"""How far the picture has moved, by the landmarks in it: the camera's own motion.

A hand on the table or a wobbly tripod moves the whole picture. Each window gives its own shift by
the linearised appearance, blind to a change of brightness and contrast. They are joined by least
squares, and windows that disagree (something passes in front) lose their say. How much the windows
differ from each other tells how uncertain the joint shift is.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np

from count_video.records import Floats
from count_video.tracking.landmarks import (
    SEARCH_PX,
    SEEN_SHARE,
    WINDOW_PX,
    Landmarks,
    agreement,
    correlations_of,
    evidence,
)
from count_video.tracking.sprite import REACH_PX, Picture, Pixels, smooth

ROUNDS = 8
CONVERGED_PX = 0.03
"""A step this small ends the iteration: what is left is a small share of it."""
STEP_AT_MOST_PX = 2.0
MISFIT_ALLOWED = 6.0
"""A window whose misfit is so many times the median one has half its weight."""
MEDIAN_CHI_SQUARED = 1.386
"""Median of chi squared with two degrees of freedom, which one window's misfit has."""
SURE_SHARE = 0.9
"""A shift is believed at once from this share of the typical correlation on; below it, the scenery
is looked for elsewhere as well."""
SEARCHED_WINDOWS = 8
FLAT = 1e-6
"""Windows show nothing of a direction in which their slopes are weaker by this share."""


@dataclass(frozen=True)
class Shift:
    """How far the picture has moved since the reference, in px, with standard uncertainties."""

    x_px: float
    y_px: float
    sigma_x_px: float
    sigma_y_px: float
    agreement: float = 1.0
    """Correlation of the windows with what they show in the reference."""
    evidence: float = 0.0
    """By which shifts far from each other are compared."""

    @property
    def place(self) -> tuple[float, float]:
        """The shift without its uncertainty."""
        return self.x_px, self.y_px


def measure(picture: Picture, landmarks: Landmarks, guess: tuple[float, float]) -> Shift | None:
    """Measure how far the picture has moved, from a guess; None where the scenery is not seen."""
    found = _settle(picture, landmarks, guess)
    if found is not None and found.agreement > SURE_SHARE * landmarks.agreement:
        return found
    anew = _search(picture, landmarks, guess)
    other = None if anew is None else _settle(picture, landmarks, anew)
    if found is None or (other is not None and other.evidence > found.evidence):
        found = other
    seen = found is not None and found.agreement > SEEN_SHARE * landmarks.agreement
    return found if seen else None


def _settle(picture: Picture, landmarks: Landmarks, guess: tuple[float, float]) -> Shift | None:
    """Gauss-Newton from a guess that is right to a pixel or two."""
    x, y = guess
    before = (0.0, 0.0)
    for _ in range(ROUNDS):
        seen = _windows(picture, landmarks, (x, y))
        step = None if seen is None else _step(landmarks, seen)
        if seen is None or step is None:
            return None
        right, down = _damped(step.x_px, before[0]), _damped(step.y_px, before[1])
        x, y, before = x + right, y + down, (right, down)
        if max(abs(x - guess[0]), abs(y - guess[1])) > SEARCH_PX / 2:
            return None
        if max(abs(right), abs(down)) < CONVERGED_PX:
            told = correlations_of(seen, landmarks.appearance)
            agrees, tells = agreement(told), evidence(told)
            return replace(step, x_px=x, y_px=y, agreement=agrees, evidence=tells)
    return None


def _damped(step: float, before: float) -> float:
    """Shorten a step that goes back: pictures sharper than the reference make steps too long.

    The secant through both steps crosses zero between the two places.
    """
    return step * before / (before - step) if step * before < 0 else step


def _windows(picture: Picture, landmarks: Landmarks, shift: tuple[float, float]) -> Pixels | None:
    """Take the windows out of a picture that has moved, shape (n, p); None beyond the picture."""
    size = WINDOW_PX + 2 * REACH_PX
    right, down = round(shift[0]), round(shift[1])
    count = len(landmarks.left)
    row = np.empty((size, count, size), dtype=np.uint8)
    for place, (left, top) in enumerate(zip(landmarks.left, landmarks.top, strict=True)):
        x, y = left + right - REACH_PX, top + down - REACH_PX
        piece = picture[max(y, 0) : y + size, max(x, 0) : x + size]
        if piece.shape != (size, size):
            return None
        row[:, place] = piece
    # Side by side the windows are smoothed in one go; only their margins mix.
    smoothed = smooth(row.reshape(size, -1), shift[0] - right, shift[1] - down)
    inner = smoothed.reshape(row.shape)[REACH_PX:-REACH_PX, :, REACH_PX:-REACH_PX]
    return inner.transpose(1, 0, 2).reshape(count, -1)


def _step(landmarks: Landmarks, seen: Pixels) -> Shift | None:
    """One robust least squares step, with the uncertainty that the windows' scatter tells."""
    wanted = -(landmarks.slopes @ seen[:, :, None])[:, :, 0].astype(np.float64)
    own = (landmarks.inverse @ wanted[:, :, None])[:, :, 0]
    plain = _joint(landmarks.normal.sum(axis=0), wanted.sum(axis=0))
    if plain is None:
        return None
    misfit = _misfit(landmarks, own - plain[:2])
    middle = float(np.partition(misfit, len(misfit) // 2)[len(misfit) // 2])
    weight = 1 / (1 + (misfit / (MISFIT_ALLOWED * middle + 1e-9)) ** 2)
    joint = _joint((weight @ landmarks.normal.reshape(-1, 4)).reshape(2, 2), weight @ wanted)
    if joint is None:
        return None
    x, y, variance_x, variance_y = joint
    noise = middle / MEDIAN_CHI_SQUARED
    return Shift(
        min(max(x, -STEP_AT_MOST_PX), STEP_AT_MOST_PX),
        min(max(y, -STEP_AT_MOST_PX), STEP_AT_MOST_PX),
        float(np.sqrt(noise * variance_x)),
        float(np.sqrt(noise * variance_y)),
    )


def _joint(normal: Floats, wanted: Floats) -> tuple[float, float, float, float] | None:
    """Solve for one shift: x, y and what the noise is multiplied by in their variances.

    None where the windows show no slope in some direction.
    """
    (xx, xy), (_, yy) = normal.tolist()
    x, y = wanted.tolist()
    determinant = xx * yy - xy * xy
    if determinant <= FLAT * (xx + yy) ** 2:
        return None
    return (
        (yy * x - xy * y) / determinant,
        (xx * y - xy * x) / determinant,
        yy / determinant,
        xx / determinant,
    )


def _misfit(landmarks: Landmarks, away: Floats) -> Floats:
    """Chi squared, up to the noise, of windows whose shifts lie so far away, shape (n,)."""
    return np.asarray((away * (landmarks.normal @ away[:, :, None])[:, :, 0]).sum(axis=1))


def _search(
    picture: Picture, landmarks: Landmarks, near: tuple[float, float]
) -> tuple[float, float] | None:
    """Find the shift to a pixel by the joint correlation of some windows with their surroundings.

    None where the windows' surroundings leave the picture.
    """
    total = None
    reach = SEARCH_PX
    for place in range(min(len(landmarks.left), SEARCHED_WINDOWS)):
        x = landmarks.left[place] + round(near[0]) - reach
        y = landmarks.top[place] + round(near[1]) - reach
        size = WINDOW_PX + 2 * reach
        scene = picture[max(y, 0) : y + size, max(x, 0) : x + size].astype(np.float32)
        if scene.shape != (size, size):
            continue
        pattern = landmarks.appearance[place].reshape(WINDOW_PX, WINDOW_PX)
        scores = cv2.matchTemplate(scene, pattern, cv2.TM_CCOEFF_NORMED)
        total = scores if total is None else total + scores
    if total is None:
        return None
    _, _, _, (right, down) = cv2.minMaxLoc(total)
    return round(near[0]) + right - reach, round(near[1]) + down - reach

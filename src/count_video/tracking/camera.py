"""The camera's own motion, frame by frame, and what it means for positions.

Where the camera stands still the measured shift is noise, and nothing is corrected by it: the
tracks stay as they are. Where it moves, by more than that noise and by more than a small part of a
pixel, the shift is taken from every position, and its uncertainty is added.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from count_video.records import Floats
from count_video.tracking.displacement import Shift, measure
from count_video.tracking.landmarks import Landmarks
from count_video.tracking.sprite import Picture

MOVED_AT_LEAST_PX = 0.35
"""Compression moves still scenery by up to 0.2 px."""
MOVED_SIGMAS = 8.0
NOTICED_PX = 0.3
"""From this shift on the camera is said to move; guesses of where a body is next need not be
better."""
STRIDE = 4
"""A knock lasts longer than so many frames."""


@dataclass
class Camera:
    """Follows what stands still; feed it every picture in order."""

    landmarks: Landmarks | None
    """None where nothing still was found: the camera is then taken to stand."""
    _shifts: list[Shift | None] = field(default_factory=list)
    _place: tuple[float, float] = (0.0, 0.0)
    _pace: tuple[float, float] = (0.0, 0.0)
    _moving: bool = False
    _stood: tuple[float, float] = (0.0, 0.0)
    """Last place before it began to move."""
    _waiting: list[Picture] = field(default_factory=list)

    def see(self, picture: Picture) -> tuple[float, float]:
        """Take the next picture; its shift as far as guesses should heed it, in px.

        As long as the camera stands, pictures wait and only every fourth is measured.
        """
        if self.landmarks is None:
            return 0.0, 0.0
        self._waiting.append(picture)
        if not self._moving and len(self._waiting) < STRIDE:
            return 0.0, 0.0
        waiting, self._waiting = self._waiting, []
        latest = self._measure(waiting[-1])
        if self._moving and len(waiting) > 1:
            # It began to move while pictures waited: none of them may be taken for still.
            self._place, self._pace = self._stood, (0.0, 0.0)
            self._shifts += [self._measure(picture) for picture in waiting]
        else:
            self._shifts += [latest] * len(waiting)
        if not self._moving:
            self._stood = self._place
        return self._place if self._moving else (0.0, 0.0)

    def _measure(self, picture: Picture) -> Shift | None:
        """Measure a picture and take note of where the camera is."""
        if self.landmarks is None:
            return None
        x, y = self._place
        right, down = self._pace if self._moving else (0.0, 0.0)
        shift = measure(picture, self.landmarks, (x + right, y + down))
        if shift is None:
            self._pace = (0.0, 0.0)
        else:
            self._pace = (shift.x_px - x, shift.y_px - y)
            self._place = shift.place
        self._moving |= max(abs(self._place[0]), abs(self._place[1])) > NOTICED_PX
        return shift

    def motion(self) -> Motion | None:
        """Tell how the camera moved; None where it stood still or nothing shows it."""
        self._shifts += [self._measure(picture) for picture in self._waiting]
        self._waiting = []
        if not self._shifts:
            return None
        unknown = Shift(*[float("nan")] * 4)
        seen = [shift or unknown for shift in self._shifts]
        place = np.array([shift.place for shift in seen])
        sigma = np.array([(shift.sigma_x_px, shift.sigma_y_px) for shift in seen])
        moves = _moves(place, sigma)
        if not moves.any():
            return None
        # A direction in which it stands is often one in which the scenery shows little.
        return Motion(np.where(moves, place, 0.0), np.where(moves, sigma, 0.0))


@dataclass(frozen=True)
class Motion:
    """How the picture moved, one row a frame; NaN where it could not be measured."""

    shift_px: Floats
    """By x and y, shape (n, 2)."""
    sigma_px: Floats
    """Standard uncertainties, shape (n, 2)."""


def _moves(place: Floats, sigma: Floats) -> NDArray[np.bool_]:
    """Whether the picture was ever displaced for two of three neighbouring frames, by x and y."""
    if np.isnan(place).all() or len(place) < 3:
        return np.zeros(2, dtype=bool)
    away = np.abs(place - np.nanmedian(place, axis=0))
    lasting = np.median(np.stack([away[:-2], away[1:-1], away[2:]]), axis=0)
    noise = MOVED_SIGMAS * np.nanmedian(sigma, axis=0)
    return np.asarray(np.any(lasting > np.maximum(MOVED_AT_LEAST_PX, noise), axis=0))

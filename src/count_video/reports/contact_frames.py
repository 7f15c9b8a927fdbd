"""The frames just before, at and after each contact, cut out around it for a person to judge."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from count_video.records import Collision, MotionLine, Track
from count_video.reports.material import contact_px

Luma = NDArray[np.uint8]
Point = tuple[float, float]
UNMOVED = (0.0, 0.0)
WIDTH_DIAMETERS = 2.4
HEIGHT_DIAMETERS = 1.5
SHOWN_WIDTH_PX = 300
JPEG_QUALITY = 82
BESIDE = (-1, 0, 1)
"""Frames shown, counted from the one nearest to the contact."""


@dataclass(frozen=True)
class ContactFrame:
    """One enlarged cut-out."""

    frame: int
    """Index of the frame it is from."""
    jpeg: bytes


@dataclass
class ContactFrames:
    """Collects the cut-outs while the frames stream by."""

    track: Track
    found: dict[int, list[ContactFrame]] = field(default_factory=lambda: defaultdict(list))
    """By the collision's number, in order of time."""
    _wanted: dict[int, list[Collision]] = field(default_factory=lambda: defaultdict(list))

    def want(self, collisions: tuple[Collision, ...]) -> None:
        """Ask for the frames of these collisions, before the first frame comes."""
        for collision in collisions:
            nearest = int(np.argmin(np.abs(self.track.frame - collision.frame)))
            for step in BESIDE:
                if 0 <= nearest + step < len(self.track.frame):
                    index = int(self.track.frame[nearest + step])
                    self._wanted[index].append(collision)

    def see(self, index: int, luma: Luma) -> None:
        """Cut out what is wanted of the next frame."""
        for collision in self._wanted.get(index, ()):
            row = int(np.searchsorted(self.track.frame, index))
            jpeg = _jpeg(_cut(luma, collision, self.track, shift_of(self.track, row)))
            self.found[collision.number].append(ContactFrame(index, jpeg))


def image_point(line: MotionLine, position_px: float, shift: Point = UNMOVED) -> Point:
    """Image x and y of a position along the line of motion, in a picture shifted so far."""
    slope = np.tan(np.radians(line.tilt_deg))
    x, y = position_px, line.anchor_y_px + slope * (position_px - line.anchor_x_px)
    if line.upright:
        x, y = line.anchor_x_px + slope * (position_px - line.anchor_y_px), position_px
    return x + shift[0], y + shift[1]


def shift_of(track: Track, row: int) -> Point:
    """How far the picture of one row of a track is shifted by the camera's motion, by x and y."""
    if track.shift_px is None:
        return UNMOVED
    x, y = track.shift_px[row]
    return float(x), float(y)


def _cut(luma: Luma, collision: Collision, track: Track, shift: Point) -> Luma:
    x, y = image_point(track.line, contact_px(collision, track), shift)
    along = max(16, round(WIDTH_DIAMETERS * track.ball_diameter_px))
    across = max(10, round(HEIGHT_DIAMETERS * track.ball_diameter_px))
    width, height = (across, along) if track.line.upright else (along, across)
    width, height = min(width, luma.shape[1]), min(height, luma.shape[0])
    left = int(np.clip(round(x - width / 2), 0, luma.shape[1] - width))
    top = int(np.clip(round(y - height / 2), 0, luma.shape[0] - height))
    piece = luma[top : top + height, left : left + width]
    scale = SHOWN_WIDTH_PX / width
    size = (SHOWN_WIDTH_PX, max(1, round(height * scale)))
    smooth = cv2.INTER_CUBIC if scale > 1 else cv2.INTER_AREA
    return np.asarray(cv2.resize(np.ascontiguousarray(piece), size, interpolation=smooth), np.uint8)


def _jpeg(picture: Luma) -> bytes:
    _, data = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])
    return bytes(data)

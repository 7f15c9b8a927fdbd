"""What is kept of the frames as they stream by: the line of motion and cut-outs at contacts."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, field

import cv2
import numpy as np

from count_video.records import Collision, MotionLine, Track
from count_video.reports.material import Luma, Point, contact_px, image_point, shift_of

HALF_WIDTH_DIAMETERS = 0.1
"""The line is averaged this far to either side, in ball diameters: noise goes, edges stay."""
WIDTH_DIAMETERS = 2.4
HEIGHT_DIAMETERS = 1.5
SHOWN_WIDTH_PX = 300
JPEG_QUALITY = 82
BESIDE = (-1, 0, 1)
"""Frames cut out, counted from the one nearest to the contact."""


class SpaceTimeSampler:
    """Takes the line of motion out of each frame."""

    def __init__(self, line: MotionLine, ball_diameter_px: float, shape: tuple[int, int]) -> None:
        """``shape`` is that of the pictures: (height, width)."""
        self._upright = line.upright
        across, along = shape[::-1] if line.upright else shape
        anchor = (line.anchor_x_px, line.anchor_y_px)
        anchor_along, anchor_across = anchor[::-1] if line.upright else anchor
        place = np.arange(along)
        slope = np.tan(np.radians(line.tilt_deg))
        middle = np.rint(anchor_across + slope * (place - anchor_along)).astype(np.intp)
        half = max(1, round(HALF_WIDTH_DIAMETERS * ball_diameter_px))
        aside = np.arange(-half, half + 1)
        self._across = middle + aside[:, None]
        self._along = np.broadcast_to(place, self._across.shape)
        self._size = (across, along)

    def row(self, luma: Luma, shift: Point) -> Luma:
        """Brightness along the line of one picture that lies shifted by x and y, shape (length,).

        Beyond the picture's border its last pixel goes on.
        """
        picture = luma.T if self._upright else luma
        along, across = shift[::-1] if self._upright else shift
        rows = np.clip(self._across + round(across), 0, self._size[0] - 1)
        columns = np.clip(self._along + round(along), 0, self._size[1] - 1)
        row: Luma = np.rint(picture[rows, columns].mean(axis=0)).astype(np.uint8)
        return row


@dataclass(frozen=True)
class ContactFrame:
    """The surroundings of a contact in one frame, enlarged."""

    frame: int
    """Index of the frame it is from."""
    jpeg: bytes


@dataclass
class ContactFrames:
    """The frames just before, at and after each contact, for a person to judge."""

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

    def take(self, index: int, luma: Luma) -> None:
        """Cut out what is wanted of the next frame."""
        for collision in self._wanted.get(index, ()):
            row = int(np.searchsorted(self.track.frame, index))
            cut = _cut(luma, collision, self.track, shift_of(self.track, row))
            _, data = cv2.imencode(".jpg", cut, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])
            self.found[collision.number].append(ContactFrame(index, bytes(data)))


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

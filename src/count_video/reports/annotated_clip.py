"""The pictures of the annotated clip: header with the count, footage with outlines, strip below.

The strip is the space-time image as it grows: the newest frame's line is its top row, so it seems
to flow out of the footage, and every contact stays in sight for a while.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from count_video.records import Frame, Track, TrialResult
from count_video.reports.clip_header import HEADER_PX, draw_header
from count_video.reports.clip_strip import Strip
from count_video.reports.contact_frames import ContactFrames, image_point, shift_of
from count_video.reports.material import contact_px
from count_video.reports.overlay import Point, mark, path, ring
from count_video.reports.palette import BALL, HEAVY, rgb
from count_video.reports.space_time import SpaceTime, SpaceTimeSampler

Pixels = NDArray[np.uint8]
LONGEST_PX = 1280
"""Of the footage's sides."""
NARROWEST_PX = 640
FLASH_FRAMES = 4
"""A collision's mark stays on the footage for so many frames."""
MARK_PX = 11.0
FACE_DIAMETERS = 0.62
"""The heavy body's face is drawn this far to either side of the line of motion."""


@dataclass(frozen=True)
class ClipLayout:
    """Where things are in a picture of the annotated clip."""

    scale: float
    """Pixels of the annotated clip a pixel of the footage."""
    width_px: int
    footage_height_px: int
    height_px: int
    """All of it: header, footage, strip; sides are even."""

    def place(self, point: Point) -> Point:
        """Where an image point of the footage is; an integer is the centre of a pixel in both."""
        x, y = ((v + 0.5) * self.scale - 0.5 for v in point)
        return x, y + HEADER_PX


def layout_of(width_px: int, height_px: int, strip_px: int) -> ClipLayout:
    """Scale footage so that lettering is readable and no clip is huge."""
    scale = min(1.0, LONGEST_PX / max(width_px, height_px))
    if width_px * scale < NARROWEST_PX:
        scale = NARROWEST_PX / width_px
    width = 2 * round(width_px * scale / 2)
    footage = 2 * round(height_px * width / width_px / 2)
    return ClipLayout(width / width_px, width, footage, HEADER_PX + footage + strip_px)


class AnnotatedClip:
    """Draws the clip while the frames stream by, and keeps what pictures and page need of them."""

    def __init__(self, result: TrialResult, track: Track, shape: tuple[int, int]) -> None:
        """``shape`` is that of the footage: (height, width)."""
        self.strip = Strip(track, result.collisions)
        self.layout = layout_of(shape[1], shape[0], self.strip.height_px)
        self.contact_frames = ContactFrames(track)
        self.contact_frames.want(result.collisions)
        self._result = result
        self.track = track
        self._sampler = SpaceTimeSampler(track.line, track.ball_diameter_px, shape)
        self._rows: list[Pixels] = []

    def pictures(self, frames: Iterable[Frame]) -> Iterator[Pixels]:
        """Draw one picture for each frame of the track, RGB, shape (height, width, 3)."""
        rows = {int(index): row for row, index in enumerate(self.track.frame)}
        for frame in frames:
            row = rows.get(frame.index)
            if row is not None:
                self._rows.append(self._sampler.row(frame.luma, shift_of(self.track, row)))
                self.contact_frames.see(frame.index, frame.luma)
                yield self._picture(frame, row)

    def space_time(self) -> SpaceTime:
        """Put the rows of all frames seen so far together."""
        return SpaceTime(self.track.frame[: len(self._rows)], np.array(self._rows))

    def _picture(self, frame: Frame, row: int) -> Pixels:
        layout = self.layout
        canvas = np.zeros((layout.height_px, layout.width_px, 3), np.uint8)
        draw_header(canvas, self._result, frame.index)
        end = HEADER_PX + layout.footage_height_px
        size = (layout.width_px, layout.footage_height_px)
        luma = frame.luma
        if luma.shape != size[::-1]:
            luma = np.ascontiguousarray(luma)
            smooth = cv2.INTER_AREA if layout.scale < 1 else cv2.INTER_LINEAR
            luma = np.asarray(cv2.resize(luma, size, interpolation=smooth), np.uint8)
        cv2.cvtColor(luma, cv2.COLOR_GRAY2RGB, dst=canvas[HEADER_PX:end])
        footage = canvas[:end]
        self._draw_bodies(footage, row)
        self._draw_marks(footage, frame.index, row)
        self.strip.draw(canvas[end:], self._rows, row)
        return canvas

    def _draw_bodies(self, canvas: Pixels, row: int) -> None:
        track = self.track
        ball = float(track.ball.position_px[row])
        if np.isfinite(ball):
            middle = ball + (track.ball.low_edge_px + track.ball.high_edge_px) / 2
            centre = self.layout.place(self._point(middle, row))
            ring(canvas, centre, track.ball_diameter_px / 2 * self.layout.scale, rgb(BALL))
        if track.heavy is None or not np.isfinite(track.heavy.position_px[row]):
            return
        face = float(track.heavy.position_px[row])
        inward = -1 if track.wall_side == "left" else 1
        foot = face - inward * 0.25 * track.ball_diameter_px
        reach = FACE_DIAMETERS * track.ball_diameter_px
        corners = [(foot, -reach), (face, -reach), (face, reach), (foot, reach)]
        points = [self.layout.place(self._aside(along, aside, row)) for along, aside in corners]
        path(canvas, points, rgb(HEAVY))

    def _point(self, along_px: float, row: int) -> Point:
        return image_point(self.track.line, along_px, shift_of(self.track, row))

    def _aside(self, along_px: float, aside_px: float, row: int) -> Point:
        x, y = self._point(along_px, row)
        return (x + aside_px, y) if self.track.line.upright else (x, y + aside_px)

    def _draw_marks(self, canvas: Pixels, index: int, row: int) -> None:
        for collision in self._result.collisions:
            if -0.5 <= index - collision.frame < FLASH_FRAMES - 0.5:
                contact = self.layout.place(self._point(contact_px(collision, self.track), row))
                mark(canvas, collision.kind, contact, MARK_PX, seen=collision.seen)

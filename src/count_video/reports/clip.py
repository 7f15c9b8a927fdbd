"""The pictures of the annotated clip: header with the count, footage with outlines, strip below.

The strip is the space-time image as it grows: the newest frame's line is its top row, right below
the footage, and every contact stays visible for a while. The clip plays slower where collisions
follow each other fast and faster where nothing happens; the header says so, and a line in it shows
where on the real time axis the frame lies.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray
from PIL import Image, ImageDraw, ImageFont

from count_video.records import CollisionKind, Floats, Frame, Track, TrialResult
from count_video.reports.drawing import BALL, HEAVY, MARKS, WHITE, font_path
from count_video.reports.material import (
    Point,
    SpaceTime,
    ball_edges_px,
    contact_jpeg,
    contact_px,
    image_point,
    line_of_motion,
    shift_of,
)
from count_video.reports.pace import pace_words

Pixels = NDArray[np.uint8]
Colour = tuple[int, int, int]

LONGEST_PX = 1280
"""Longer side of the footage in the annotated clip."""
NARROWEST_PX = 640
FLASH_FRAMES = 4
"""A collision's mark stays on the footage for so many frames."""
FACE_DIAMETERS = 0.62
"""The heavy body's face is drawn this far to either side of the line of motion."""
HEADER_PX = 72
HEADER_LEFT_PX = 112
"""What is right of a count of three digits begins here."""
SHADE = 140
"""How black a darkened ground is, of 255."""
LARGE_PX, SMALL_PX, NUMBER_PX = 46, 20, 15
BRIGHT, DIM = (255, 255, 255), (90, 90, 90)
SPACE_PX = 16
ROW_PX = 3
"""Height of one frame in the strip: a contact every 2.5 frames still has a mark of its own."""
ROWS = 72
STRIP_PX = ROW_PX * ROWS
UNFILLED = 60
"""Brightness of the strip where no frame has been yet."""
STRIP_MARK_PX = 7.0

# ---- drawing on a canvas: RGB, shape (height, width, 3); places and lengths on it are px ---------

_FINE = 4
"""Bits of a fraction of a pixel that the drawing routines take."""


@cache
def font(size_px: int) -> ImageFont.FreeTypeFont:
    """Return the font of all lettering."""
    return ImageFont.truetype(font_path(), size_px)


def rgb(colour: str) -> Colour:
    """Red, green and blue of ``#RRGGBB``, each 0 to 255."""
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)


def path(canvas: Pixels, points: ArrayLike, colour: str) -> None:
    """Draw a line through points (x, y), shape (n, 2)."""
    cv2.polylines(canvas, [_fixed(points)], False, rgb(colour), 2, cv2.LINE_AA, _FINE)


def mark(canvas: Pixels, kind: CollisionKind, at: Point, size: float, *, seen: bool = True) -> None:
    """Draw the mark of a collision: a disc between the bodies, a square at the wall.

    ``size`` is half its width in px. What is inferred between frames is hollow: white with a thick
    rim of the colour.
    """
    colour = rgb(MARKS[kind].colour)
    rim, inside = (rgb(WHITE), colour) if seen else (colour, rgb(WHITE))
    for extent, fill in ((size, rim), (size * (0.75 if seen else 0.5), inside)):
        if MARKS[kind].shape == "o":
            radius = int(_fixed(extent))
            cv2.circle(canvas, _fixed(at).tolist(), radius, fill, -1, cv2.LINE_AA, _FINE)
        else:
            low, high = _fixed([np.subtract(at, extent), np.add(at, extent)]).tolist()
            cv2.rectangle(canvas, low, high, fill, -1, cv2.LINE_AA, _FINE)


def _fixed(lengths: ArrayLike) -> NDArray[np.int32]:
    fixed: NDArray[np.int32] = np.rint(np.multiply(lengths, 2**_FINE)).astype(np.int32)
    return fixed


# ---- the pictures --------------------------------------------------------------------------------


Letters = tuple[Point, int, str]
"""Where a text begins or ends, the size of its type in px, and which of both: ``la`` if its left
top corner is at that place, ``ra`` if its right one is."""


@dataclass(frozen=True)
class ClipLayout:
    """Places of footage, strip and letters in a picture of the clip."""

    scale: float
    """Pixels of the picture a pixel of the footage."""
    width_px: int
    height_px: int
    """All of the picture; its sides are even."""
    footage_width_px: int
    footage_height_px: int
    left_px: int
    top_px: int
    """Distances from the picture's edges to the footage."""
    time_line_px: tuple[int, int, int]
    """Left and right end of the line of time, and its height in the picture."""
    letters: Mapping[str, Letters]
    """How the count, the noun, the last collision and its sign, the time and the pace are written,
    by these names."""
    with_strip: bool = True
    """Whether the strip lies below the footage."""
    shaded_px: tuple[int, int, int, int] = (0, 0, 0, 0)
    """Left, top, right and bottom of a ground that is darkened behind letters."""
    mark_px: float = 11.0
    """Half the width of a mark on the footage."""

    def place(self, point: Point) -> Point:
        """Place of an image point of the footage; an integer is the centre of a pixel in both."""
        x, y = ((v + 0.5) * self.scale - 0.5 for v in point)
        return x + self.left_px, y + self.top_px

    def canvas(self, luma: Pixels) -> Pixels:
        """Return a black picture with footage, shape (height, width), in its place."""
        canvas = np.zeros((self.height_px, self.width_px, 3), np.uint8)
        size = (self.footage_width_px, self.footage_height_px)
        smooth = cv2.INTER_AREA if self.scale < 1 else cv2.INTER_LINEAR
        shown = cv2.resize(np.ascontiguousarray(luma), size, interpolation=smooth)
        below, right = self.top_px + size[1], self.left_px + size[0]
        canvas[self.top_px : below, self.left_px : right] = shown[:, :, None]
        return canvas


def layout_of(width_px: int, height_px: int) -> ClipLayout:
    """Scale footage so that lettering is readable and no clip is huge."""
    scale = min(1.0, LONGEST_PX / max(width_px, height_px))
    if width_px * scale < NARROWEST_PX:
        scale = NARROWEST_PX / width_px
    width = 2 * round(width_px * scale / 2)
    footage = 2 * round(height_px * width / width_px / 2)
    height = HEADER_PX + footage + STRIP_PX
    left, right = HEADER_LEFT_PX, width - SPACE_PX
    letters: dict[str, Letters] = {
        "count": ((SPACE_PX, 6), LARGE_PX, "la"),
        "noun": ((left, 8), SMALL_PX, "la"),
        "sign": ((left, 36), SMALL_PX, "la"),
        "last": ((left + 24, 36), SMALL_PX, "la"),
        "time": ((right, 8), SMALL_PX, "ra"),
        "pace": ((right, 36), SMALL_PX, "ra"),
    }
    places = (width, footage, 0, HEADER_PX, (left, right, HEADER_PX - 5), letters)
    return ClipLayout(width / width_px, width, height, *places)


class AnnotatedClip:
    """Draws the clip while the frames stream by, and keeps what pictures and page need of them."""

    def __init__(
        self, result: TrialResult, track: Track, layout: ClipLayout, shown_s: Floats
    ) -> None:
        """``shown_s`` says when each frame of the track is shown, in seconds, shape (n,)."""
        self.layout = layout
        self.track = track
        self.shown_s = shown_s
        self.cuts: dict[int, list[tuple[int, bytes]]] = defaultdict(list)
        """The frames before, at and after each contact, by the collision's number: the index of
        each, and its surroundings of the contact, enlarged, as JPEG."""
        self._result = result
        self._pace = pace_words(shown_s)
        self._rows: list[Pixels] = []
        self._nearest = [int(np.argmin(abs(track.frame - c.frame))) for c in result.collisions]

    def pictures(self, frames: Iterable[Frame]) -> Iterator[Pixels]:
        """Draw one picture for each frame of the track, RGB, shape (height, width, 3)."""
        rows = {int(index): row for row, index in enumerate(self.track.frame)}
        for frame in frames:
            row = rows.get(frame.index)
            if row is not None:
                self._rows.append(line_of_motion(frame.luma, self.track, row))
                for collision, nearest in zip(self._result.collisions, self._nearest, strict=True):
                    if abs(row - nearest) <= 1:
                        jpeg = contact_jpeg(frame.luma, collision, self.track, row)
                        self.cuts[collision.number].append((frame.index, jpeg))
                yield self._picture(frame, row)

    def space_time(self) -> SpaceTime:
        """Put the rows of all frames seen so far together."""
        return SpaceTime(self.track.frame[: len(self._rows)], np.array(self._rows))

    def _picture(self, frame: Frame, row: int) -> Pixels:
        canvas = self.layout.canvas(frame.luma)
        self._draw_bodies(canvas, row)
        self._draw_contacts(canvas, frame.index, row)
        numbers = self._draw_strip(canvas, row) if self.layout.with_strip else {}
        self._draw_time_line(canvas, row)
        image = Image.fromarray(canvas)
        draw = ImageDraw.Draw(image, "RGBA")
        for corner, number in numbers.items():
            draw.text(corner, number, BRIGHT, font(NUMBER_PX))
        draw.rectangle(self.layout.shaded_px, (0, 0, 0, SHADE))
        self._write(draw, frame.index, row)
        return np.asarray(image)

    # ---- header: the running count, the last collision, the frame, and the pace ----------------

    def _write(self, draw: ImageDraw.ImageDraw, index: int, row: int) -> None:
        """Write what has happened up to and with frame ``index``."""
        past = [c for c in self._result.collisions if c.frame < index + 0.5]
        count, fps = min(len(past), self._result.burst_size), self._result.capture_fps
        beyond = f", {len(past) - count} more after the burst" if len(past) > count else ""
        colour = BRIGHT
        texts = {
            "count": str(count),
            "noun": f"{'collision' if count == 1 else 'collisions'}{beyond}",
            "time": f"frame {index}{f', {1000 * index / fps:.1f} ms' if fps else ''}",
            "pace": self._pace[row],
        }
        if past:
            last, mark = past[-1], MARKS[past[-1].kind]
            texts["sign"], colour = mark.signs[not last.seen], rgb(mark.colour)
            texts["last"] = f"no. {last.number} {mark.words}{'' if last.seen else ', inferred'}"
        for name, (at_px, size_px, anchor) in self.layout.letters.items():
            fill = colour if name == "sign" else BRIGHT
            draw.text(at_px, texts.get(name, ""), fill, font(size_px), anchor)

    def _draw_time_line(self, canvas: Pixels, row: int) -> None:
        """Draw a line on which time runs evenly, with the collisions and where this frame is."""
        left, right, y = self.layout.time_line_px
        frame = self.track.frame
        shown = [float(frame[row]), *(c.frame for c in self._result.collisions)]
        now, *places = np.interp(shown, frame[[0, -1]], [left, right]).round().astype(int).tolist()
        cv2.line(canvas, (left, y), (right, y), DIM, 2)
        for collision, x in zip(self._result.collisions, places, strict=True):
            cv2.line(canvas, (x, y - 3), (x, y + 3), rgb(MARKS[collision.kind].colour), 2)
        cv2.circle(canvas, (now, y), 4, BRIGHT, -1, cv2.LINE_AA)

    # ---- footage --------------------------------------------------------------------------------

    def _draw_contacts(self, canvas: Pixels, index: int, row: int) -> None:
        """Mark the collisions that have just happened."""
        for c in self._result.collisions:
            if -0.5 <= index - c.frame < FLASH_FRAMES - 0.5:
                shift = shift_of(self.track, row)
                at = image_point(self.track.line, contact_px(c, self.track), shift)
                mark(canvas, c.kind, self.layout.place(at), self.layout.mark_px, seen=c.seen)

    def _draw_bodies(self, canvas: Pixels, row: int) -> None:
        """Draw the ball's circle, and a bracket at the heavy body's face."""
        track, shift = self.track, shift_of(self.track, row)
        centre = np.mean(ball_edges_px(track), axis=0)[row]
        if np.isfinite(centre):
            place = _fixed(self.layout.place(image_point(track.line, float(centre), shift)))
            radius = int(_fixed(track.ball_diameter_px / 2 * self.layout.scale))
            cv2.circle(canvas, place.tolist(), radius, rgb(BALL), 2, cv2.LINE_AA, _FINE)
        if track.heavy is None or not np.isfinite(track.heavy.position_px[row]):
            return
        face = float(track.heavy.position_px[row])
        into = (0.25 if track.wall_side == "left" else -0.25) * track.ball_diameter_px
        reach = FACE_DIAMETERS * track.ball_diameter_px
        points = []
        for along, aside in ((into, -reach), (0.0, -reach), (0.0, reach), (into, reach)):
            x, y = image_point(track.line, face + along, shift)
            at = (x + aside, y) if track.line.upright else (x, y + aside)
            points.append(self.layout.place(at))
        path(canvas, points, HEAVY)

    # ---- strip: the space-time image, scrolling down, newest row on top -------------------------

    def _draw_strip(self, canvas: Pixels, newest: int) -> dict[Point, str]:
        """Draw the last frames as rows below the footage; return numbers by their left corners."""
        top = self.layout.top_px + self.layout.footage_height_px
        strip, frame = canvas[top : top + STRIP_PX], self.track.frame
        oldest = max(0, newest + 1 - ROWS)
        image = np.array(self._rows[oldest : newest + 1])[::-1]
        size = (strip.shape[1], ROW_PX * len(image))
        shown = cv2.resize(image, size, interpolation=cv2.INTER_NEAREST)
        strip[:] = UNFILLED
        strip[: size[1]] = shown[:, :, None]
        scale = strip.shape[1] / image.shape[1]
        lines = [(edge, BALL) for edge in ball_edges_px(self.track)]
        if self.track.heavy is not None:
            lines.append((self.track.heavy.position_px, HEAVY))
        for place_px, colour in lines:
            x = (place_px[oldest : newest + 1] + 0.5) * scale - 0.5
            y = ROW_PX * (newest - np.arange(oldest, newest + 1) + 0.5) - 0.5
            # Unseen stretches part the line.
            for piece in np.split(np.column_stack([x, y]), np.flatnonzero(np.isnan(x))):
                path(strip, piece[np.isfinite(piece[:, 0])], colour)
        numbers = {}
        for c in self._result.collisions:
            if frame[oldest] <= c.frame < frame[newest] + 0.5:
                row = float(np.interp(c.frame, frame, np.arange(len(frame))))
                # It is whole from the first moment on.
                y_px = max(STRIP_MARK_PX + 1, ROW_PX * (newest - row + 0.5) - 0.5)
                x_px = (contact_px(c, self.track) + 0.5) * scale - 0.5
                mark(strip, c.kind, (x_px, y_px), STRIP_MARK_PX, seen=c.seen)
                corner = (x_px + STRIP_MARK_PX + 4, top + y_px - 0.6 * NUMBER_PX)
                numbers[corner] = str(c.number)
        return numbers

"""The pictures of the annotated clip: header with the count, footage with outlines, strip below.

The strip is the space-time image as it grows: the newest frame's line is its top row, right below
the footage, and every contact stays visible for a while. The clip plays slower where collisions
follow each other fast and faster where nothing happens; the header says so, and a line in it shows
where on the real time axis the frame lies.
"""

from __future__ import annotations

import io
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cache
from itertools import pairwise

import cv2
import numpy as np
from matplotlib.font_manager import findfont
from numpy.typing import ArrayLike, NDArray
from PIL import Image, ImageDraw, ImageFont
from PIL.ImageColor import getrgb

from count_video.records import Collision, Floats, Frame, Point, TrialResult
from count_video.reports.drawing import BALL, FONT, HEAVY, MARKS
from count_video.reports.material import Material
from count_video.settings import Shape

Pixels = NDArray[np.uint8]
_FINE = 4
"""Bits of a fraction of a pixel that OpenCV's drawing routines take."""
HEADER_PX = 72
ROW_PX = 3
"""Height of one frame in the strip: a contact every 2.5 frames still has a mark of its own."""
STRIP_PX = 72 * ROW_PX
NUMBER_PX = 15
"""Height of the numbers beside it; where marks follow each other closer, not all have one."""
BEGIN_PX, END_PX = 112, 16
"""From the header's left to its words, for counts have three digits at the most, with few
exceptions, and from its right."""


@dataclass(frozen=True)
class ClipLayout:
    """A picture of the clip: a header, the footage below it, and below that the strip."""

    scale: float
    """Pixels of the picture a pixel of the footage."""
    width_px: int
    """Even, as is the next."""
    footage_height_px: int

    def place(self, point: Point) -> Point:
        """Place of an image point of the footage; an integer is the centre of a pixel in both."""
        x, y = ((v + 0.5) * self.scale - 0.5 for v in point)
        return x, y + HEADER_PX


def layout_of(width_px: int, height_px: int) -> ClipLayout:
    """Scale footage so that lettering is readable (640 px) and no clip is huge (1280 px)."""
    scale = min(1.0, 1280 / max(width_px, height_px))
    if width_px * scale < 640:
        scale = 640 / width_px
    width = 2 * round(width_px * scale / 2)
    return ClipLayout(width / width_px, width, 2 * round(height_px * width / width_px / 2))


@cache
def font(size_px: int) -> ImageFont.FreeTypeFont:
    """Return the font of all lettering."""
    return ImageFont.truetype(findfont(FONT), size_px)


def _fixed(lengths: ArrayLike) -> NDArray[np.int32]:
    fixed: NDArray[np.int32] = np.rint(np.multiply(lengths, 2**_FINE)).astype(np.int32)
    return fixed


def _draw_path(canvas: Pixels, points: ArrayLike, colour: str) -> None:
    """Draw a line through points (x, y), shape (n, 2)."""
    cv2.polylines(canvas, [_fixed(points)], False, getrgb(colour), 2, cv2.LINE_AA, _FINE)


def _draw_mark(canvas: Pixels, collision: Collision, at: Point, size: float) -> None:
    """Draw the mark of a collision: a disc between the bodies, a square at the wall.

    ``size`` is half its width in px. What is inferred between frames is hollow: white with a thick
    rim of the colour.
    """
    mark = MARKS[collision.kind]
    colours, inside = [getrgb("white"), getrgb(mark.colour)], 0.75
    if not collision.seen:
        colours, inside = colours[::-1], 0.5
    for extent, fill in zip((size, size * inside), colours, strict=True):
        if mark.shape == "o":
            radius = int(_fixed(extent))
            cv2.circle(canvas, _fixed(at).tolist(), radius, fill, -1, cv2.LINE_AA, _FINE)
        else:
            low, high = _fixed([np.subtract(at, extent), np.add(at, extent)]).tolist()
            cv2.rectangle(canvas, low, high, fill, -1, cv2.LINE_AA, _FINE)


def pictures(
    material: Material, layout: ClipLayout, shown_s: Floats, frames: Iterable[tuple[Frame, int]]
) -> Iterator[Pixels]:
    """Draw one picture, RGB, shape (height, width, 3), for each frame and its row of the track.

    ``shown_s`` says when each frame of the track is shown, in seconds, shape (n,). The line of
    motion in each frame is kept in the material already.
    """
    pace = pace_words(shown_s)
    for frame, row in frames:
        canvas = _with_footage(layout, frame.luma)
        _draw_bodies(canvas, layout, material, row)
        _draw_contacts(canvas, layout, material, row)
        _draw_strip(canvas[-STRIP_PX:], material, row)
        _draw_time_line(canvas, layout, material, row)
        with _lettering(canvas[:HEADER_PX]) as draw:
            _write(draw, layout, material.result, frame.index, pace[row])
        yield canvas


@contextmanager
def _lettering(part: Pixels) -> Iterator[ImageDraw.ImageDraw]:
    """Write on a part of a picture: Pillow copies what it writes on, and a part is less."""
    image = Image.fromarray(part)
    yield ImageDraw.Draw(image)
    part[:] = np.asarray(image)


def _with_footage(layout: ClipLayout, luma: Pixels) -> Pixels:
    """Return a black picture with footage, shape (height, width), in its place."""
    width, height = layout.width_px, layout.footage_height_px
    canvas = np.zeros((HEADER_PX + height + STRIP_PX, width, 3), np.uint8)
    scaling = _smooth(layout.scale)
    shown = cv2.resize(np.ascontiguousarray(luma), (width, height), interpolation=scaling)
    cv2.cvtColor(shown, cv2.COLOR_GRAY2RGB, dst=canvas[HEADER_PX:-STRIP_PX])
    return canvas


def _smooth(scale: float) -> int:
    """Return the interpolation by which OpenCV scales pictures so that edges stay smooth."""
    return cv2.INTER_AREA if scale < 1 else cv2.INTER_LINEAR


def _write(
    draw: ImageDraw.ImageDraw, layout: ClipLayout, result: TrialResult, index: int, pace: str
) -> None:
    """Write the running count, the last collision, frame ``index``, and the pace."""
    past = [c for c in result.collisions if c.frame < index + 0.5]
    count, fps = min(len(past), result.burst_size), result.capture_fps
    noun, more = "collision" if count == 1 else "collisions", len(past) - count
    time = f"frame {index}{f', {1000 * index / fps:.1f} ms' if fps else ''}"
    right = layout.width_px - END_PX
    if more:
        noun += f", {more} more after"
        whole = f"{noun} the burst  {time}"
        noun += " the burst" * (BEGIN_PX + draw.textlength(whole, font(20)) < right)
    draw.text((16, 6), str(count), "white", font(46))
    draw.text((BEGIN_PX, 8), noun, "white", font(20))
    draw.text((right, 8), time, "white", font(20), "ra")
    draw.text((right, 36), pace, "white", font(20), "ra")
    if past:
        last, mark = past[-1], MARKS[past[-1].kind]
        words = f"no. {last.number} {mark.words}{'' if last.seen else ', inferred'}"
        draw.text((BEGIN_PX, 36), mark.signs[not last.seen], mark.colour, font(20))
        draw.text((BEGIN_PX + 24, 36), words, "white", font(20))


def _draw_time_line(canvas: Pixels, layout: ClipLayout, material: Material, row: int) -> None:
    """Draw a line on which time runs evenly, with the collisions and where this frame is."""
    left, right, y = BEGIN_PX, layout.width_px - END_PX, HEADER_PX - 5
    frame, collisions = material.track.frame, material.result.collisions
    shown = [float(frame[row]), *(c.frame for c in collisions)]
    now, *places = np.interp(shown, frame[[0, -1]], [left, right]).round().astype(int).tolist()
    cv2.line(canvas, (left, y), (right, y), (90, 90, 90), 2)
    for collision, x in zip(collisions, places, strict=True):
        cv2.line(canvas, (x, y - 3), (x, y + 3), getrgb(MARKS[collision.kind].colour), 2)
    cv2.circle(canvas, (now, y), 4, getrgb("white"), -1, cv2.LINE_AA)


def _draw_contacts(canvas: Pixels, layout: ClipLayout, material: Material, row: int) -> None:
    """Mark the collisions of the last four frames on the footage."""
    track = material.track
    for c in material.result.collisions:
        if -0.5 <= track.frame[row] - c.frame < 3.5:
            at = material.image_point(row, material.contact_px(c))
            _draw_mark(canvas, c, layout.place(at), 11.0)


def _draw_bodies(canvas: Pixels, layout: ClipLayout, material: Material, row: int) -> None:
    """Draw the ball's circle, and a bracket at the heavy body's face."""
    track = material.track
    centre = np.mean(material.ball_edges_px, axis=0)[row]
    if np.isfinite(centre):
        place = _fixed(layout.place(material.image_point(row, float(centre))))
        radius = int(_fixed(track.ball_diameter_px / 2 * layout.scale))
        cv2.circle(canvas, place.tolist(), radius, getrgb(BALL), 2, cv2.LINE_AA, _FINE)
    if track.heavy is None or not np.isfinite(track.heavy.position_px[row]):
        return
    face, diameter = float(track.heavy.position_px[row]), track.ball_diameter_px
    into, reach = 0.25 * material.outward * diameter, 0.62 * diameter
    points = []
    for along, aside in ((into, -reach), (0.0, -reach), (0.0, reach), (into, reach)):
        x, y = material.image_point(row, face + along)
        points.append(layout.place((x + aside, y) if track.line.upright else (x, y + aside)))
    _draw_path(canvas, points, HEAVY)


def _draw_strip(strip: Pixels, material: Material, newest: int) -> None:
    """Draw the last frames as rows, the newest on top, with the numbers of the collisions."""
    size, track, numbers = 7.0, material.track, list[tuple[float, float, str]]()
    oldest = max(0, newest + 1 - STRIP_PX // ROW_PX)
    image = np.array(material.lines[oldest : newest + 1])[::-1]
    filled = ROW_PX * len(image)
    shown = cv2.resize(image, (strip.shape[1], filled), interpolation=cv2.INTER_NEAREST)
    strip[filled:] = 60
    cv2.cvtColor(shown, cv2.COLOR_GRAY2RGB, dst=strip[:filled])
    scale = strip.shape[1] / image.shape[1]
    paths = [(edge, BALL) for edge in material.ball_edges_px]
    if track.heavy is not None:
        paths.append((track.heavy.position_px, HEAVY))
    for place_px, colour in paths:
        x = (place_px[oldest : newest + 1] + 0.5) * scale - 0.5
        y = ROW_PX * (newest - np.arange(oldest, newest + 1) + 0.5) - 0.5
        # Unseen stretches part the line.
        for piece in np.split(np.column_stack([x, y]), np.flatnonzero(np.isnan(x))):
            _draw_path(strip, piece[np.isfinite(piece[:, 0])], colour)
    for c in material.result.collisions:
        if track.frame[oldest] <= c.frame < track.frame[newest] + 0.5:
            row = float(np.interp(c.frame, track.frame, np.arange(len(track.frame))))
            # Mark and number are whole from the first moment on.
            y_px = max(9.0, ROW_PX * (newest - row + 0.5) - 0.5)
            x_px = (material.contact_px(c) + 0.5) * scale - 0.5
            _draw_mark(strip, c, (x_px, y_px), size)
            numbers.append((x_px + size + 4, y_px - 9.0, str(c.number)))
    with _lettering(strip) as draw:
        above_px = -float(NUMBER_PX)
        for x_px, y_px, number in sorted(numbers, key=lambda one: one[1]):  # the newest first
            if y_px - above_px >= NUMBER_PX:
                draw.text((x_px, y_px), number, "white", font(NUMBER_PX))
                above_px = y_px


# ---- time ----------------------------------------------------------------------------------------

FASTEST_FPS = 30.0
"""Clips that play faster (their container has the capture rate) are slowed to this."""
BETWEEN_COLLISIONS_S = 0.7
"""Shortest time shown from one collision to the next: about what it takes to say a number."""
UNHURRIED_S = 0.8
"""Time before and after a collision in which the clip plays at its own rate."""
FORWARD_FPS = 180.0
"""Rate in the middle of empty stretches, as fast as browsers show frame by frame."""


def frame_times_s(
    frame: Floats, collision_frames: Sequence[float], playing_fps: float | None
) -> Floats:
    """Seconds from the clip's start at which each frame is shown, shape (n,), the first 0.

    ``frame`` are the frame coordinates of those shown, shape (n,), ``collision_frames`` increase,
    and ``playing_fps`` is the rate of the clip itself, None if it does not say. No frame stands
    still for more than 0.2 s, and stretches without a collision that would take more than 3 s are
    played fast in their middle.
    """
    rate = min(playing_fps or FASTEST_FPS, FASTEST_FPS)
    lasts, near = np.full(len(frame), 1.0 / rate), UNHURRIED_S * rate
    ends = [-np.inf, *collision_frames, np.inf] if len(collision_frames) else []
    for before, after in pairwise(ends):
        between = (frame >= before) & (frame < after)
        if np.isfinite(after - before):
            slower = min(BETWEEN_COLLISIONS_S / max(1, int(between.sum())), 0.2)
            lasts[between] = np.maximum(lasts[between], slower)
        if between.sum() > 3.0 * rate:
            lasts[(frame > before + near) & (frame < after - near)] = 1.0 / FORWARD_FPS
    return np.concatenate([[0.0], np.cumsum(lasts[:-1])])


def pace_words(shown_s: Floats) -> list[str]:
    """Say of each frame how fast the clip plays there, beside its own rate; empty if at that.

    ``shown_s`` says when each frame is shown, in seconds, shape (n,).
    """
    lasts_s = np.diff(shown_s, append=shown_s[-1:] + 1.0 / FASTEST_FPS)
    usual_s = lasts_s[lasts_s > 1.5 / FORWARD_FPS].min(initial=1.0 / FASTEST_FPS)
    words = []
    for slower in lasts_s / usual_s:
        faster = f"▶▶ {1 / slower:.0f}× faster" if slower < 0.67 else ""
        words.append(f"{slower:.0f}× slower" if slower > 1.5 else faster)
    return words


# ---- a clip for a talk ---------------------------------------------------------------------------

SIZES: dict[Shape, tuple[int, int]] = {"wide": (1920, 1080), "upright": (1080, 1920)}
"""Width and height of a clip for a talk in px."""
COUNTER_PX: dict[Shape, int] = {"wide": 320, "upright": 600}
"""Size of its counter, unless the count is too long for that."""
MARGIN_PX = 40
"""Left free around the counter."""


def counter_px(shape: Shape, most: int) -> tuple[int, int]:
    """Size of the counter's type, and how wide counts up to ``most`` are then, in px."""
    digits = 0.64 * len(str(most))  # their width over the size of the type
    size = min(COUNTER_PX[shape], int((SIZES[shape][0] - 2 * MARGIN_PX) / digits))
    return size, round(size * digits)


def presented(annotated: Iterable[Pixels], material: Material, shape: Shape) -> Iterator[Pixels]:
    """Put the pictures of the annotated clip into full HD, RGB, beside or below a big counter."""
    (width, height), burst = SIZES[shape], [collision.frame for collision in material.burst]
    size, wide = counter_px(shape, len(burst))
    left, top = (wide + 2 * MARGIN_PX, 0) if shape == "wide" else (0, size)
    counts = np.searchsorted(burst, material.track.frame + 0.5)
    for picture, count in zip(annotated, counts.tolist(), strict=True):
        scale = min((width - left) / picture.shape[1], (height - top) / picture.shape[0])
        shown = cv2.resize(picture, None, fx=scale, fy=scale, interpolation=_smooth(scale))
        spare_x, spare_y = width - shown.shape[1], height - shown.shape[0]
        canvas = np.zeros((height, width, 3), np.uint8)
        canvas[spare_y:, spare_x:] = shown
        beside = canvas[:, :spare_x] if left else canvas[:spare_y]
        with _lettering(beside) as draw:
            middle = beside.shape[1] / 2, beside.shape[0] / 2
            draw.text(middle, str(count), "white", font(size), "mm")
        yield canvas


@cache
def _palette() -> Image.Image:
    """Make the colours of a GIF: greys of footage, and what is drawn blended with some of them.

    The colours that most pixels have would be greys alone: marks are small.
    """
    greys = np.linspace(0, 255, 128)[:, None].repeat(3, axis=1)
    drawn = np.array([getrgb(one) for one in (BALL, HEAVY, *(m.colour for m in MARKS.values()))])
    some, shares = greys[[0, 42, 84, 127]], np.array([0.25, 0.5, 0.75])[:, None, None, None]
    blends = shares * drawn[:, None] + (1 - shares) * some
    colours = np.concatenate([greys, drawn, blends.reshape(-1, 3)])
    palette = Image.new("P", (1, 1))
    palette.putpalette(colours.round().astype(np.uint8).tobytes())
    return palette


@dataclass(frozen=True)
class Gif:
    """Keeps some pictures of a clip while they stream by."""

    shown_s: Floats
    """When each picture of the clip is shown, in seconds, shape (n,)."""
    _kept: dict[int, Image.Image] = field(default_factory=dict)
    """At most 160 of them by their rows, for more make a file that no slide takes."""

    def keeping(self, pictures: Iterable[Pixels]) -> Iterator[Pixels]:
        """Yield the pictures, RGB, shape (height, width, 3)."""
        times = np.linspace(0.0, self.shown_s[-1], min(160, len(self.shown_s)))
        wanted = set((np.searchsorted(self.shown_s, times, side="right") - 1).tolist())
        for row, picture in enumerate(pictures):
            if row in wanted:
                size = (480, round(480 * picture.shape[0] / picture.shape[1]))
                small = cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
                self._kept[row] = Image.fromarray(small).quantize(
                    palette=_palette(), dither=Image.Dither.NONE
                )
            yield picture

    def data(self) -> bytes:
        """Put the pictures kept so far together; it plays for ever, as long as the clip."""
        shown_s, target = self.shown_s[list(self._kept)], io.BytesIO()
        lasts_ms = np.diff(shown_s, append=shown_s[-1:] + 1.5) * 1000.0
        duration = np.maximum(20, lasts_ms.round()).astype(int).tolist()
        first, *others = self._kept.values()
        first.save(target, "GIF", save_all=True, append_images=others, duration=duration, loop=0)
        return target.getvalue()

"""The pictures of the annotated clip: header with the count, footage with outlines, strip below.

The strip is the space-time image as it grows: the newest frame's line is its top row, right below
the footage, and every contact stays visible for a while. The clip plays slower
where collisions follow each other fast and faster where nothing happens; the header says so, and a
line in it shows where on the real time axis the frame lies.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import cv2
import numpy as np

from count_video.records import Collision, Floats, Frame, Track, TrialResult
from count_video.reports.drawing import (
    BALL,
    HEAVY,
    MARKS,
    Pixels,
    Point,
    mark,
    path,
    rgb,
    ring,
    text_width,
    write,
)
from count_video.reports.material import (
    ContactFrames,
    SpaceTime,
    SpaceTimeSampler,
    ball_edges_px,
    contact_px,
    image_point,
    shift_of,
)

LONGEST_PX = 1280
"""Longer side of the footage in the annotated clip."""
NARROWEST_PX = 640
FLASH_FRAMES = 4
"""A collision's mark stays on the footage for so many frames."""
MARK_PX = 11.0
FACE_DIAMETERS = 0.62
"""The heavy body's face is drawn this far to either side of the line of motion."""
HEADER_PX = 72
_LARGE, _SMALL = 52, 20
_BRIGHT, _PALE, _DIM = (255, 255, 255), (200, 200, 200), (90, 90, 90)
_MARGIN = 16
ROW_PX = 3
"""Height of one frame in the strip: a contact every 2.5 frames still has a mark of its own."""
ROWS = 72
STRIP_PX = ROW_PX * ROWS
UNFILLED = 60
"""Brightness of the strip where no frame has been yet."""
STRIP_MARK_PX = 7.0
NUMBER_PX = 15

FASTEST_FPS = 30.0
"""Clips that play faster (their container has the capture rate) are slowed to this."""
BETWEEN_COLLISIONS_S = 0.7
"""Shortest time shown from one collision to the next: about what it takes to say a number."""
LONGEST_FRAME_S = 0.2
"""No frame stands still longer, however few there are between two collisions."""
PATIENCE_S = 3.0
"""Stretches without a collision that would take longer are played fast in their middle."""
UNHURRIED_S = 0.8
"""Time before and after a collision in which the clip plays at its own rate."""
FORWARD_FPS = 180.0
"""Rate in the middle of empty stretches, as fast as browsers show frame by frame."""


def frame_times_s(
    frame: Floats, collision_frames: Sequence[float], playing_fps: float | None
) -> Floats:
    """Time at which each frame of the annotated clip is shown.

    Parameters
    ----------
    frame
        Frame coordinates of the frames shown, shape (n,).
    collision_frames
        Frame coordinates of the collisions, increasing.
    playing_fps
        Rate of the clip itself; None if it does not say.

    Returns
    -------
    Floats
        Seconds from the clip's start, shape (n,), the first 0.
    """
    rate = min(playing_fps or FASTEST_FPS, FASTEST_FPS)
    lasts = np.full(len(frame), 1.0 / rate)
    for before, after in pairwise(collision_frames):
        between = (frame >= before) & (frame < after)
        shown = max(1, int(between.sum()))
        slower = min(BETWEEN_COLLISIONS_S / shown, LONGEST_FRAME_S)
        lasts[between] = np.maximum(lasts[between], slower)
    if len(collision_frames):
        unhurried = UNHURRIED_S * rate
        for before, after in pairwise([-np.inf, *collision_frames, np.inf]):
            between = (frame >= before) & (frame < after)
            if between.sum() > PATIENCE_S * rate:
                lasts[between & (frame > before + unhurried) & (frame < after - unhurried)] = (
                    1.0 / FORWARD_FPS
                )
    return np.concatenate([[0.0], np.cumsum(lasts[:-1])])


@dataclass(frozen=True)
class ClipLayout:
    """Places of footage, header and strip in a picture of the annotated clip."""

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

    def place(self, point: Point) -> Point:
        """Place of an image point of the footage; an integer is the centre of a pixel in both."""
        x, y = ((v + 0.5) * self.scale - 0.5 for v in point)
        return x + self.left_px, y + self.top_px

    def put(self, canvas: Pixels, luma: Pixels) -> Pixels:
        """Put footage (height, width) into its place, and return the rows down to its end."""
        size = (self.footage_width_px, self.footage_height_px)
        if luma.shape != size[::-1]:
            smooth = cv2.INTER_AREA if self.scale < 1 else cv2.INTER_LINEAR
            luma = np.asarray(
                cv2.resize(np.ascontiguousarray(luma), size, interpolation=smooth), np.uint8
            )
        rows = slice(self.top_px, self.top_px + size[1])
        canvas[rows, self.left_px : self.left_px + size[0]] = luma[:, :, None]
        return canvas[: rows.stop]


def layout_of(width_px: int, height_px: int) -> ClipLayout:
    """Scale footage so that lettering is readable and no clip is huge."""
    scale = min(1.0, LONGEST_PX / max(width_px, height_px))
    if width_px * scale < NARROWEST_PX:
        scale = NARROWEST_PX / width_px
    width = 2 * round(width_px * scale / 2)
    footage = 2 * round(height_px * width / width_px / 2)
    height = HEADER_PX + footage + STRIP_PX
    return ClipLayout(width / width_px, width, height, width, footage, 0, HEADER_PX)


class AnnotatedClip:
    """Draws the clip while the frames stream by, and keeps what pictures and page need of them."""

    def __init__(
        self, result: TrialResult, track: Track, shape: tuple[int, int], shown_s: Floats
    ) -> None:
        """Prepare the drawing.

        Parameters
        ----------
        shape
            Of the footage: (height, width).
        shown_s
            When each frame of the track is shown, in seconds, shape (n,).
        """
        self.layout = layout_of(shape[1], shape[0])
        self.contact_frames = ContactFrames(track)
        self.contact_frames.want(result.collisions)
        self.track = track
        self.shape = shape
        self.shown_s = shown_s
        self._result = result
        self._lasts_s = np.diff(shown_s, append=shown_s[-1:] + 1.0 / FASTEST_FPS)
        unhurried = self._lasts_s[self._lasts_s > 1.5 / FORWARD_FPS]
        self._usual_s = float(unhurried.min(initial=1.0 / FASTEST_FPS))
        self._sampler = SpaceTimeSampler(track.line, track.ball_diameter_px, shape)
        self._rows: list[Pixels] = []

    def pictures(self, frames: Iterable[Frame]) -> Iterator[Pixels]:
        """Draw one picture for each frame of the track, RGB, shape (height, width, 3)."""
        rows = {int(index): row for row, index in enumerate(self.track.frame)}
        for frame in frames:
            row = rows.get(frame.index)
            if row is not None:
                self._rows.append(self._sampler.row(frame.luma, shift_of(self.track, row)))
                self.contact_frames.take(frame.index, frame.luma)
                yield self._picture(frame, row)

    def space_time(self) -> SpaceTime:
        """Put the rows of all frames seen so far together."""
        return SpaceTime(self.track.frame[: len(self._rows)], np.array(self._rows))

    def _picture(self, frame: Frame, row: int) -> Pixels:
        layout = self.layout
        canvas = np.zeros((layout.height_px, layout.width_px, 3), np.uint8)
        self._draw_header(canvas, frame.index, row)
        footage = layout.put(canvas, frame.luma)
        self._draw_bodies(footage, row)
        self._draw_contacts(footage, frame.index, row, MARK_PX)
        self._draw_strip(canvas[len(footage) :], row)
        return canvas

    # ---- header: the running count, the last collision, the frame, and the pace ----------------

    def _draw_header(self, canvas: Pixels, index: int, row: int) -> None:
        """Write what has happened up to and with frame ``index`` into the top rows."""
        past, count = self._happened(index)
        end = write(canvas, str(count), (_MARGIN, 4), _LARGE, _BRIGHT)
        end = max(end, text_width("00", _LARGE) + _MARGIN) + _MARGIN
        beyond = f", {len(past) - count} more after the burst" if len(past) > count else ""
        noun = "collision" if count == 1 else "collisions"
        write(canvas, f"{noun}{beyond}", (end, 8), _SMALL, _BRIGHT)
        if past:
            last = past[-1]
            mark(canvas, last.kind, (end + 9.0, 48.0), 9.0, seen=last.seen)
            words = MARKS[last.kind].words + ("" if last.seen else ", inferred")
            write(canvas, f"no. {last.number} {words}", (end + 26, 36), _SMALL, _PALE)
        fps = self._result.capture_fps
        lines = [f"frame {index}" + (f", {1000 * index / fps:.1f} ms" if fps else "")]
        lines.append(self._pace(row))
        for place, line in enumerate(lines):
            x = canvas.shape[1] - _MARGIN - text_width(line, _SMALL)
            write(canvas, line, (x, 8 + 28 * place), _SMALL, _PALE)
        self._draw_time_line(canvas, row, (end, canvas.shape[1] - _MARGIN, HEADER_PX - 5))

    def _happened(self, index: int) -> tuple[list[Collision], int]:
        """Return the collisions up to and with a frame, and how many of them count."""
        past = [c for c in self._result.collisions if c.frame < index + 0.5]
        return past, min(len(past), self._result.burst_size)

    def _pace(self, row: int) -> str:
        """Say how fast the clip plays at a frame, beside its own rate."""
        slower = self._lasts_s[row] / self._usual_s
        if slower < 0.67:
            return f"▶▶ fast forward, {1 / slower:.0f} times"
        return f"slowed {slower:.0f} times" if slower > 1.5 else ""

    def _draw_time_line(self, canvas: Pixels, row: int, ends: tuple[int, int, int]) -> None:
        """Draw a line on which time runs evenly, with the collisions and where this frame is.

        ``ends`` are its left and right in px, and its height.
        """
        frame = self.track.frame
        y = ends[2]

        def place(at: float) -> int:
            share = (at - frame[0]) / max(frame[-1] - frame[0], 1.0)
            return int(ends[0] + (ends[1] - ends[0]) * share + 0.5)

        cv2.line(canvas, (ends[0], y), (ends[1], y), _DIM, 2)
        for collision in self._result.collisions:
            x = place(collision.frame)
            cv2.line(canvas, (x, y - 3), (x, y + 3), rgb(MARKS[collision.kind].colour), 2)
        cv2.circle(canvas, (place(float(frame[row])), y), 4, _BRIGHT, -1, cv2.LINE_AA)

    # ---- footage --------------------------------------------------------------------------------

    def _draw_contacts(self, canvas: Pixels, index: int, row: int, size: float) -> None:
        """Mark the collisions that have just happened."""
        for collision in self._result.collisions:
            if -0.5 <= index - collision.frame < FLASH_FRAMES - 0.5:
                contact = self.layout.place(self._point(contact_px(collision, self.track), row))
                mark(canvas, collision.kind, contact, size, seen=collision.seen)

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
        inside = face - inward * 0.25 * track.ball_diameter_px
        reach = FACE_DIAMETERS * track.ball_diameter_px
        corners = [(inside, -reach), (face, -reach), (face, reach), (inside, reach)]
        points = [self.layout.place(self._aside(along, aside, row)) for along, aside in corners]
        path(canvas, points, rgb(HEAVY))

    def _point(self, along_px: float, row: int) -> Point:
        return image_point(self.track.line, along_px, shift_of(self.track, row))

    def _aside(self, along_px: float, aside_px: float, row: int) -> Point:
        x, y = self._point(along_px, row)
        return (x + aside_px, y) if self.track.line.upright else (x, y + aside_px)

    # ---- strip: the space-time image, scrolling down, newest row on top -------------------------

    def _draw_strip(self, canvas: Pixels, newest: int) -> None:
        """Draw the last frames as rows below each other, shape (STRIP_PX, width, 3)."""
        oldest = max(0, newest + 1 - ROWS)
        image = np.array(self._rows[oldest : newest + 1])[::-1]
        size = (canvas.shape[1], ROW_PX * len(image))
        shown = cv2.resize(image, size, interpolation=cv2.INTER_NEAREST)
        canvas[:] = UNFILLED
        cv2.cvtColor(shown, cv2.COLOR_GRAY2RGB, dst=canvas[: size[1]])
        scale = canvas.shape[1] / image.shape[1]
        lines = [(line, BALL) for line in ball_edges_px(self.track)]
        if self.track.heavy is not None:
            lines.append((self.track.heavy.position_px, HEAVY))
        for line, colour in lines:
            x = (line[oldest : newest + 1] + 0.5) * scale - 0.5
            y = ROW_PX * (newest - np.arange(oldest, newest + 1) + 0.5) - 0.5
            # Unseen stretches part the line.
            for piece in np.split(np.arange(len(x)), np.flatnonzero(~np.isfinite(x))):
                points = [(float(x[k]), float(y[k])) for k in piece if np.isfinite(x[k])]
                if len(points) > 1:
                    path(canvas, points, rgb(colour))
        self._draw_strip_marks(canvas, (oldest, newest), scale)

    def _draw_strip_marks(self, canvas: Pixels, rows: tuple[int, int], scale: float) -> None:
        frame = self.track.frame
        for collision in self._result.collisions:
            if not frame[rows[0]] <= collision.frame < frame[rows[1]] + 0.5:
                continue
            row = float(np.interp(collision.frame, frame, np.arange(len(frame))))
            below = ROW_PX * (rows[1] - row + 0.5) - 0.5
            below = max(STRIP_MARK_PX + 1, below)  # whole from the first moment
            at = ((contact_px(collision, self.track) + 0.5) * scale - 0.5, below)
            mark(canvas, collision.kind, at, STRIP_MARK_PX, seen=collision.seen)
            corner = (round(at[0] + STRIP_MARK_PX + 4), round(at[1] - 0.6 * NUMBER_PX))
            write(canvas, str(collision.number), corner, NUMBER_PX, _BRIGHT)

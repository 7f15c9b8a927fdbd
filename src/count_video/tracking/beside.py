"""What the pictures show beside a body: whether something stands in its way, or moves there.

Two like bodies that meet once, without a wall, move as those of a trial do whose wall is not
reached in the clip, or was left before it. Its ends may show the difference: a face ahead, across
the line of motion, or behind.

One body that turns round once moves as the heavy body of a trial does whose ball could not be
followed. There the pictures change where the body turned, in front of the face that it turned with.
"""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from count_video.records import Floats, Luma, Mask, Point, Track
from count_video.tracking.observation import Observation
from count_video.tracking.pairing import Places, places_of

LAST_PICTURES = 8
"""The velocity at an end is that of so many pictures; what stands still does so in the first and
the last of them."""
MOVES_SIZES = 0.02
"""A body that moves by less than this share of its size from picture to picture comes nowhere."""
HEIGHT_SHARE = 0.3
"""A face is sought so far above and below the line, as a share of the body's size."""
FACE_LEVELS = 4.0
ROWS_SHARE = 0.85
"""Grey levels from one side of an edge to the other, all along it, in this share of the rows."""
EDGE_PX = 2
SMOOTHING_PX = 1.0
PICTURES = 12
"""In so many pictures of a clip something that moves is not always at one place."""
CHANGED_SHARE = 0.1
"""A ball in front of a face covers more of it than this share."""
APART_PX = 3.0
"""The edges of a body are as wide as this."""


def stands_beyond(seen: Observation, track: Track) -> tuple[bool, bool]:
    """Whether one of two bodies comes from a face as the clip begins, and goes to one as it ends.

    What goes to a face comes from it if time is turned round.
    """
    begins, ends = range(LAST_PICTURES)[::-1], range(-LAST_PICTURES, 0)
    return _stands_ahead(seen, track, begins), _stands_ahead(seen, track, ends)


def _stands_ahead(seen: Observation, track: Track, rows: Sequence[int]) -> bool:
    """Whether one of two bodies moves towards a face in some pictures, in this order."""
    ways = _ways(track, rows)
    if not ways:
        return False
    first, last = (_shown(seen, track, row) for row in (rows[0], rows[-1]))
    return any(
        has_face(*(_strip(*shown, track, way)[0] for shown in (first, last))) for way in ways
    )


def moves_beside(seen: Observation, track: Track, frame: float) -> bool:
    """Whether something moves that was not followed, where a body alone turns round at a frame.

    What lies beyond its place there is compared in pictures that show the body. Light that changes
    is no motion, and neither is that of the other bodies that were followed.
    """
    place, body = track.ball.position_px, track.ball
    rows, side = np.flatnonzero(np.isfinite(place)), turning_side(track.frame, place, frame)
    face = np.nanmax(place) + body.high_edge_px if side > 0 else np.nanmin(place) + body.low_edge_px
    way = (float(face) + side * APART_PX, side)
    length = body.high_edge_px - body.low_edge_px
    others = [places_of(one, seen.movers, seen.view) for one in seen.movers.bodies]
    strips = []
    for row in rows[np.linspace(0, len(rows) - 1, PICTURES).astype(int)].tolist():
        luma, shift = _shown(seen, track, row)
        strip, x, y = _strip(luma, shift, track, way, length)
        if track.line.upright:
            x, y = y, x
        hidden = [_covers(other, row, x - shift[0], y - shift[1]) for other in others]
        strips.append(np.where(np.any(hidden, axis=0), np.nan, strip))
    return changes(np.array(strips))


def turning_side(frames: Floats, place_px: Floats, frame: float) -> int:
    """At which end of its way a body turns round at a frame: 1 where places are greatest, or -1.

    Both arrays have shape (n,). Where it turns, its partner may hide it: places are NaN there.
    """
    rows = np.flatnonzero(np.isfinite(place_px))
    turned = place_px[rows[np.argmin(np.abs(frames[rows] - frame))]]
    return 1 if turned >= np.median(place_px[rows]) else -1


def _covers(body: Places, row: int, x: Floats, y: Floats) -> Mask:
    """Which places in a picture a body that was followed may cover."""
    (middle_x, middle_y), reach = body.xy_px[row], body.size_px / 2 + APART_PX
    return np.asarray((np.abs(x - middle_x) < reach[0]) & (np.abs(y - middle_y) < reach[1]))


def changes(strips: Floats) -> bool:
    """Whether strips of one place, shape (pictures, across, along), show something that moves.

    Each is compared with their median, after its light has been made the same; NaN is covered. One
    that is unlike all others may be a title.
    """
    if strips[0].size == 0:
        return False
    shown = np.isfinite(strips).any(axis=0)
    usual = np.full(shown.shape, np.nan)
    usual[shown] = np.nanmedian(strips[:, shown], axis=0)
    unlike = 0
    for strip in strips:
        known = np.isfinite(strip)
        if np.count_nonzero(known) <= 2:
            continue
        light = np.column_stack([usual[known], np.ones(np.count_nonzero(known))])
        same = light @ np.linalg.lstsq(light, strip[known], rcond=None)[0]
        changed = np.count_nonzero(np.abs(strip[known] - same) > FACE_LEVELS)
        unlike += changed > CHANGED_SHARE * strip.size
    return unlike > 1


def _shown(seen: Observation, track: Track, row: int) -> tuple[Luma, Point]:
    """Picture of a row of a track in px of the footage, and how far the camera moved it.

    Its x is along the line of motion, that of the shift along the rows of the footage. The border
    of a region goes on beyond it.
    """
    luma = seen.picture(int(np.searchsorted(seen.frames, track.frame[row])))
    x, y, width, height = seen.view.region
    info = seen.view.footage.info
    beyond = y, info.height_px - y - height, x, info.width_px - x - width
    part = cv2.resize(luma, (width, height))
    whole = np.asarray(cv2.copyMakeBorder(part, *beyond, cv2.BORDER_REPLICATE), np.uint8)
    right, down = (0.0, 0.0) if track.shift_px is None else track.shift_px[row].tolist()
    return whole.T if track.line.upright else whole, (right, down)


def _ways(track: Track, shown: Sequence[int]) -> list[tuple[float, int]]:
    """For each body that moves outward in some rows: where its middle is at last, and which way."""
    if track.heavy is None or len(track.frame) < LAST_PICTURES:
        return []
    bodies = sorted((track.ball, track.heavy), key=lambda body: float(np.nanmean(body.position_px)))
    ways = []
    for body, side in zip(bodies, (-1, 1), strict=True):
        recent = body.position_px[list(shown)]
        rows = np.flatnonzero(np.isfinite(recent))
        if len(rows) < 2 or rows[-1] < len(recent) - 1:
            continue  # it has left the picture
        step = side * float(recent[rows[-1]] - recent[rows[0]]) / float(rows[-1] - rows[0])
        if step > MOVES_SIZES * (body.high_edge_px - body.low_edge_px):
            middle = (body.low_edge_px + body.high_edge_px) / 2
            ways.append((float(recent[-1]) + middle, side))
    return ways


def _strip(
    luma: Luma, shift_px: Point, track: Track, way: tuple[float, int], length: float = np.inf
) -> tuple[Floats, Floats, Floats]:
    """Cut out what lies ahead from a place on, as far as the border or so long.

    Returns the strip and where in the picture each of its values is, by the axis along the line and
    by the other one, all of shape (across, along).
    """
    begins, side = way
    line = track.line
    anchor = line.anchor_x_px, line.anchor_y_px
    about, level = anchor[::-1] if line.upright else anchor
    border = luma.shape[1] - 1.0 if side > 0 else 0.0
    end = begins + side * min(length, max(0.0, (border - begins) * side))
    along = np.arange(min(begins, end), max(begins, end))
    half = max(1.0, HEIGHT_SHARE * track.ball_diameter_px)
    across = level + np.tan(np.radians(line.tilt_deg)) * (along - about)
    rows = np.arange(-half, half + 1)
    right, down = shift_px[::-1] if line.upright else shift_px
    x = np.tile(along, (len(rows), 1)) + right
    y = across[None] + rows[:, None] + down
    if x.size == 0:
        return x, x, y
    smooth = cv2.GaussianBlur(luma.astype(np.float32), (0, 0), SMOOTHING_PX)
    places, mode = (x.astype(np.float32), y.astype(np.float32)), cv2.BORDER_REPLICATE
    picked = cv2.remap(smooth, *places, cv2.INTER_LINEAR, borderMode=mode)
    return np.asarray(picked, dtype=np.float64), x, y


def has_face(before: Floats, after: Floats) -> bool:
    """Whether an edge goes across two strips, shape (across, along), at the same place in both.

    Those of the body itself move on from one to the other.
    """
    steps = np.array([strip[:, EDGE_PX:] - strip[:, :-EDGE_PX] for strip in (before, after)])
    clear = [np.mean(sign * steps > FACE_LEVELS, axis=1) > ROWS_SHARE for sign in (1, -1)]
    return bool(np.all(clear, axis=1).any())

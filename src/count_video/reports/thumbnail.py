"""The space-time image in small, for lists: tracks and marks, no letters."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from count_video.reports.material import Material, ball_edges_px, contact_px
from count_video.reports.overlay import mark, path
from count_video.reports.palette import BALL, HEAVY, rgb
from count_video.reports.stretch import shown_frames, shown_places

WIDTH_PX, HEIGHT_PX = 480, 130
MARK_PX = 4.0
JPEG_QUALITY = 85
BRIGHTEST_PERCENTILES = (1.0, 99.5)


def thumbnail_jpeg(material: Material) -> bytes:
    """Draw the whole of a trial, time to the right, the wall at the bottom, as a JPEG file."""
    frames = shown_frames(material)
    places = shown_places(material, frames)
    canvas = _background(material, frames, places)
    frame = material.track.frame
    x = (frame - frames[0]) / max(frames[1] - frames[0], 1.0) * WIDTH_PX

    def height(place: float) -> float:
        up = (place - places[0]) / (places[1] - places[0])
        return HEIGHT_PX * (1 - up if material.outward > 0 else up)

    heavy = material.track.heavy
    lines = [(line, BALL) for line in ball_edges_px(material.track)]
    lines += [] if heavy is None else [(heavy.position_px, HEAVY)]
    for line, colour in lines:
        seen = np.isfinite(line)
        points = [(float(a), height(float(b))) for a, b in zip(x[seen], line[seen], strict=True)]
        path(canvas, points, rgb(colour))
    for c in material.burst:
        at = float(np.interp(c.frame, frame, x)), height(contact_px(c, material.track))
        mark(canvas, c.kind, at, MARK_PX, seen=c.seen)
    options = [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY]
    _, data = cv2.imencode(".jpg", canvas[:, :, ::-1], options)
    return bytes(data)


def _background(
    material: Material, frames: tuple[float, float], places: tuple[float, float]
) -> NDArray[np.uint8]:
    """Draw the image itself, shape (height, width, 3)."""
    rows, image = material.space_time.frame, material.space_time.image
    inside = (rows >= frames[0]) & (rows <= frames[1])
    low = max(0, int(places[0]))
    piece = image[inside, low : max(low + 2, int(places[1]) + 1)].T
    if material.outward > 0:
        piece = piece[::-1]
    darkest, brightest = np.percentile(piece, BRIGHTEST_PERCENTILES)
    spread = max(1.0, float(brightest - darkest))
    piece = np.clip((piece - darkest) * (255 / spread), 0, 255).astype(np.uint8)
    small = cv2.resize(
        np.ascontiguousarray(piece), (WIDTH_PX, HEIGHT_PX), interpolation=cv2.INTER_AREA
    )
    return np.asarray(cv2.cvtColor(small, cv2.COLOR_GRAY2RGB), np.uint8)

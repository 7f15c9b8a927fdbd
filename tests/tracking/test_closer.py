from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from drawn import background, paint_ball, paint_box, to_luma
from test_free_bodies import SHAPE, bounce, drawn, path_at, track_of

from count_video.records import Floats, Track
from count_video.tracking.patches.blobs import Blob, Sight
from count_video.tracking.patches.parts import completed

RADIUS_PX = 14.0
TABLE = (0.0, 130.0, 240.0, 160.0)
TABLE_GREY = 210.0
"""As bright as the ball, but for the little by which two things always differ."""
PLACED_PX = 0.1
"""RMS by the look: compression and noise of a ball 28 px across leave it less, and a patch that
loses a part of its rim is off by a px and more."""


def errors(track: Track, truth: Floats) -> Floats:
    error = track.ball.position_px - truth
    return np.asarray(error - np.nanmedian(error))


def test_a_ball_that_partly_vanishes_before_a_table_is_placed_by_its_look(tmp_path: Path) -> None:
    x, y = bounce()
    x, y = np.full(len(x), 120.0), y - 6.0
    behind = background(SHAPE, 5)
    paint_box(behind, TABLE, TABLE_GREY)
    rng = np.random.default_rng(3)
    pictures = []
    for place in y:
        canvas = behind.copy()
        paint_ball(canvas, 120.0, place, RADIUS_PX)
        pictures.append(to_luma(canvas, 1.0, rng))

    error = errors(track_of(tmp_path, pictures), y)

    assert np.isfinite(error).mean() > 0.8
    assert float(np.sqrt(np.nanmean(error**2))) <= PLACED_PX


def test_a_ball_that_turns_is_placed_by_its_patch(tmp_path: Path) -> None:
    x, y = bounce()
    pictures = drawn([(x, y)])
    for number, picture in enumerate(pictures):
        angle = number / 3.0  # a mark that goes round
        mark = round(y[number] + 6 * np.sin(angle)), round(x[number] + 6 * np.cos(angle))
        if mark[0] < SHAPE[0] - 3 and mark[1] < SHAPE[1] - 3:
            picture[mark[0] - 2 : mark[0] + 3, mark[1] - 2 : mark[1] + 3] = 30

    error = errors(track_of(tmp_path, pictures), y)

    assert float(np.nanstd(error)) <= 0.5  # half a px, as of patches


def test_parts_of_a_body_are_put_together_where_it_is_seen_in_parts() -> None:
    frame = np.arange(60)
    whole = path_at(60.0 + 40 * np.sin(frame / 6))
    part = path_at(60.0 + 40 * np.sin(frame / 6))
    body = path_at(60.0 + 40 * np.sin(frame / 6))
    for row in range(0, 60, 2):
        body.blobs[row] = piece(whole.blobs[row], 0.0, 8.0)
    ends = [piece(blob, 12.0, 8.0) for blob in whole.blobs]
    part.rows, part.blobs = list(range(0, 60, 2)), ends[::2]
    sights = [
        Sight(row, (body.blobs[row], ends[row]) if row % 2 == 0 else (body.blobs[row],), 0.1)
        for row in range(60)
    ]

    put_together = completed(body, [body, part], sights)

    middle = np.array([blob.left_px + blob.width_px / 2 for blob in put_together.blobs])
    assert np.allclose(middle, whole.x_px)


def test_a_shadow_that_comes_and_goes_is_no_part_of_a_body() -> None:
    frame = np.arange(60)
    body = path_at(60.0 + 40 * np.sin(frame / 6))
    shadow = path_at(60.0 + 40 * np.sin(frame / 6) + 22.0)
    shadow.rows, shadow.blobs = shadow.rows[::2], shadow.blobs[::2]
    seen = dict(zip(shadow.rows, shadow.blobs, strict=True))
    sights = [
        Sight(row, (blob, seen[row]) if row in seen else (blob,), 0.1)
        for row, blob in enumerate(body.blobs)
    ]

    assert completed(body, [body, shadow], sights).blobs == body.blobs


def piece(blob: Blob, offset: float, width: float) -> Blob:
    """Cut a part out of a patch, so many px from its left end."""
    left = blob.left_px + offset
    return replace(
        blob,
        x_px=left + width / 2,
        left_px=left,
        width_px=width,
        area_px=blob.area_px * width / blob.width_px,
    )

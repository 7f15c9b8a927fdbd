"""Which part of the pictures samples hold: what moves, with its surroundings."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from drawn import paint_ball, paint_box

from count_video.errors import FootageError
from count_video.tracking.bodies import find_movers
from count_video.tracking.samples import BLOCK_PX, SURROUNDINGS, Thumbnails, choose_samples, stored
from count_video.tracking.sequences import prepared
from count_video.video.pictures import reduced, scale_to
from count_video.video.store import PictureStore

SIZE = 720, 1280
NOISE_LEVELS = 1.5
RADIUS_PX, WAY_PX = 7.0, 10.0
PLACED_PX = 0.1
"""Of a ball of 14 px."""


def film(x_px: float, y_px: float, number: int = 48) -> tuple[list[np.ndarray], np.ndarray]:
    """Draw a small ball that swings before a rail, in noise, and where it is in each picture."""
    rng = np.random.default_rng(5)
    canvas = np.full(SIZE, 120.0)
    paint_box(canvas, (0.0, y_px + 12.0, SIZE[1], y_px + 20.0), 60.0)
    place = x_px + WAY_PX / 2 * np.sin(np.arange(number) / 5.0)
    pictures = []
    for x in place.tolist():
        picture = canvas.copy()
        paint_ball(picture, x, y_px, RADIUS_PX)
        noisy = picture + rng.normal(0.0, NOISE_LEVELS, SIZE)
        pictures.append(noisy.round().clip(0, 255).astype(np.uint8))
    return pictures, place


def thumbnails_of(pictures: list[np.ndarray]) -> Thumbnails:
    thumbnails = Thumbnails()
    for row, picture in enumerate(pictures):
        thumbnails.add(row, reduced(picture, scale_to(SIZE[1])))
    return thumbnails


@pytest.mark.parametrize(("x_px", "y_px"), [(640.0, 360.0), (30.0, 40.0), (1250.0, 690.0)])
def test_samples_hold_what_moves_with_its_surroundings_and_no_more(
    x_px: float, y_px: float
) -> None:
    pictures, place = film(x_px, y_px)
    found = prepared(pictures, choose_samples(thumbnails_of(pictures).taken()))
    (left, top), (height, width) = found.corner_px, found.pictures[0].shape
    block = BLOCK_PX * scale_to(SIZE[1])
    ends = (
        (left, width, place.min(), place.max(), SIZE[1]),
        (top, height, y_px, y_px, SIZE[0]),
    )
    assert found.scale == 1
    for begin, length, low, high, most in ends:
        assert begin <= max(0.0, low - RADIUS_PX - SURROUNDINGS * block + block)
        assert begin + length >= min(most, high + RADIUS_PX + SURROUNDINGS * block - block)
        # A body touches a block more than it needs at either end.
        assert length <= high - low + 2 * RADIUS_PX + (2 * SURROUNDINGS + 2) * block


def test_a_ball_of_14_px_is_followed_in_a_large_picture() -> None:
    pictures, place = film(900.0, 300.0)
    thumbnails = thumbnails_of(pictures)
    movers = find_movers(pictures, np.arange(len(pictures)), thumbnails)
    (ball,) = movers.bodies
    away = ball.middle_px[:, 0] - place
    assert float(np.std(away)) < PLACED_PX


def test_pictures_that_cannot_all_be_made_are_forgotten(monkeypatch: pytest.MonkeyPatch) -> None:
    closed: list[PictureStore] = []
    # A list's method would not be bound to the store.
    monkeypatch.setattr(PictureStore, "close", lambda store: closed.append(store))  # noqa: PLW0108

    def pictures() -> Iterator[np.ndarray]:
        yield np.zeros((40, 60), np.uint8)
        raise FootageError("no room")

    with pytest.raises(FootageError, match="no room"):
        stored(pictures())
    assert len(closed) == 1

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from drawn import paint_disc, to_luma

from count_video.errors import UsageError
from count_video.tracking.view import View, view_of
from count_video.video.reader import open_footage
from count_video.video.writer import WriteOptions, write_clip

WIDTH, HEIGHT = 4096, 64
DISC = (3001.0, 31.0)
PLACED_PX = 0.1
"""Centroid of a disc of 20 px across, rounded and coded."""


@pytest.fixture(scope="module")
def wide(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("clips") / "wide.mp4"
    canvas = np.full((HEIGHT, WIDTH), 40.0)
    paint_disc(canvas, *DISC, 20.0, 200.0)
    write_clip(path, [to_luma(canvas)] * 3, WriteOptions(crf=10))
    return path


def disc_place(view: View) -> tuple[float, float]:
    """Centroid of the disc in the picture, by what the view shows."""
    luma = next(iter(view.frames())).luma.astype(float) - 40.0
    luma[luma < 20.0] = 0.0
    y, x = np.indices(luma.shape)
    middle = [(axis * luma).sum() / luma.sum() for axis in (x, y)]
    there_x, there_y = view.in_picture(np.array([middle]))[0].tolist()
    return there_x, there_y


@pytest.mark.parametrize(
    ("region", "factor"),
    [(None, 3), ((2900, 4, 203, 55), 1), ((700, 3, 2500, 61), 2)],
)
def test_places_in_a_view_are_places_in_the_picture(
    wide: Path, region: tuple[int, int, int, int] | None, factor: int
) -> None:
    with open_footage(wide) as footage:
        view = view_of(footage, region)

        assert view.factor == factor
        assert disc_place(view) == pytest.approx(DISC, abs=PLACED_PX)


def test_a_view_streams_the_frames_that_were_asked_for(wide: Path) -> None:
    with open_footage(wide) as footage:
        view = view_of(footage, start=1, end=3)

        assert [frame.index for frame in view.frames()] == [1, 2]


def test_a_region_beyond_the_picture_is_refused(wide: Path) -> None:
    with open_footage(wide) as footage, pytest.raises(UsageError, match="does not fit"):
        view_of(footage, (4000, 0, 100, 64))

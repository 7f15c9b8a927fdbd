"""Balls that show by their colour alone, and what colour is not used for."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from drawn import FRAMES, Scene, paint_disc, scene, texture, to_luma

import count_video
from count_video.physics.simulator import Setup, simulate
from count_video.records import Luma
from count_video.tracking.colour import Colours, Mixture
from count_video.tracking.samples import Thumbnails
from count_video.video.reader import open_footage
from count_video.video.store import PictureStore
from count_video.video.writer import WriteOptions, write_clip

RED_GREEN_BLUE = (20.0, 0.0, -55.0)
"""What an orange ball adds to grey: next to nothing to the brightness 0.30 R + 0.59 G + 0.11 B."""
HIDDEN = 0.04
"""Share of its brightness' contrast that the ball keeps."""
RATIO = 16


def coloured(seen: Scene, luma: Sequence[Luma], share: float = 1.0) -> list[np.ndarray]:
    """Colour the ball of a scene, shape (height, width, 3)."""
    pictures = []
    for picture, x in zip(luma, seen.ball_px.tolist(), strict=True):
        orange = np.zeros(seen.shape)
        paint_disc(orange, x, (seen.shape[0] - 1) / 2, seen.radius_px, share)
        rgb = picture[:, :, None] + orange[:, :, None] * np.array(RED_GREEN_BLUE)
        pictures.append(np.clip(np.rint(rgb), 0, 255).astype(np.uint8))
    return pictures


def hidden() -> Scene:
    """A trial whose ball is about as bright as what is behind it."""
    trial = scene()
    return Scene(trial.ball_px, trial.face_px, trial.radius_px, ball_contrast=HIDDEN)


def true_count() -> int:
    return len(simulate(Setup(heavy_mass_kg=0.0105 * RATIO, wall_gap_m=0.03)).burst)


def filmed(path: Path, pictures: Sequence[np.ndarray]) -> Path:
    write_clip(path, pictures, WriteOptions(crf=18))
    return path


def mixture_of(path: Path) -> Mixture | None:
    pictures, thumbnails, colours = PictureStore(), Thumbnails(), Colours()
    with open_footage(path) as footage, pictures:
        for row, frame in enumerate(footage.frames(colour=True)):
            thumbnails.add(row, pictures.append(frame.luma))
            colours.add(frame.chroma)
        return colours.mixture(thumbnails)


def test_the_mixture_adds_the_colour_of_what_moves(tmp_path: Path) -> None:
    trial = hidden()
    mixture = mixture_of(filmed(tmp_path / "orange.mp4", coloured(trial, trial.frames())))
    assert mixture is not None
    u, v = mixture.chroma
    assert u < 0 < v or v < 0 < u  # orange has less of U and more of V


def test_bodies_that_brightness_shows_are_followed_by_it(tmp_path: Path) -> None:
    trial = scene()
    faintly = coloured(trial, trial.frames(), share=0.2)
    assert mixture_of(filmed(tmp_path / "faint.mp4", faintly)) is None
    assert mixture_of(filmed(tmp_path / "grey.mp4", trial.frames())) is None


@pytest.mark.parametrize(("stones", "mixed"), [(0, False), (60, True)])
def test_among_grey_stones_a_body_shows_by_its_colour(stones: int, *, mixed: bool) -> None:
    """Brightness shows it as well before a plain wall; stones differ from it by as much."""
    rng = np.random.default_rng(5)
    wall = texture(7, (160, 320), 120 - stones, 121 + stones, 4)
    thumbnails, colours = Thumbnails(), Colours()
    for row in range(40):
        body = slice(50, 110), slice(40 + 4 * row, 100 + 4 * row)
        luma, chroma = wall.astype(float), np.full((2, 80, 160), 128.0)
        luma[body] = 165.0
        chroma[0, 25:55, 20 + 2 * row : 50 + 2 * row] += 45.0
        thumbnails.add(row, to_luma(luma, 1.0, rng))
        colours.add(to_luma(chroma, 1.0, rng))
    assert (colours.mixture(thumbnails) is not None) == mixed


@pytest.mark.slow
def test_a_ball_that_is_as_bright_as_the_wall_is_not_counted_without_colour(tmp_path: Path) -> None:
    assert count_video.count(filmed(tmp_path / "grey.mp4", hidden().frames())).count != true_count()


def test_a_ball_that_only_its_colour_shows_is_counted_after_a_grey_beginning(
    tmp_path: Path,
) -> None:
    trial, title = hidden(), [np.full((112, 320, 3), 30, np.uint8)] * 20
    path = filmed(tmp_path / "titled.mp4", [*title, *coloured(trial, trial.frames())])
    assert mixture_of(path) is not None
    result = count_video.count(path)
    assert result.count == true_count()
    assert len(result.track_table()) <= 20 + FRAMES


@pytest.mark.parametrize("rows", [40, 41])
def test_a_mixture_has_the_place_and_the_size_of_the_brightness(rows: int) -> None:
    luma = np.full((rows, 60), 100, np.uint8)
    chroma = np.full((2, (rows + 1) // 2, 30), 128, np.uint8)
    chroma[1, 10:, 20:] = 160
    mixed = Mixture((0.0, 1.0), (128.0, 128.0)).of(luma, np.vstack(list(chroma)))
    assert mixed.shape == luma.shape
    assert np.all(mixed[:18] == 100)
    assert np.all(mixed[:, :38] == 100)
    assert np.all(mixed[22:, 42:] == 132)


def test_pictures_without_colour_between_others_keep_their_places() -> None:
    colours, thumbnails = Colours(), Thumbnails()
    orange = np.full((2, 12, 20), 128, np.uint8)
    orange[1, 4:8, 4:8] = 180
    with PictureStore() as pictures:
        for row, chroma in enumerate([None, orange, None, orange]):
            luma = np.full((24, 40), 100 + row, np.uint8)
            thumbnails.add(row, pictures.append(luma))
            colours.add(chroma)
        mixed, small = colours.mixed(pictures, Mixture((0.0, 1.0), (128.0, 128.0)))
    with mixed:
        assert [int(one[0, 0]) for one in mixed] == [100, 101, 102, 103]
        assert [int(one[12, 12]) for one in mixed] == [100, 153, 102, 155]
        assert sorted(small.taken()) == [0, 1, 2, 3]

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
import pytest

from count_video.errors import FootageError
from count_video.records import Luma
from count_video.video.pictures import scale_to
from count_video.video.store import PictureStore

PICTURE = np.arange(12 * 20, dtype=np.uint8).reshape(12, 20)
LIGHT_LEVELS = 1
"""A step of the light changes no pixel by more."""
STEP = 8
"""Grey levels from one picture to the next: what is no more than noise is not written."""


def written(pictures: Sequence[Luma], a_chunk: int) -> int:
    """Write pictures, so many at a time; bytes of the file from which all come back as they were.

    The first one stays in memory.
    """
    with PictureStore(memory_bytes=0, chunk_bytes=a_chunk * pictures[0].size) as store:
        for picture in pictures:
            store.append(picture)
        assert all(np.array_equal(found, true) for found, true in zip(store, pictures, strict=True))
        return store.bytes_written


@pytest.mark.parametrize("held", [0, 3, 100], ids=["one in memory", "some in a file", "in memory"])
def test_pictures_come_back_as_they_were(held: int) -> None:
    with PictureStore(held * PICTURE.size, 2 * PICTURE.size) as store:
        for k in range(9):
            store.append(PICTURE // 2 + np.uint8(STEP * k))
        assert len(store) == 9
        for k in (0, 8, 4, -1):
            assert np.array_equal(store[k], PICTURE // 2 + np.uint8(STEP * (k % 9)))
        assert [int(one[0, 0]) for one in store] == [STEP * k for k in range(9)]
        assert [int(one[0, 0]) for one in store[-2:]] == [7 * STEP, 8 * STEP]
        with pytest.raises(IndexError):
            store[9]


def test_the_caller_may_use_its_picture_again() -> None:
    own = PICTURE.copy()
    with PictureStore(0) as store:
        thumbnails = [store.append(own), store.append(own)]
        own[:] = 0
        assert all(np.array_equal(kept, PICTURE) for kept in (*store, *thumbnails))


def test_a_turned_view_is_kept_as_it_is_seen() -> None:
    with PictureStore(0) as store:
        for _ in range(2):
            store.append(PICTURE.T)
        assert all(np.array_equal(kept, PICTURE.T) for kept in store)


def test_the_thumbnail_of_a_picture_stays_as_it_was_when_others_are_added() -> None:
    with PictureStore(0, 2 * PICTURE.size) as store:
        thumbnails = [store.append(PICTURE // 2 + np.uint8(STEP * k)) for k in range(9)]
        assert [int(one[0, 0]) for one in thumbnails] == [STEP * k for k in range(9)]


@pytest.mark.parametrize("temporary", ["gone", None])
def test_a_full_disk_is_one_clear_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, temporary: str | None
) -> None:
    """Where the folder for temporary files vanished, and where no folder at all can be written."""
    monkeypatch.setattr(tempfile, "tempdir", temporary and str(tmp_path / temporary))
    monkeypatch.setattr(tempfile, "_candidate_tempdir_list", lambda: [str(tmp_path / "none")])
    with PictureStore(0, 1) as store:
        store.append(PICTURE)
        with pytest.raises(FootageError, match="no room for the pictures"):
            store.append(PICTURE)


def test_the_temporary_file_has_no_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    with PictureStore(0, 1) as store:
        store.append(PICTURE)
        store.append(PICTURE + np.uint8(STEP))
        assert store.bytes_written > 0
        assert list(tmp_path.iterdir()) == []


def test_only_what_changes_goes_to_the_file() -> None:
    rng = np.random.default_rng(3)
    scene = rng.integers(80, 120, (200, 400)).astype(np.uint8)
    pictures = []
    for k in range(30):
        picture = scene.copy()
        picture[90:110, 150 + k : 170 + k] = 250
        pictures.append(picture)
    assert 0 < written(pictures, 10) < 0.1 * len(pictures) * scene.size


def test_two_bodies_take_no_more_than_what_lies_around_each() -> None:
    """What lies between them is not written, nor is all that moves if it is all the picture."""
    rng = np.random.default_rng(5)
    scene = rng.integers(80, 120, (200, 400)).astype(np.uint8)
    pictures = []
    for k in range(30):
        picture = scene.copy()
        picture[20:40, 20 + k : 40 + k] = 250
        picture[150:180, 360 - k : 390 - k] = 20
        pictures.append(picture)
    reach_px = 5 * scale_to(scene.shape[1])
    around = (20 + 2 * reach_px) * (20 + 10 + 2 * reach_px) + (30 + 2 * reach_px) * (
        30 + 10 + 2 * reach_px
    )
    assert 0 < written(pictures, 10) < len(pictures) * around


def test_the_last_rows_and_columns_are_written_though_thumbnails_lack_them() -> None:
    scene = np.full((203, 1279), 100, np.uint8)
    scale = scale_to(scene.shape[1])
    assert all(side % scale for side in scene.shape)
    pictures = []
    for k in range(20):
        picture = scene.copy()
        picture[150:, 1000 + 8 * k :] = 200
        pictures.append(picture)
    assert 0 < written(pictures, 5) < len(pictures) * scene.size


def test_what_is_not_written_has_less_noise_than_a_picture() -> None:
    """A scene that shows one picture's noise again and again would seem to move with no body."""
    rng = np.random.default_rng(6)
    noise = 6.0
    pictures = [
        rng.normal(120.0, noise, (120, 160)).round().clip(0, 255).astype(np.uint8)
        for _ in range(24)
    ]
    with PictureStore(memory_bytes=16 * pictures[0].size, chunk_bytes=8 * 160 * 120) as store:
        for picture in pictures:
            store.append(picture)
        assert store.bytes_written < 0.05 * 8 * pictures[0].size  # where noise alone is so large
        assert np.std(store[-1]) < 0.5 * noise


def test_a_scene_at_rest_takes_no_space() -> None:
    assert written([PICTURE] * 9, 3) == 0


@pytest.mark.parametrize("width", [8, 40])
def test_a_dark_body_that_comes_in_is_no_change_of_the_light(width: int) -> None:
    """Whatever share of the picture it takes: the rest comes back as it was, from the first one."""
    scene = np.tile(np.where(np.arange(320) % 80 < 40, 140, 120).astype(np.uint8), (240, 1))
    pictures = [scene]
    for k in range(29):
        picture = scene.copy()
        picture[60:180, 200 + k : 200 + k + width] = 20
        pictures.append(picture)
    with PictureStore(memory_bytes=0, chunk_bytes=10 * scene.size) as store:
        for picture in pictures:
            store.append(picture)
        assert 0 < store.bytes_written < 0.25 * len(pictures) * scene.size
        apart = [cv2.absdiff(found, true) for found, true in zip(store, pictures, strict=True)]
    assert max(int(one.max()) for one in apart) <= LIGHT_LEVELS

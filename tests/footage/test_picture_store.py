from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
import pytest

from count_video.errors import FootageError
from count_video.footage.store import PictureStore

PICTURE = np.arange(12 * 20, dtype=np.uint8).reshape(12, 20)


@pytest.mark.parametrize("held", [0, 3, 100], ids=["all in a file", "some in a file", "in memory"])
def test_pictures_come_back_as_they_were(held: int) -> None:
    with PictureStore(held * PICTURE.size) as store:
        for k in range(9):
            store.append(PICTURE + np.uint8(k))
        assert len(store) == 9
        for k in (0, 8, 4, -1):
            assert np.array_equal(store[k], PICTURE + np.uint8(k % 9))
        assert [int(one[0, 0]) for one in store] == list(range(9))
        assert [int(one[0, 0]) for one in store[-2:]] == [7, 8]
        with pytest.raises(IndexError):
            store[9]


def test_the_caller_may_use_its_picture_again() -> None:
    own = PICTURE.copy()
    with PictureStore() as store:
        store.append(own)
        own[:] = 0
        assert np.array_equal(store[0], PICTURE)


def test_a_turned_view_is_kept_as_it_looks() -> None:
    with PictureStore(0) as store:
        store.append(PICTURE.T)
        assert np.array_equal(store[0], PICTURE.T)


def test_no_room_is_one_clear_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "gone"))
    with PictureStore(0) as store, pytest.raises(FootageError, match="no room for the pictures"):
        store.append(PICTURE)


def test_the_temporary_file_has_no_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    with PictureStore(0) as store:
        store.append(PICTURE)
        assert list(tmp_path.iterdir()) == []

"""The pictures of a clip, kept as bytes for the stages after decoding: bounded in memory.

Pictures beyond the limit go to a temporary file that has no name and is gone with the process,
whatever happens. Of those only the box in which anything differs from the first picture is written,
chunk by chunk; the first picture, in the light of each, shows the rest of the scene.
"""

from __future__ import annotations

import tempfile
from bisect import bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import IO, overload

import cv2
import numpy as np
from numpy.typing import NDArray

from count_video.errors import FootageError
from count_video.footage.pictures import scale_to, thumbnail
from count_video.records import Floats

Luma = NDArray[np.uint8]

MEMORY_BYTES = 64_000_000
"""Pictures up to so many bytes stay in memory as they are."""
CHUNK_BYTES = 24_000_000
"""Pictures that are written together, in one box."""
NOISE_RATIO, LEVELS = 4.0, (0.5, 4.0)
"""What differs, as a root mean square over some pictures, by so many times as much as most of the
picture does is more than noise, for the first picture's own noise makes up to 3.6 times as much in
one of 40 000 pixels. Kept is what differs by this, but at least by the first, and at most by the
second of these grey levels: another scene differs everywhere."""
MARGIN = 2
"""Kept around it, in px of a thumbnail."""
LIGHT_STRIDE = 4
"""The light is measured in every fourth pixel of every fourth row of a thumbnail."""


@dataclass(frozen=True)
class _Chunk:
    """Pictures in the file."""

    first: int
    """Place of the first picture in the clip."""
    offset: int
    """Where it begins in the file, in bytes."""
    box: tuple[int, int, int, int]
    """Left, top, right, bottom in px."""
    light: Floats
    """How much brighter each picture is than the first of the clip, as a ratio."""

    @property
    def shape(self) -> tuple[int, int]:
        left, top, right, bottom = self.box
        return bottom - top, right - left


class PictureStore(Sequence[Luma]):
    """Pictures of one size in order; a context manager that releases the temporary file."""

    def __init__(self, memory_bytes: int = MEMORY_BYTES, chunk_bytes: int = CHUNK_BYTES) -> None:
        self._memory_bytes, self._chunk_bytes = memory_bytes, chunk_bytes
        self._kept: list[Luma] = []
        self._waiting: list[Luma] = []
        self._thumbnails: list[Luma] = []
        """Of the pictures that wait."""
        self._chunks: list[_Chunk] = []
        self._file: IO[bytes] | None = None
        self._first: Luma | None = None
        self._before: Luma | None = None
        """Thumbnail of the first picture."""
        self._count = 0
        self.bytes_written = 0
        """Length of the temporary file."""

    def __enter__(self) -> PictureStore:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Forget all pictures."""
        self._kept, self._waiting, self._thumbnails, self._chunks = [], [], [], []
        self._first = self._before = None
        self._count = self.bytes_written = 0
        if self._file is not None:
            self._file.close()
            self._file = None

    def append(self, picture: Luma) -> Luma:
        """Keep a copy of a picture, shape (height, width), and return its thumbnail.

        Raises
        ------
        FootageError
            If the temporary file cannot be written.
        """
        copy = np.array(picture, order="C")
        small = thumbnail(copy)
        if self._first is None:
            self._first, self._before = copy, small
        self._count += 1
        if not self._waiting and not self._chunks and self._count * copy.size <= self._memory_bytes:
            self._kept.append(copy)
            return small
        self._waiting.append(copy)
        self._thumbnails.append(small)
        if len(self._waiting) * copy.size >= self._chunk_bytes:
            self._write()
        return small

    def _write(self) -> None:
        """Write the pictures that wait to the file."""
        assert self._before is not None
        light, small_box = _changes(self._thumbnails, self._before)
        left, top, right, bottom = box = _at_full_size(small_box, self._waiting[0].shape)
        first = self._count - len(self._waiting)
        try:
            if self._file is None:
                self._file = tempfile.TemporaryFile()  # noqa: SIM115  closed by close()
            self._file.seek(self.bytes_written)
            for picture in self._waiting:
                self._file.write(np.ascontiguousarray(picture[top:bottom, left:right]).data)
        except OSError as error:
            raise FootageError(
                "no room for the pictures of the clip in the folder for temporary files "
                f"({error.strerror}): free some space there, set TMPDIR to another folder, or give "
                "a part of the clip with --region, --start and --end"
            ) from error
        self._chunks.append(_Chunk(first, self.bytes_written, box, light))
        self.bytes_written += len(self._waiting) * (bottom - top) * (right - left)
        self._waiting, self._thumbnails = [], []

    def __len__(self) -> int:
        return self._count

    @overload
    def __getitem__(self, place: int) -> Luma: ...
    @overload
    def __getitem__(self, place: slice) -> list[Luma]: ...
    def __getitem__(self, place: int | slice) -> Luma | list[Luma]:
        if isinstance(place, slice):
            return [self[k] for k in range(*place.indices(self._count))]
        if not -self._count <= place < self._count:
            raise IndexError(place)
        place %= self._count
        if place < len(self._kept):
            return self._kept[place]
        waiting = place - (self._count - len(self._waiting))
        return self._waiting[waiting] if waiting >= 0 else self._read(place)

    def _read(self, place: int) -> Luma:
        """Read a picture from the file."""
        chunk = self._chunks[bisect_right(self._chunks, place, key=lambda one: one.first) - 1]
        if self._file is None or self._first is None:
            raise IndexError(place)
        height, width = chunk.shape
        self._file.seek(chunk.offset + (place - chunk.first) * height * width)
        left, top, right, bottom = chunk.box
        piece = np.frombuffer(self._file.read(height * width), np.uint8).reshape(chunk.shape)
        if chunk.shape == self._first.shape:
            return piece
        light = float(chunk.light[place - chunk.first])
        picture = np.asarray(cv2.convertScaleAbs(self._first, alpha=light), np.uint8)
        picture[top:bottom, left:right] = piece
        return picture

    def __iter__(self) -> Iterator[Luma]:
        return (self[k] for k in range(self._count))


def _changes(thumbnails: Sequence[Luma], before: Luma) -> tuple[Floats, tuple[int, int, int, int]]:
    """Light of each picture over the first one's, and the box in which more than it changes.

    The box is that of thumbnails: left, top, right, bottom in their px.
    """
    some = slice(None, None, LIGHT_STRIDE), slice(None, None, LIGHT_STRIDE)
    bright = before[some] >= max(1.0, float(np.median(before[some])))
    first = _smooth(before)
    light, squares = np.ones(len(thumbnails)), np.zeros(before.shape, np.float32)
    for number, one in enumerate(thumbnails):
        smooth = _smooth(one)
        if bright.any():
            light[number] = np.median(smooth[some][bright] / first[some][bright])
        cv2.accumulateSquare(smooth - np.float32(light[number]) * first, squares)
    away = np.sqrt(squares / len(thumbnails))
    differs = away > np.clip(NOISE_RATIO * float(np.median(away)), *LEVELS)
    rows, columns = (np.flatnonzero(differs.any(axis=axis)) for axis in (1, 0))
    if len(rows) == 0:
        return light, (0, 0, 0, 0)
    (top, bottom), (left, right) = (
        (int(found[0]) - MARGIN, int(found[-1]) + 1 + MARGIN) for found in (rows, columns)
    )
    return light, (left, top, right, bottom)


def _smooth(small: Luma) -> NDArray[np.float32]:
    return np.asarray(cv2.blur(small.astype(np.float32), (3, 3)), np.float32)


def _at_full_size(
    box: tuple[int, int, int, int], shape: tuple[int, ...]
) -> tuple[int, int, int, int]:
    """Turn px of a thumbnail into those of its picture, and keep within that."""
    height, width = shape
    scale = scale_to(width)
    left, top, right, bottom = (max(0, edge) * scale for edge in box)
    return left, top, min(right, width), min(bottom, height)

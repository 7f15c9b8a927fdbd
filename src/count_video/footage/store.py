"""The pictures of a clip, kept as bytes for the stages after decoding: bounded in memory.

Pictures beyond the limit go to a temporary file that has no name and is gone with the process,
whatever happens. Of those only the box in which anything differs from the first picture is written,
chunk by chunk; the first picture shows the rest of the scene.
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
from count_video.signals import MEDIAN_TO_SIGMA

Luma = NDArray[np.uint8]

MEMORY_BYTES = 64_000_000
"""Pictures up to so many bytes stay in memory as they are."""
CHUNK_BYTES = 24_000_000
"""Pictures that are written together, in one box."""
THUMBNAIL_PX = 256
"""Width to which pictures are reduced to find where they differ."""
NOISE_SIGMAS, LEVELS = 5.0, (0.5, 1.5)
"""What differs by more than the noise is kept, and at least by the first, at most by the second of
these grey levels: what may be more than noise goes to the file."""
MARGIN = 2
"""Kept around it, in px of a thumbnail."""


@dataclass(frozen=True)
class _Chunk:
    """Pictures in the file."""

    first: int
    """Place of the first picture in the clip."""
    offset: int
    """Where it begins in the file, in bytes."""
    box: tuple[int, int, int, int]
    """Left, top, right, bottom in px."""

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
        self._chunks: list[_Chunk] = []
        self._file: IO[bytes] | None = None
        self._first: Luma | None = None
        self._count = 0
        self.bytes_written = 0
        """Length of the temporary file."""

    def __enter__(self) -> PictureStore:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Forget all pictures."""
        self._kept, self._waiting, self._chunks, self._first = [], [], [], None
        self._count = self.bytes_written = 0
        if self._file is not None:
            self._file.close()
            self._file = None

    def append(self, picture: Luma) -> None:
        """Keep a copy of a picture, shape (height, width).

        Raises
        ------
        FootageError
            If the temporary file cannot be written.
        """
        copy = np.array(picture, order="C")
        if self._first is None:
            self._first = copy
        self._count += 1
        if not self._waiting and not self._chunks and self._count * copy.size <= self._memory_bytes:
            self._kept.append(copy)
            return
        self._waiting.append(copy)
        if len(self._waiting) * copy.size >= self._chunk_bytes:
            self._write()

    def _write(self) -> None:
        """Write the pictures that wait to the file."""
        box = _differs(self._waiting, self._first)
        left, top, right, bottom = box
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
        self._chunks.append(_Chunk(first, self.bytes_written, box))
        self.bytes_written += len(self._waiting) * (bottom - top) * (right - left)
        self._waiting = []

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
        picture = self._first.copy()
        picture[top:bottom, left:right] = piece
        return picture

    def __iter__(self) -> Iterator[Luma]:
        return (self[k] for k in range(self._count))


def _differs(pictures: Sequence[Luma], first: Luma | None) -> tuple[int, int, int, int]:
    """Box in which any of the pictures differs from the first of the clip by more than noise."""
    height, width = pictures[0].shape
    scale = max(1, -(-width // THUMBNAIL_PX))
    if first is None:
        return 0, 0, width, height
    before = _thumbnail(first, scale)
    away = np.array([cv2.absdiff(_thumbnail(one, scale), before) for one in pictures])
    noise = MEDIAN_TO_SIGMA * float(np.median(away))
    differs = (away > np.clip(NOISE_SIGMAS * noise, *LEVELS)).any(axis=0)
    rows, columns = (np.flatnonzero(differs.any(axis=axis)) for axis in (1, 0))
    if len(rows) == 0:
        return 0, 0, 0, 0
    (top, bottom), (left, right) = (
        (max(0, (int(found[0]) - MARGIN) * scale), (int(found[-1]) + 1 + MARGIN) * scale)
        for found in (rows, columns)
    )
    return left, top, min(right, width), min(bottom, height)


def _thumbnail(picture: Luma, scale: int) -> NDArray[np.float32]:
    """Reduce a picture by plain means, in grey levels."""
    height, width = (max(1, size // scale) for size in picture.shape)
    # Of a whole number of blocks means are taken twice as fast; the margin holds the rest.
    whole = picture[: height * scale, : width * scale].astype(np.float32)
    reduced = cv2.resize(whole, (width, height), interpolation=cv2.INTER_AREA)
    return np.asarray(cv2.blur(reduced, (3, 3)), dtype=np.float32)

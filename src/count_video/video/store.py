"""The pictures of a clip, kept as bytes for the stages after decoding: bounded in memory.

Pictures beyond the limit go to a temporary file that has no name and is gone with the process,
whatever happens. Of those only the box in which anything differs from the first picture is written,
chunk by chunk; the first picture, in the light of each, shows the rest of the scene.
"""

from __future__ import annotations

import tempfile
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import IO, overload

import cv2
import numpy as np

from count_video.errors import FootageError
from count_video.records import Floats, Luma, Mask, Pixels
from count_video.video.pictures import reduced, scale_to

MEMORY_BYTES = 48_000_000
"""Pictures up to so many bytes stay in memory as they are."""
CHUNK_BYTES = 12_000_000
"""Pictures that are written together, in one box."""
LIGHTS = 8
"""The first picture is kept in so many lights, those of the pictures that were read last."""
LIGHT_STEPS = 256
"""Steps of the light, as parts of that of the first picture: one of them changes no pixel by more
than a grey level, and pictures in the same light share what is not stored."""


@dataclass(frozen=True)
class _Chunk:
    """Pictures in the file."""

    first: int
    """Place of the first picture in the clip."""
    offset: int
    """Where it begins in the file, in bytes."""
    box: tuple[slice, slice]
    """Rows and columns that are stored."""
    light: Floats
    """How much brighter each picture is than the first of the clip, as a ratio."""


class PictureStore(Sequence[Luma]):
    """Pictures of one size in order, read when all were added; a context manager."""

    def __init__(self, memory_bytes: int = MEMORY_BYTES, chunk_bytes: int = CHUNK_BYTES) -> None:
        self._memory_bytes, self._chunk_bytes = memory_bytes, chunk_bytes
        self._file: IO[bytes] | None = None
        self._forget()

    def __enter__(self) -> PictureStore:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Forget all pictures, and release the temporary file."""
        self._forget()
        if self._file is not None:
            self._file.close()
            self._file = None

    def _forget(self) -> None:
        self._count = 0
        self._kept: list[Luma] = []
        """In memory: the first picture at least."""
        self._waiting = np.empty((0, 0, 0), np.uint8)
        """Room for the pictures of one chunk. It is used again and again, for to take new memory
        for a picture costs far more than to copy into it."""
        self._thumbnails: list[Luma] = []
        """Of the pictures that wait in it."""
        self._chunks: list[_Chunk] = []
        self._first_in_light = lru_cache(LIGHTS)(
            lambda light: np.asarray(cv2.convertScaleAbs(self._kept[0], alpha=light), np.uint8)
        )
        self.bytes_written = 0
        """Length of the temporary file."""

    def append(self, picture: Luma) -> Luma:
        """Keep a copy of a picture, shape (height, width), and return its thumbnail.

        Raises
        ------
        FootageError
            If the temporary file cannot be written.
        """
        scale = scale_to(picture.shape[1])
        all_kept = self._count == len(self._kept)
        self._count += 1
        if self._count == 1 or (all_kept and self._count * picture.size <= self._memory_bytes):
            self._kept.append(np.array(picture, order="C"))
            return reduced(self._kept[-1], scale)
        if not len(self._waiting):
            room = -(-self._chunk_bytes // picture.size)
            self._waiting = np.empty((room, *picture.shape), np.uint8)
        copy = self._waiting[len(self._thumbnails)]
        copy[...] = picture
        small = copy.copy() if scale == 1 else reduced(copy, scale)
        self._thumbnails.append(small)
        if len(self._thumbnails) == len(self._waiting):
            self._write()
        return small

    def _write(self) -> None:
        """Write the pictures that wait to the file."""
        first = self._kept[0]
        scale = scale_to(first.shape[1])
        light, differs = _changes(self._thumbnails, reduced(first, scale))
        box = _box_around(differs, scale, first.shape)
        try:
            if self._file is None:
                self._file = tempfile.TemporaryFile()  # noqa: SIM115  closed by close()
            end = self._file.seek(self.bytes_written)
            for picture in self._waiting:
                end += self._file.write(np.ascontiguousarray(picture[box]).data)
        except OSError as error:
            raise FootageError(
                "no room for the pictures of the clip in the folder for temporary files "
                f"({error.strerror}): free some space there, set TMPDIR to another folder, or give "
                "a part of the clip with --region, --start and --end"
            ) from error
        place = self._count - len(self._thumbnails)
        self._chunks.append(_Chunk(place, self.bytes_written, box, light))
        self.bytes_written, self._thumbnails = end, []

    def __len__(self) -> int:
        return self._count

    @overload
    def __getitem__(self, place: int) -> Luma: ...
    @overload
    def __getitem__(self, place: slice) -> list[Luma]: ...
    def __getitem__(self, place: int | slice) -> Luma | list[Luma]:
        if isinstance(place, slice):
            return [self[k] for k in range(*place.indices(self._count))]
        place = range(self._count)[place]
        if place < len(self._kept):
            return self._kept[place]
        waiting = place - (self._count - len(self._thumbnails))
        return self._waiting[waiting] if waiting >= 0 else self._read(place)

    def _read(self, place: int) -> Luma:
        """Read a picture from the file."""
        assert self._file is not None
        chunk = self._chunks[bisect_right(self._chunks, place, key=lambda one: one.first) - 1]
        height, width = (edges.stop - edges.start for edges in chunk.box)
        self._file.seek(chunk.offset + (place - chunk.first) * height * width)
        piece = np.frombuffer(self._file.read(height * width), np.uint8).reshape(height, width)
        if piece.shape == self._kept[0].shape:
            return piece
        picture = self._first_in_light(float(chunk.light[place - chunk.first])).copy()
        picture[chunk.box] = piece
        return picture


def _changes(thumbnails: Sequence[Luma], before: Luma) -> tuple[Floats, Mask]:
    """Light of each picture over the first one's, and where more than that changes."""
    first, light = _smooth(before), np.ones(len(thumbnails))
    usual = np.ones(before.shape, np.uint8)
    for _ in range(2):  # the second time without bodies that come in, which are no light
        bright, squares = max(1.0, cv2.mean(before, usual)[0]), np.zeros(before.shape, np.float32)
        for number, one in enumerate(thumbnails):
            light[number] = round(cv2.mean(one, usual)[0] / bright * LIGHT_STEPS) / LIGHT_STEPS
            cv2.accumulateSquare(_smooth(one) - np.float32(light[number]) * first, squares)
        away = np.sqrt(squares / len(thumbnails))
        # What differs by 4 times as much as most of the picture does is more than noise, for the
        # first picture's own noise makes up to 3.6 times as much in one of 40 000 pixels. It
        # differs by half a grey level at least; ...
        least = max(4.0 * float(np.median(away)), 0.5)
        usual = (away <= least).astype(np.uint8)
    # ... and by 4 levels at most, for another scene differs everywhere.
    return light, away > min(least, 4.0)


def _smooth(small: Luma) -> Pixels:
    return np.asarray(cv2.blur(small.astype(np.float32), (3, 3)), np.float32)


def _box_around(differs: Mask, scale: int, shape: tuple[int, ...]) -> tuple[slice, slice]:
    """Rows and columns of a picture that hold what differs in its thumbnail, and 2 px around."""
    if not differs.any():
        return slice(0, 0), slice(0, 0)
    found = np.argwhere(differs)
    rows, columns = (
        slice(max(0, int(first) - 2) * scale, min((int(last) + 3) * scale, size))
        for first, last, size in zip(found.min(axis=0), found.max(axis=0), shape, strict=True)
    )
    return rows, columns

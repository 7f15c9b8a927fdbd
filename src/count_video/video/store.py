"""The pictures of a clip, kept as bytes for the stages after decoding: bounded in memory.

Pictures beyond the limit go to a temporary file that has no name and is gone with the process,
whatever happens. Of those only what differs from the mean of those in memory is written, chunk by
chunk, in boxes; that mean, in the light of each, shows the rest of the scene.
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
"""Pictures that are written together, in the same boxes."""
MEAN_OF = 8
"""The mean is that of so many pictures: it has hardly any noise, as the median of many has."""
LIGHTS = 8
"""The mean is kept in so many lights, those of the pictures that were read last."""
LIGHT_STEPS = 256
"""Steps of the light, as parts of that of the mean: one of them changes no pixel by more than a
grey level, and pictures in the same light share what is not stored."""


Box = tuple[slice, slice]
"""Rows and columns of a picture."""


@dataclass(frozen=True)
class _Chunk:
    """Pictures in the file."""

    first: int
    """Place of the first picture in the clip."""
    offset: int
    """Where it begins in the file, in bytes."""
    boxes: list[Box]
    """What of each picture is stored, one box after the other."""
    light: Floats
    """How much brighter each picture is than the mean of those in memory, as a ratio."""


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
        self._usual = np.empty((0, 0), np.uint8)
        """Mean of some pictures in memory, once others are written."""
        self._usual_in_light = lru_cache(LIGHTS)(
            lambda light: np.asarray(cv2.convertScaleAbs(self._usual, alpha=light), np.uint8)
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
        if not self._chunks:
            self._usual = _mean(self._kept[:: -(-len(self._kept) // MEAN_OF)])
        scale = scale_to(self._usual.shape[1])
        light, differs = _changes(self._thumbnails, reduced(self._usual, scale))
        boxes = _boxes_around(differs, scale, self._usual.shape)
        try:
            if self._file is None:
                self._file = tempfile.TemporaryFile()  # noqa: SIM115  closed by close()
            end = self._file.seek(self.bytes_written)
            for picture in self._waiting:
                end += self._file.write(b"".join(picture[box].tobytes() for box in boxes))
        except OSError as error:
            raise FootageError(
                "no room for the pictures of the clip in the folder for temporary files "
                f"({error.strerror}): free some space there, set TMPDIR to another folder, or give "
                "a part of the clip with --region, --start and --end"
            ) from error
        place = self._count - len(self._thumbnails)
        self._chunks.append(_Chunk(place, self.bytes_written, boxes, light))
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
        size = sum(_pixels_in(box) for box in chunk.boxes)
        self._file.seek(chunk.offset + (place - chunk.first) * size)
        stored = np.frombuffer(self._file.read(size), np.uint8)
        if size == self._usual.size:
            return stored.reshape(self._usual.shape)
        picture = self._usual_in_light(float(chunk.light[place - chunk.first])).copy()
        begin = 0
        for box in chunk.boxes:
            end = begin + _pixels_in(box)
            picture[box] = stored[begin:end].reshape(picture[box].shape)
            begin = end
        return picture


def _mean(pictures: Sequence[Luma]) -> Luma:
    total = np.zeros(pictures[0].shape, np.float32)
    for one in pictures:
        cv2.accumulate(one, total)
    return np.asarray(cv2.convertScaleAbs(total, alpha=1 / len(pictures)), np.uint8)


def _changes(thumbnails: Sequence[Luma], before: Luma) -> tuple[Floats, Mask]:
    """Light of each picture over that of the usual one, and where more than that changes."""
    first, light = _smooth(before), np.ones(len(thumbnails))
    usual = np.ones(before.shape, np.uint8)
    for _ in range(2):  # the second time without bodies that come in, which are no light
        bright, squares = max(1.0, cv2.mean(before, usual)[0]), np.zeros(before.shape, np.float32)
        for number, one in enumerate(thumbnails):
            light[number] = round(cv2.mean(one, usual)[0] / bright * LIGHT_STEPS) / LIGHT_STEPS
            cv2.accumulateSquare(_smooth(one) - np.float32(light[number]) * first, squares)
        away = np.sqrt(squares / len(thumbnails))
        # What differs by 4 times as much as most of the picture does is more than noise, for that
        # of a single picture before makes up to 3.6 times as much in one of 40 000 pixels. It
        # differs by half a grey level at least; ...
        least = max(4.0 * float(np.median(away)), 0.5)
        usual = (away <= least).astype(np.uint8)
    # ... and by 4 levels at most, for another scene differs everywhere.
    return light, away > min(least, 4.0)


def _smooth(small: Luma) -> Pixels:
    return np.asarray(cv2.blur(small.astype(np.float32), (3, 3)), np.float32)


def _boxes_around(differs: Mask, scale: int, shape: tuple[int, ...]) -> list[Box]:
    """Boxes of a picture that hold what differs in its thumbnail, and 2 px around.

    There is one for each part that hangs together, or one for all where that takes no more.
    """
    around = cv2.dilate(differs.astype(np.uint8), np.ones((5, 5), np.uint8))
    parts = cv2.connectedComponentsWithStats(around)[2][1:, :4].tolist()
    whole = cv2.boundingRect(around)
    if sum(width * height for _, _, width, height in parts) >= whole[2] * whole[3]:
        parts = [whole]
    # Of the last rows and columns, which fill no px of the thumbnail, its last ones say it.
    (rows, columns), (last_y, last_x) = shape, differs.shape
    return [
        (
            slice(y * scale, rows if y + height == last_y else (y + height) * scale),
            slice(x * scale, columns if x + width == last_x else (x + width) * scale),
        )
        for x, y, width, height in parts
    ]


def _pixels_in(box: Box) -> int:
    rows, columns = box
    return int((rows.stop - rows.start) * (columns.stop - columns.start))

"""The pictures of a clip, kept as bytes for the stages after decoding: bounded in memory.

Pictures beyond the limit go to a temporary file that has no name and is gone with the process,
whatever happens.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Sequence
from typing import IO, overload

import numpy as np
from numpy.typing import NDArray

from count_video.errors import FootageError

Luma = NDArray[np.uint8]

MEMORY_BYTES = 64_000_000
"""Pictures up to so many bytes stay in memory."""


class PictureStore(Sequence[Luma]):
    """Pictures of one size in order; a context manager that releases the temporary file."""

    def __init__(self, memory_bytes: int = MEMORY_BYTES) -> None:
        self._memory_bytes = memory_bytes
        self._kept: list[Luma] = []
        self._file: IO[bytes] | None = None
        self._count = 0
        self._shape = (0, 0)

    def __enter__(self) -> PictureStore:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Forget all pictures."""
        self._kept = []
        self._count = 0
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
        self._shape = picture.shape[0], picture.shape[1]
        if (len(self._kept) + 1) * picture.size <= self._memory_bytes:
            self._kept.append(np.array(picture, order="C"))
        else:
            self._write(picture)
        self._count += 1

    def _write(self, picture: Luma) -> None:
        try:
            if self._file is None:
                self._file = tempfile.TemporaryFile()  # noqa: SIM115  closed by close()
            self._file.write(np.ascontiguousarray(picture).data)
        except OSError as error:
            raise FootageError(
                f"no room for the pictures of the clip in {tempfile.gettempdir()} "
                f"({error.strerror}): free some space there, set TMPDIR to another folder, or give "
                "a part of the clip with --region, --start and --end"
            ) from error

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
        if self._file is None:
            raise IndexError(place)
        size = self._shape[0] * self._shape[1]
        self._file.seek((place - len(self._kept)) * size)
        return np.frombuffer(self._file.read(size), np.uint8).reshape(self._shape)

    def __iter__(self) -> Iterator[Luma]:
        return (self[k] for k in range(self._count))

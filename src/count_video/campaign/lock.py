"""One run at a time in a folder: a lock of the operating system, gone when its process is."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from count_video.errors import UsageError

if sys.platform == "win32":
    import msvcrt

    def _take(descriptor: int) -> None:
        msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
else:
    import fcntl

    def _take(descriptor: int) -> None:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)


@contextmanager
def held(file: Path) -> Iterator[None]:
    """Hold the lock on a file (made if needed, and left there: only the lock itself counts).

    The system lets go of the lock when the process ends, however it ends; workers do not inherit
    it.

    Raises
    ------
    UsageError
        Somebody else holds it, or the file system cannot lock.
    """
    descriptor = os.open(file, os.O_RDWR | os.O_CREAT, 0o666)
    try:
        try:
            _take(descriptor)
        except (BlockingIOError, PermissionError) as error:
            raise UsageError(
                f"{file.parent.parent}: another run is at work in this folder; wait for its end, "
                "or give another folder with -o"
            ) from error
        except OSError as error:
            raise UsageError(
                f"{file.parent.parent}: this folder cannot be locked ({error.strerror}); "
                "give one on another disk with -o"
            ) from error
        yield
    finally:
        os.close(descriptor)

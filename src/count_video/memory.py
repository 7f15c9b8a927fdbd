"""A machine without memory for the work on a clip: one sentence, whoever found that out.

Python, NumPy and OpenCV raise an error. Libraries that are loaded and OpenBLAS end the process
without a word instead, so for them it is found out before.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache

from count_video.errors import MachineError

LEAST_BYTES = {"RLIMIT_AS": ("v", 600_000_000), "RLIMIT_DATA": ("d", 200_000_000)}
"""Limits of a process: the option of ``ulimit`` that sets each, and the least that will do. On
Linux the libraries take 430 MB of addresses and 120 MB of data, a small clip most of the rest."""
_BUFFER_BYTES = 64_000_000
"""OpenBLAS takes half of it, once, at the first product of large matrices."""
_LARGE = 64
_OPENCV_NO_MEMORY = -4  # cv::Error::StsNoMem


def check_limits() -> None:
    """Check that the libraries can be loaded at all; to be done before they are.

    Raises
    ------
    MachineError
        Whoever started this process lets it have too little memory.
    """
    try:
        import resource  # noqa: PLC0415 - not on every system
    except ImportError:
        return
    for name, (option, least) in LEAST_BYTES.items():
        limit = resource.getrlimit(getattr(resource, name))[0]
        if limit != resource.RLIM_INFINITY and limit < least:
            raise MachineError(
                f"this process may have {limit // 1_000_000} MB of memory (ulimit -{option}) and "
                f"needs at least {least // 1_000_000}; raise the limit (ulimit -S{option} "
                f"{least // 1000}, or unlimited)"
            )


@contextmanager
def shortage_told() -> Iterator[None]:
    """Turn the errors of Python, NumPy and OpenCV for want of memory into one of ours.

    Raises
    ------
    MachineError
        What was done here found no memory.
    """
    import cv2  # noqa: PLC0415 - takes time, and memory that check_limits asks for

    try:
        _take_buffer()
        yield
    except MemoryError as error:
        raise _shortage() from error
    except cv2.error as error:
        if error.code != _OPENCV_NO_MEMORY:
            raise
        raise _shortage() from error


@cache
def _take_buffer() -> None:
    """Have OpenBLAS take its buffer while there is room for it, for it ends the process if not.

    Raises
    ------
    MemoryError
        There is no room.
    """
    import numpy as np  # noqa: PLC0415 - as above

    bytearray(_BUFFER_BYTES)
    large = np.ones((_LARGE, _LARGE))
    large @ large


def _shortage() -> MachineError:
    return MachineError(
        "there is not enough memory for this clip; close other programs, count fewer clips at a "
        "time (--jobs), or use a part of the picture (--region)"
    )

"""A machine without memory for the work on a clip: one sentence, whoever found that out.

Python, NumPy and OpenCV raise an error. Libraries that are loaded and OpenBLAS end the process
without a word instead, so for them it is found out before.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache

from count_video.errors import CountVideoError, MachineError

LEAST_BYTES = {"RLIMIT_AS": ("v", 600_000_000), "RLIMIT_DATA": ("d", 200_000_000)}
"""Limits of a process: the option of ``ulimit`` that sets each, and the least that will do. On
Linux the libraries take 430 MB of addresses and 120 MB of data, a small clip most of the rest."""
LIBRARIES_BYTES = 430_000_000
DRAWING_BYTES = 300_000_000
"""SciPy and matplotlib take 120 MB; the rest is for pictures and an encoder. With less SciPy's
OpenBLAS asks for its buffer for ever as it is loaded."""
_BUFFER_BYTES = 64_000_000
"""OpenBLAS takes half of it, once, at the first product of large matrices."""
_LARGE = 64
_PICTURE_BYTES = 150_000_000
"""More than any picture takes that is decoded."""
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
def shortage_explained() -> Iterator[None]:
    """Turn any error for want of memory into one of ours.

    Raises
    ------
    MachineError
        What was done here found no memory.
    """
    try:
        yield
    except (CountVideoError, OSError):
        raise
    except Exception as error:
        if not _for_want_of_memory(error):
            raise
        raise MachineError(
            "there is not enough memory; close other programs, count fewer clips at a time "
            "(--jobs), or use a part of the picture (--region)"
        ) from error


def _for_want_of_memory(error: Exception) -> bool:
    """Return whether an error says so, or there is none: each library has errors of its own."""
    said = getattr(error, "code", None) == _OPENCV_NO_MEMORY
    if said or isinstance(error, MemoryError):
        return True
    try:
        check_memory()
    except MemoryError:
        return True
    return False


def check_memory(wanted_bytes: int = _PICTURE_BYTES) -> None:
    """Raise MemoryError unless so much is free: FFmpeg calls it damage where it found none.

    The other way round, it says of absurd sizes in damaged files that there was no memory for them.
    """
    bytes(wanted_bytes)  # taken by calloc: never touched, and free again at once


@cache
def take_buffer() -> None:
    """Have OpenBLAS take its buffer while there is memory, for it ends the process if not.

    Raises
    ------
    MemoryError
        There is not enough memory.
    """
    import numpy as np  # noqa: PLC0415 - takes memory that is asked for before

    check_memory(_BUFFER_BYTES)
    large = np.ones((_LARGE, _LARGE))
    large @ large

"""A machine without memory for the work on a clip: one sentence, whoever found that out."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import cv2

from count_video.errors import MachineError

_OPENCV_NO_MEMORY = -4  # cv::Error::StsNoMem


@contextmanager
def shortage_told() -> Iterator[None]:
    """Turn the errors of Python, NumPy and OpenCV for want of memory into one of ours.

    Raises
    ------
    MachineError
        What was done here found no memory.
    """
    try:
        yield
    except MemoryError as error:
        raise _shortage() from error
    except cv2.error as error:
        if error.code != _OPENCV_NO_MEMORY:
            raise
        raise _shortage() from error


def _shortage() -> MachineError:
    return MachineError(
        "there is not enough memory for this clip; close other programs, count fewer clips at a "
        "time (--jobs), or use a part of the picture (--region)"
    )

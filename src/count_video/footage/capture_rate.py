"""The camera's frame rate: what the user says, else what the camera wrote into the file."""

from __future__ import annotations

import math
from collections.abc import Mapping

from count_video.errors import UsageError
from count_video.records import RateSource

CAPTURE_RATE_TAGS = ("com.android.capture.fps",)
"""Tags that state the capture rate. Android's recorders write it for high-speed and time-lapse
video; the container's own rate is then the playing rate."""


def capture_rate(
    option: float | None, metadata: Mapping[str, str]
) -> tuple[float | None, RateSource]:
    """Return frames per second of real time and where that was learnt.

    Parameters
    ----------
    option
        What the user says, None for nothing.
    metadata
        Tags of the container; names are matched without regard to case, since Matroska writes
        them in capitals.

    Raises
    ------
    UsageError
        If the user's value is no positive finite number.
    """
    if option is not None:
        if not (math.isfinite(option) and option > 0):
            raise UsageError(f"--capture-fps {option}: give a positive number of frames per second")
        return float(option), "option"
    for name, text in metadata.items():
        if name.lower() in CAPTURE_RATE_TAGS:
            rate = _positive_number(text)
            if rate is not None:
                return rate, "metadata"
    return None, "unknown"


def _positive_number(text: str) -> float | None:
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) and value > 0 else None

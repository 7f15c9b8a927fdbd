"""The camera's frame rate: what the user says, else what the camera wrote into the file."""

from __future__ import annotations

import math
from collections.abc import Iterable

from count_video.errors import UsageError
from count_video.records import RateSource

CAPTURE_RATE_TAGS = frozenset({"com.android.capture.fps"})
"""Tags that state the capture rate. Android's recorders write this one; the container's own rate
is then the rate of playing. Apple's high-speed films have no such tag: straight from the camera
they play at the capture rate, but a shared copy is slowed down and does not say so."""


def check_capture_rate(option: float | None) -> None:
    """Raise UsageError if what the user says is no positive finite number."""
    if option is not None and not (math.isfinite(option) and option > 0):
        raise UsageError(
            f"capture rate {option:g}: give the camera's frames per second, a positive number"
        )


def capture_rate(
    option: float | None, tags: Iterable[tuple[str, str]]
) -> tuple[float | None, RateSource]:
    """Return frames per second of real time and where that was learnt.

    Parameters
    ----------
    option
        What the user says, None for nothing.
    tags
        Names and values written into the file. Case does not matter (Matroska writes names in
        capitals), and values that are no positive number count as absent.

    Raises
    ------
    UsageError
        If the user's value is no positive finite number.
    """
    check_capture_rate(option)
    if option is not None:
        return float(option), "option"
    for name, text in tags:
        if name.lower() in CAPTURE_RATE_TAGS and (rate := _positive(text)) is not None:
            return rate, "metadata"
    return None, "unknown"


def _positive(text: str) -> float | None:
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) and value > 0 else None

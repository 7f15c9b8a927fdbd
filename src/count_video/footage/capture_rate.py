"""The camera's frame rate: what the user says, else what the camera wrote into the file."""

from __future__ import annotations

from collections.abc import Iterable

from count_video.errors import UsageError
from count_video.inputs import CAPTURE_RATE
from count_video.records import RateSource

CAPTURE_RATE_TAGS = frozenset({"com.android.capture.fps"})
"""Tags that state the capture rate. Android's recorders write this one; the container's own rate
is then the rate of playing. Apple's high-speed films have no such tag: straight from the camera
they play at the capture rate, but a shared copy is slowed down and does not say so."""


def check_capture_rate(option: float | None) -> None:
    """Raise UsageError if no camera has the rate that the user says."""
    if option is not None and not CAPTURE_RATE.holds(option):
        raise UsageError(f"capture rate {option:g}: give the camera's rate, {CAPTURE_RATE}")


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
        capitals), and values that no camera has count as absent.

    Raises
    ------
    UsageError
        If no camera has the user's rate.
    """
    check_capture_rate(option)
    if option is not None:
        return float(option), "option"
    for name, text in tags:
        if name.lower() in CAPTURE_RATE_TAGS and (rate := _stated(text)) is not None:
            return rate, "metadata"
    return None, "unknown"


def _stated(text: str) -> float | None:
    try:
        return CAPTURE_RATE(text.strip())
    except UsageError:
        return None


def real_time_s(frame: float, capture_fps: float) -> float:
    """Return seconds of real time from frame 0 to a frame coordinate."""
    return frame / capture_fps

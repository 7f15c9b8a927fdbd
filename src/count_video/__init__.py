"""Count the collisions in slow-motion footage of the "pi by collisions" experiment.

>>> import count_video
>>> result = count_video.count("trial.mp4", masses=(1050, 10.5))
>>> result.count
31

:func:`count` counts one clip, :func:`count_all` many at the same time, :func:`theory` is the exact
count of two masses, and :func:`plan` what a set-up will count before it is filmed. Everything that
takes time to import is imported when one of them is first used.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from count_video.errors import CountVideoError, FootageError, MachineError, UsageError

if TYPE_CHECKING:
    from count_video.api import count, count_all, plan, theory
    from count_video.physics.theory import Theory
    from count_video.result import Result

__version__ = "0.2.0"
__all__ = [
    "CountVideoError",
    "FootageError",
    "MachineError",
    "Result",
    "Theory",
    "UsageError",
    "__version__",
    "count",
    "count_all",
    "plan",
    "theory",
]


def __getattr__(name: str) -> object:
    """Import the public functions and classes when one of them is first asked for."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from count_video import api  # noqa: PLC0415 - NumPy and the video library take time

    return getattr(api, name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})

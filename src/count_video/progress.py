"""How far a long job has come: reported by the library, shown (or not) by whoever called it.

Library code calls the three methods whether the progress is shown or not; ``NO_PROGRESS`` is the
listener that does nothing.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Protocol, TypeVar

_Item = TypeVar("_Item")


class Progress(Protocol):
    """A listener that learns how many frames of a stage are done."""

    def start(self, total: int | None, label: str) -> None:
        """Begin a stage of ``total`` frames (None: not known), ending the one before it."""

    def advance(self, frames: int) -> None:
        """Count ``frames`` more as done."""

    def finish(self) -> None:
        """End the stage; harmless when none has begun."""


class _NoProgress:
    """The listener that does nothing."""

    def start(self, total: int | None, label: str) -> None:
        """Ignore the stage."""

    def advance(self, frames: int) -> None:
        """Ignore the frames."""

    def finish(self) -> None:
        """Ignore the end."""


NO_PROGRESS: Progress = _NoProgress()


def counted_off(frames: Iterable[_Item], progress: Progress) -> Iterator[_Item]:
    """Pass frames on and report each once it is done with."""
    for frame in frames:
        yield frame
        progress.advance(1)

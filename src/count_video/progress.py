"""How far a long job has come: reported by the library, shown (or not) by whoever called it.

Library code calls the three methods whether the progress is shown or not; ``TerminalBar`` is the
listener for a person at a terminal.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, TextIO, TypeVar

if TYPE_CHECKING:  # rich takes time, and most runs show no bar
    from rich.progress import Progress as Bar

_Item = TypeVar("_Item")


class Progress:
    """A listener that learns how many frames of a stage are done; this one does nothing of it."""

    def start(self, total: int | None, label: str) -> None:
        """Begin a stage of ``total`` frames (None: not known), ending the one before it."""

    def advance(self, frames: int) -> None:
        """Count ``frames`` more as done."""

    def finish(self) -> None:
        """End the stage; harmless when none has begun."""


NO_PROGRESS = Progress()


def counted_off(frames: Iterable[_Item], progress: Progress) -> Iterator[_Item]:
    """Pass frames on and report each once it is done with."""
    for frame in frames:
        yield frame
        progress.advance(1)


class TerminalBar(Progress):
    """What advances in a clip or a campaign, on one line, with the time that is left."""

    def __init__(self, stream: TextIO, unit: str = "frames") -> None:
        """Show what advances, counted in ``unit``, a plural; clips are shown with their pace."""
        self._stream, self._unit = stream, unit
        self._bar: Bar | None = None

    def start(self, total: int | None, label: str) -> None:
        """Draw an empty bar; without a total it only shows that something happens."""
        from rich import progress  # noqa: PLC0415 - see above
        from rich.console import Console  # noqa: PLC0415

        self.finish()
        clips = self._unit == "clips"
        self._bar = progress.Progress(
            # Labels carry file names, in which square brackets are no mark-up.
            progress.TextColumn("{task.description}", markup=False),
            progress.BarColumn(bar_width=24),  # leaves space on the line for the "^C" of a person
            progress.MofNCompleteColumn(),
            progress.TextColumn(self._unit),
            *([progress.TextColumn("{task.fields[pace]}")] if clips else []),
            progress.TimeRemainingColumn(),
            console=Console(file=self._stream),
            transient=True,
            redirect_stdout=False,
            redirect_stderr=False,
            speed_estimate_period=600 if clips else 30,  # a clip takes seconds
        )
        self._bar.add_task(label, total=total or None, pace="-/min")
        self._bar.start()

    def advance(self, frames: int) -> None:
        """Move the bar on."""
        if self._bar is not None:
            task = self._bar.tasks[0]
            pace = f"{60 * task.speed:.3g}/min" if task.speed else "-/min"
            self._bar.update(task.id, advance=frames, pace=pace)

    def finish(self) -> None:
        """Remove the bar and show the cursor again."""
        if self._bar is not None:
            self._bar.stop()
            self._bar = None

    @contextmanager
    def aside(self) -> Iterator[None]:
        """Take the bar away while something else is written on the same terminal."""
        if self._bar is not None:
            self._bar.stop()
        yield
        if self._bar is not None:
            self._bar.start()

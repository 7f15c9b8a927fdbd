"""The progress bar, for a person at a terminal."""

from __future__ import annotations

from typing import TextIO

from rich import progress
from rich.console import Console


class TerminalBar:
    """A bar on a terminal that is wiped away at its end, so that the result stands alone."""

    def __init__(self, stream: TextIO, unit: str = "frames") -> None:
        """Show on a stream what advances, counted in ``unit``, a plural."""
        self._stream = stream
        self._unit = unit
        self._bar: progress.Progress | None = None

    def start(self, total: int | None, label: str) -> None:
        """Draw an empty bar; without a total it only shows that something happens."""
        self.finish()
        self._bar = _drawn_on(self._stream, self._unit)
        self._bar.add_task(label, total=total or None)
        self._bar.start()

    def advance(self, frames: int) -> None:
        """Move the bar on."""
        if self._bar is not None:
            self._bar.advance(self._bar.task_ids[0], frames)

    def finish(self) -> None:
        """Wipe the bar away and give the cursor back."""
        if self._bar is not None:
            self._bar.stop()
            self._bar = None


def _drawn_on(stream: TextIO, unit: str) -> progress.Progress:
    return progress.Progress(
        # Labels carry file names, in which square brackets are no mark-up.
        progress.TextColumn("{task.description}", markup=False),
        progress.BarColumn(bar_width=24),  # leaves room on the line for the "^C" of a person
        progress.MofNCompleteColumn(),
        progress.TextColumn(unit),
        progress.TimeRemainingColumn(),
        console=Console(file=stream),
        transient=True,
        redirect_stdout=False,
        redirect_stderr=False,
    )

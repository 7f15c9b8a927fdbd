"""A progress bar for a person at a terminal, removed at its end."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TextIO

from rich import progress
from rich.console import Console
from rich.text import Text


class TerminalBar:
    """What advances in a clip or a campaign, on one line, with the time that is left."""

    def __init__(self, stream: TextIO, unit: str = "frames", *, per_minute: bool = False) -> None:
        """Show on a stream what advances, counted in ``unit``, a plural.

        ``per_minute`` shows how many of them are done in a minute as well.
        """
        self._stream = stream
        self._unit = unit
        self._per_minute = per_minute
        self._bar: progress.Progress | None = None

    def start(self, total: int | None, label: str) -> None:
        """Draw an empty bar; without a total it only shows that something happens."""
        self.finish()
        self._bar = self._drawn()
        self._bar.add_task(label, total=total or None)
        self._bar.start()

    def advance(self, frames: int) -> None:
        """Move the bar on."""
        if self._bar is not None:
            self._bar.advance(self._bar.task_ids[0], frames)

    def finish(self) -> None:
        """Remove the bar and show the cursor again."""
        if self._bar is not None:
            self._bar.stop()
            self._bar = None

    @contextmanager
    def aside(self) -> Iterator[None]:
        """Take the bar away while something else is written on the same terminal."""
        if self._bar is None:
            yield
            return
        self._bar.stop()
        try:
            yield
        finally:
            self._bar.start()

    def _drawn(self) -> progress.Progress:
        return progress.Progress(
            # Labels carry file names, in which square brackets are no mark-up.
            progress.TextColumn("{task.description}", markup=False),
            progress.BarColumn(bar_width=24),  # leaves space on the line for the "^C" of a person
            progress.MofNCompleteColumn(),
            progress.TextColumn(self._unit),
            *([_Rate()] if self._per_minute else []),
            progress.TimeRemainingColumn(),
            console=Console(file=self._stream),
            transient=True,
            redirect_stdout=False,
            redirect_stderr=False,
            # A clip takes seconds, so a short period would hold none.
            speed_estimate_period=600 if self._per_minute else 30,
        )


class _Rate(progress.ProgressColumn):
    """Units a minute at the present pace."""

    def render(self, task: progress.Task) -> Text:
        """Write the rate; a dash until it is known."""
        speed = task.finished_speed or task.speed
        return Text("-/min" if not speed else f"{speed * 60:.3g}/min", style="progress.data.speed")

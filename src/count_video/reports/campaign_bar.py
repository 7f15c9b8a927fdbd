"""The progress bar of a campaign, for a person at a terminal."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TextIO

from rich import progress
from rich.console import Console
from rich.text import Text


class CampaignBar:
    """Clips done, clips a minute and time left, on a bar that is wiped away at its end."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._bar: progress.Progress | None = None

    def start(self, total: int | None, label: str) -> None:
        """Draw an empty bar for so many clips."""
        self.finish()
        self._bar = progress.Progress(
            progress.TextColumn("{task.description}", markup=False),
            progress.BarColumn(bar_width=24),
            progress.MofNCompleteColumn(),
            progress.TextColumn("clips"),
            _Rate(),
            progress.TimeRemainingColumn(),
            console=Console(file=self._stream),
            transient=True,
            redirect_stdout=False,
            redirect_stderr=False,
            speed_estimate_period=600,  # a clip takes seconds, so a short memory would hold none
        )
        self._bar.add_task(label, total=total)
        self._bar.start()

    def advance(self, frames: int) -> None:
        """Move the bar on by so many clips."""
        if self._bar is not None:
            self._bar.advance(self._bar.task_ids[0], frames)

    def finish(self) -> None:
        """Wipe the bar away and give the cursor back."""
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


class _Rate(progress.ProgressColumn):
    """Clips a minute at the present pace."""

    def render(self, task: progress.Task) -> Text:
        """Write the rate; a dash until it is known."""
        speed = task.finished_speed or task.speed
        return Text("-/min" if not speed else f"{speed * 60:.3g}/min", style="progress.data.speed")

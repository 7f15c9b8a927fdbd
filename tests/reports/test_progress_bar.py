from __future__ import annotations

import os
import pty
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TextIO

import pytest

from count_video.progress import NO_PROGRESS, TerminalBar

SHOW_CURSOR = "\x1b[?25h"


@dataclass(frozen=True)
class Terminal:
    """A terminal of this process's own: what is written into ``screen`` can be read back."""

    screen: TextIO
    reader: int

    def written(self) -> str:
        self.screen.flush()
        os.set_blocking(self.reader, False)
        pieces = []
        while True:
            try:
                pieces.append(os.read(self.reader, 65536))
            except BlockingIOError:
                return b"".join(pieces).decode("utf-8")


@pytest.fixture
def terminal(monkeypatch: pytest.MonkeyPatch) -> Iterator[Terminal]:
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "80")
    reader, writer = pty.openpty()
    with os.fdopen(writer, "w", encoding="utf-8") as screen:
        yield Terminal(screen, reader)
    os.close(reader)


def test_the_bar_shows_label_and_frames_and_is_wiped_away(terminal: Terminal) -> None:
    bar = TerminalBar(terminal.screen)
    bar.start(300, "reading [red] trial.mp4")
    bar.advance(120)
    bar.advance(30)
    bar.finish()
    written = terminal.written()
    assert "reading [red] trial.mp4" in written
    assert "150/300" in written
    assert written.rindex(SHOW_CURSOR) > written.rindex("150/300")
    assert written.endswith("\x1b[2K"), "the last thing done is to clear the bar's line"


def test_a_stage_of_unknown_length_is_shown_without_an_end(terminal: Terminal) -> None:
    bar = TerminalBar(terminal.screen)
    bar.start(None, "reading")
    bar.advance(42)
    bar.finish()
    assert "42/?" in terminal.written()


def test_a_new_stage_ends_the_one_before(terminal: Terminal) -> None:
    bar = TerminalBar(terminal.screen)
    bar.start(10, "first")
    bar.start(20, "second")
    bar.advance(5)
    bar.finish()
    written = terminal.written()
    assert written.index("first") < written.index("second")
    assert "5/20" in written


@pytest.mark.parametrize("listener", ["bar", "silence"])
def test_ending_what_never_began_is_harmless(terminal: Terminal, listener: str) -> None:
    progress = TerminalBar(terminal.screen) if listener == "bar" else NO_PROGRESS
    progress.advance(1)
    progress.finish()
    progress.finish()
    assert terminal.written() == ""

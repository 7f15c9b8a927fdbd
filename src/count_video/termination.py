"""An end from outside: at once, with nothing left behind and the exit code that shells expect.

An exception that a signal raises may come while a library calls back, is lost there, and the
command goes on. So the signal's handler does what is left to do itself, and leaves.
"""

from __future__ import annotations

import os
import signal
from collections.abc import Callable
from contextlib import suppress
from types import FrameType

from count_video.outputs import discard_unfinished

_SIGNALS = ("SIGINT", "SIGTERM", "SIGHUP")  # the last is not known to Windows
_last_actions: list[Callable[[], object]] = []


def before_the_end(action: Callable[[], object]) -> None:
    """Have something done before a signal ends the command, the latest wish first."""
    _last_actions.append(action)


def end_well_on_signals(complain: Callable[[str], object]) -> None:
    """Let the signals that ask for an end do so with 128 plus their number.

    A signal that the caller lets this process ignore, as ``nohup`` does, stays ignored.
    """

    def end(number: int, _frame: FrameType | None) -> None:
        for name in names:
            signal.signal(getattr(signal, name), signal.SIG_IGN)
        for action in reversed(_last_actions):
            with suppress(OSError):
                action()
        discard_unfinished()
        name = signal.Signals(number).name
        complain("interrupted" if name == "SIGINT" else f"ended by {name}")
        os._exit(128 + number)

    names = [name for name in _SIGNALS if hasattr(signal, name)]
    for name in names:
        if signal.getsignal(getattr(signal, name)) != signal.SIG_IGN:
            signal.signal(getattr(signal, name), end)

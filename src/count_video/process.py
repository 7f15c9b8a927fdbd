"""The process of a command: streams of its own, and an end from outside.

An exception that a signal raises may come while a library calls back, is lost there, and the
command goes on. So the signal's handler does what is left to do itself, and leaves: at once, with
nothing left behind and the exit code that shells expect.
"""

from __future__ import annotations

import io
import os
import signal
import sys
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


def leave_cores_to_the_decoder() -> None:
    """Keep the linear algebra, whose matrices are small, from waiting in threads of its own.

    It reads its settings when numpy is imported, which has not happened yet.
    """
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


def keep_libraries_off_the_streams() -> None:
    """Give this program streams of its own, and let what libraries in C print go nowhere.

    They write to the descriptors 1 and 2. Where the caller has closed one of the first three, a
    file opened later would take its number, and get what is meant for the stream.
    """
    for number in range(3):
        with suppress(OSError):
            os.fstat(number)
            continue
        os.open(os.devnull, os.O_RDWR)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for name, number in (("stdout", 1), ("stderr", 2)):
        stream = getattr(sys, name)
        if isinstance(stream, io.TextIOWrapper):
            stream.flush()
            own = open(  # noqa: SIM115 - it lasts as long as the process
                os.dup(number),
                "w",
                buffering=1 if name == "stderr" else -1,  # each complaint at once
                encoding=stream.encoding,
                errors=stream.errors,
                closefd=False,  # open to the end, as the streams of the interpreter are
            )
            setattr(sys, name, own)
            stream.detach()
            os.dup2(nowhere, number)
    os.close(nowhere)


def show_any_file_name() -> None:
    """Let a sign that the terminal's encoding lacks be written as its escape."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")


def flush_stdout() -> None:
    """Write out what is left, so that an error comes now and not as the interpreter leaves."""
    if sys.stdout is not None:  # it is None when the caller has closed it
        sys.stdout.flush()


def give_stdout_up() -> None:
    """Point stdout at nothing, so that the interpreter's own last flush cannot fail as well."""
    if sys.stdout is not None:
        with suppress(OSError, ValueError):
            closed_pipe = sys.stdout.fileno()
            nothing = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nothing, closed_pipe)
            os.close(nothing)

"""The process of a command: its streams, its memory, and an end from outside."""

from __future__ import annotations

import gc
import io
import os
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache, partial
from types import FrameType

from count_video.errors import CountVideoError, MachineError
from count_video.outputs import discard_unfinished

NEW_OBJECTS = 50_000
"""Python searches for cycles of objects after so many new ones."""

# ---- streams and signals -------------------------------------------------------------------------
# An exception that a signal raises may come while a library calls back, is lost there, and the
# command goes on. So the signal's handler does what is left to do itself, and leaves: at once, with
# nothing left behind and the exit code that shells expect.

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
        for one in known:
            signal.signal(one, signal.SIG_IGN)
        name = signal.Signals(number).name
        words = "interrupted" if name == "SIGINT" else f"ended by {name}"
        last: Callable[[], object] = partial(complain, words)
        for action in (*reversed(_last_actions), discard_unfinished, last):
            # A stream that is written to right now raises a RuntimeError.
            with suppress(OSError, RuntimeError):
                action()
        os._exit(128 + number)

    known = [one for one in signal.Signals if one.name in _SIGNALS]
    for one in known:
        if signal.getsignal(one) != signal.SIG_IGN:
            signal.signal(one, end)


def spare_the_processor() -> None:
    """Keep libraries from threads that wait, and Python from searching for cycles time and again.

    The matrices and pictures of linear algebra and image processing are small: threads save no
    time, and take processor time. They read their settings when NumPy and OpenCV are imported,
    which has not happened yet. A count makes many objects and hardly a cycle of them: the usual
    search, ever again after some hundreds, takes one or two hundredths of the time.
    """
    for name in ("OPENBLAS_NUM_THREADS", "OPENCV_FOR_THREADS_NUM"):
        os.environ.setdefault(name, "1")
    gc.set_threshold(NEW_OBJECTS)


def usable_cores() -> int:
    """Count the cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def keep_libraries_off_the_streams() -> None:
    """Give this program streams of its own, and let what libraries in C print go nowhere.

    They write to the descriptors 1 and 2. Where the caller has closed one of the first three, a
    file opened later would take its number, and get what is meant for the stream.
    """
    # The lowest free number is taken first, so all three are open once a higher one is given.
    while (nowhere := os.open(os.devnull, os.O_RDWR)) < 3:
        pass
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
            setattr(sys, f"__{name}__", own)  # of which shutil asks for the terminal's size
            stream.detach()
            os.dup2(nowhere, number)
    os.close(nowhere)


def show_any_file_name() -> None:
    """Let a sign that the terminal's encoding lacks be written as its escape."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")


def give_stdout_up() -> None:
    """Point stdout at nothing, so that the interpreter's own last flush cannot fail as well."""
    if sys.stdout is not None:
        with suppress(OSError, ValueError), open(os.devnull, "wb") as nothing:
            os.dup2(nothing.fileno(), sys.stdout.fileno())


# ---- memory --------------------------------------------------------------------------------------
# Python, NumPy and OpenCV raise an error. Libraries that are loaded and OpenBLAS end the process
# without a word instead, so for them it is found out before.

LEAST_BYTES = {"RLIMIT_AS": ("v", 600_000_000), "RLIMIT_DATA": ("d", 200_000_000)}
"""Limits of a process: the option of ``ulimit`` that sets each, and the least that will do. On
Linux the libraries take 430 MB of addresses and 120 MB of data, a small clip most of the rest."""
LIBRARIES_BYTES = 430_000_000
DRAWING_BYTES = 300_000_000
"""SciPy and matplotlib take 120 MB; the rest is for pictures and an encoder. With less SciPy's
OpenBLAS asks for its buffer for ever as it is loaded."""
_BUFFER_BYTES = 64_000_000
"""OpenBLAS takes half of it, once, at the first product of large matrices."""
_PICTURE_BYTES = 150_000_000
"""More than any picture takes that is decoded."""
_OPENCV_NO_MEMORY = -4  # cv::Error::StsNoMem


def check_limits() -> None:
    """Raise MachineError if the libraries cannot be loaded at all; to be done before they are."""
    try:
        import resource  # noqa: PLC0415 - not on every system
    except ImportError:
        return
    for name, (option, least) in LEAST_BYTES.items():
        limit = resource.getrlimit(getattr(resource, name))[0]
        if limit != resource.RLIM_INFINITY and limit < least:
            raise MachineError(
                f"this process may have {limit // 1_000_000} MB of memory (ulimit -{option}) and "
                f"needs at least {least // 1_000_000}; raise the limit (ulimit -S{option} "
                f"{least // 1000}, or unlimited)"
            )


@contextmanager
def shortage_explained() -> Iterator[None]:
    """Turn any error for want of memory into a MachineError."""
    try:
        yield
    except (CountVideoError, OSError):
        raise
    except Exception as error:
        if not _for_want_of_memory(error):
            raise
        raise MachineError(
            "there is not enough memory; close other programs, count fewer clips at a time "
            "(--jobs), or use a part of the picture (--region)"
        ) from error


def _for_want_of_memory(error: Exception) -> bool:
    """Return whether an error says so, or there is none: each library has errors of its own."""
    try:
        check_memory()
    except MemoryError:
        return True
    return isinstance(error, MemoryError) or getattr(error, "code", None) == _OPENCV_NO_MEMORY


def check_memory(wanted_bytes: int = _PICTURE_BYTES) -> None:
    """Raise MemoryError unless so much is free: FFmpeg calls it damage where it found none.

    The other way round, it says of absurd sizes in damaged files that there was no memory for them.
    """
    bytes(wanted_bytes)  # taken by calloc: never touched, and free again at once


def give_memory_back() -> None:
    """Return to the system what was freed, as a decoder's pictures: glibc would hold on to it."""
    import ctypes  # noqa: PLC0415 - only where pictures were decoded

    with suppress(AttributeError, OSError, TypeError):  # another system, or another libc
        ctypes.CDLL(None).malloc_trim(0)


@cache
def take_buffer() -> None:
    """Have OpenBLAS take its buffer, or MemoryError: later it would end the process instead."""
    import numpy as np  # noqa: PLC0415 - takes memory that is asked for before

    check_memory(_BUFFER_BYTES)
    large = np.ones((64, 64))
    large @ large

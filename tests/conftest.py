"""What holds for every test: reproducible examples, Ctrl-C that works, and no file left open."""

from __future__ import annotations

import os
import signal
import stat
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings

# A shared machine makes single examples slow, so there is no deadline; the same examples are
# drawn on every run, so that a failure can be repeated anywhere.
settings.register_profile("reproducible", deadline=None, derandomize=True, print_blob=True)
settings.load_profile("reproducible")

# A shell that starts the tests in the background lets them, and all that they start, ignore Ctrl-C.
if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

_DESCRIPTORS = Path("/proc/self/fd")
_DATA_SUFFIXES = frozenset(
    (".mp4", ".m4v", ".mov", ".avi", ".mkv", ".webm", ".wav", ".json", ".toml", ".txt", ".png")
)


def _open_data_files() -> Counter[str]:
    """Count the descriptors open on each data file; empty where the system does not list them."""
    names: Counter[str] = Counter()
    for descriptor in _DESCRIPTORS.iterdir() if _DESCRIPTORS.is_dir() else ():
        try:
            name = os.readlink(descriptor)
            if stat.S_ISREG(descriptor.stat().st_mode) and Path(name).suffix in _DATA_SUFFIXES:
                names[name] += 1
        except OSError:  # closed meanwhile
            continue
    return names


@pytest.fixture(autouse=True)
def no_file_left_open() -> Iterator[None]:
    """Fail a test that leaves a file open, also where the library under it does not warn."""
    before = _open_data_files()
    yield
    left = _open_data_files() - before
    assert not left, f"left open: {', '.join(left)}"

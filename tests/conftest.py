"""What every test needs: reproducible examples, Ctrl-C that works, no file left open; a browser."""

from __future__ import annotations

import gc
import os
import shutil
import signal
import stat
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from hypothesis import settings

if TYPE_CHECKING:
    from playwright import sync_api

# A shared machine makes single examples slow, so there is no deadline; the same examples are
# drawn on every run, so that a failure can be repeated anywhere.
settings.register_profile("reproducible", deadline=None, derandomize=True, print_blob=True)
settings.load_profile("reproducible")

# The tests run side by side: threads within one would only wait for each other. This comes before
# NumPy is loaded, and holds for the processes that tests start.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

SLOW_TIMEOUT_S = 3600.0
RESTARTS = 1
"""A test whose process was ended is begun again in a new one, and fails all the same."""

# A shell that starts the tests in the background lets them, and all that they start, ignore Ctrl-C.
if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.hookimpl(tryfirst=True)  # before pytest-xdist reads its options
def pytest_cmdline_main(config: pytest.Config) -> None:
    """Let the tests of a file run in one process, where they share what is counted for them."""
    options = config.option
    if getattr(options, "numprocesses", None) and options.dist == "no":
        options.dist, options.loadscopereorder = "loadfile", False
    if hasattr(options, "maxworkerrestart") and options.maxworkerrestart is None:
        options.maxworkerrestart = str(RESTARTS)


def pytest_collection_finish() -> None:
    """Spare the collector what has been loaded by now: it stays until the end."""
    gc.collect()
    gc.freeze()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Give the tests that take minutes an hour."""
    for item in items:
        if item.get_closest_marker("slow"):
            item.add_marker(pytest.mark.timeout(SLOW_TIMEOUT_S))


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


@pytest.fixture(scope="module")
def browser() -> Iterator[sync_api.Browser]:
    """A browser without a window; tests that use one are skipped where there is none."""
    api = pytest.importorskip(
        "playwright.sync_api", reason="needs Playwright: pip install 'count-video[browser]'"
    )
    names = ("chromium", "chromium-browser", "google-chrome")
    chromium = next(filter(None, map(shutil.which, names)), None)
    if chromium is None:
        pytest.skip("needs Chromium: apt-get install chromium")
    root = hasattr(os, "geteuid") and os.geteuid() == 0
    # Chromium refuses its sandbox to root, as in a container.
    arguments = ["--disable-gpu", *(["--no-sandbox"] if root else [])]
    with api.sync_playwright() as playwright:
        launched = playwright.chromium.launch(executable_path=chromium, args=arguments)
        yield launched
        launched.close()

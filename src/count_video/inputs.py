"""What comes from outside: numbers as text, and text files; read here and nowhere else.

A number is written in ASCII digits, as ``960``, ``59.94``, ``1e3`` or ``1/3``, and lies in a range
that makes physical sense, so that no arithmetic on it overflows. A text file is a regular file of a
bounded size, in UTF-8. Whatever else comes is a ``UsageError`` in one line that shows at most 80
characters of it.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import stat
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from fractions import Fraction
from io import BufferedReader
from pathlib import Path
from typing import Any, NoReturn, TypeVar

from count_video.errors import UsageError

_Value = TypeVar("_Value")
SHOWN_CHARACTERS = 80
"""Characters of a text from outside that are shown, as they are written in quotes."""
LONGEST_PATH = 4096
MOST_MANIFEST_BYTES = 100_000_000
MOST_JSON_BYTES = 10_000_000
SMALLEST_REGION_PX = 16
"""No filter of the tracker fits into less."""

Signature = tuple[int, ...]
"""Size in bytes, time of the last change and more that a file system says of a file; it changes
whenever somebody writes to the file. Empty for a file that is not there."""

# Digits are bounded: Fraction("1e999999999") would fill the memory before it is refused.
_NUMBER = re.compile(
    r"([0-9]{1,400}(\.[0-9]{0,400})?|\.[0-9]{1,400})([eE][+-]?[0-9]{1,3})?"
    r"|[0-9]{1,400}/[1-9][0-9]{0,399}"
)


@dataclass(frozen=True)
class Range:
    """What values of a quantity make sense, both ends included; called, it reads one from text."""

    low: float
    high: float
    unit: str = ""

    def holds(self, value: float | Fraction) -> bool:
        """Return whether a number lies in the range; exact, for not all of them fit into floats."""
        if isinstance(value, float):
            return self.low <= value <= self.high
        return Fraction(str(self.low)) <= Fraction(value) <= Fraction(str(self.high))

    def __str__(self) -> str:
        ends = f"from {number_words(self.low)} to {number_words(self.high)}"
        return f"{ends} {self.unit}" if self.unit else ends

    def __call__(self, text: str) -> float:
        """Read a number."""
        return float(self.exact(text))

    def exact(self, text: str) -> Fraction:
        """Read a number at its exact value."""
        value = Fraction(text) if _NUMBER.fullmatch(text) else None
        if value is None or not self.holds(value):
            point = "; write a point before decimals" if "," in text else ""
            raise UsageError(f"{shown(text)} is not a number {self}{point}")
        return value


class WholeRange(Range):
    """A range of whole numbers, of up to 15 digits."""

    def __call__(self, text: str) -> int:
        """Read a whole number."""
        if not re.fullmatch(r"[0-9]{1,15}", text) or not self.holds(int(text)):
            raise UsageError(f"{shown(text)} is not a whole number {self}")
        return int(text)


CAPTURE_RATE = Range(1, 1e7, "frames per second")
BALL_DIAMETER = Range(0.01, 1e5, "mm")
MASS = Range(1e-100, 1e100)
MASS_RATIO = Range(1e-40, 1e40)
"""Heavy over light, far beyond any experiment: its squares and theirs are still sound numbers."""
FRAME = WholeRange(0, 1e15)
CLIPS_AT_A_TIME = WholeRange(1, 9999)
THREADS = WholeRange(1, 9999)
LENGTH = Range(1e-6, 1e3, "m")
"""Of a set-up: of its gaps and threads, and of a release."""
LENGTH_TOLERANCE = Range(0, 1e3, "m")
SHARE = Range(0, 1)
DAMPING = Range(0, 1e3, "per second")
TRIALS = WholeRange(2, 9999)
SEED = WholeRange(0, 1e15)
TOLERANCES = {
    "gap": ("gap_m", LENGTH_TOLERANCE),
    "release": ("release_m", LENGTH_TOLERANCE),
    "thread": ("thread_m", LENGTH_TOLERANCE),
    "mass": ("mass", SHARE),
    "restitution": ("restitution", SHARE),
    "scatter": ("scatter", SHARE),
}
"""Names of a plan's tolerances for a person, those of the fields that hold them, and ranges."""


def masses(heavy: Fraction, light: Fraction) -> tuple[Fraction, Fraction]:
    """Return two masses of one trial, the heavier first, in a ratio that an experiment may have."""
    if heavy < light:
        raise UsageError(
            f"the heavy mass is {float(heavy / light):.4g} of the light one; give the mass of the "
            "cylinder first and that of the ball after it"
        )
    if not MASS_RATIO.holds(heavy / light):
        raise UsageError(f"the ratio of the masses must be {MASS_RATIO}")
    return heavy, light


def region(text: str) -> tuple[int, int, int, int]:
    """Read a part of the picture in px: left edge, top edge, width, height."""
    if not re.fullmatch(r"-?[0-9]{1,6}(,-?[0-9]{1,6}){3}", text):
        raise UsageError(f"{shown(text)} is not of the form X,Y,W,H in whole pixels")
    x, y, width, height = map(int, text.split(","))
    if min(x, y) < 0:
        raise UsageError(
            f"{shown(text)} begins outside the picture: its left and top edge, counted from 0, "
            "cannot be negative"
        )
    if min(width, height) < SMALLEST_REGION_PX:
        raise UsageError(
            f"{shown(text)} is too small: give a width and a height of at least "
            f"{SMALLEST_REGION_PX} px"
        )
    return x, y, width, height


def tolerance(text: str) -> tuple[str, float]:
    """Read ``NAME=VALUE`` as the name of a field of a plan's tolerances and its value."""
    name, _, value = text.partition("=")
    if name not in TOLERANCES or not value:
        names = ", ".join(TOLERANCES)
        raise UsageError(f"{shown(text)} is not of the form NAME=VALUE with one of {names}")
    field, allowed = TOLERANCES[name]
    return field, allowed(value)


def some_path(text: str) -> Path:
    """Read the name of a file; an unset variable of a script is empty, which is none."""
    if not text or "\0" in text or len(text) > LONGEST_PATH:
        raise UsageError(f"{shown(text)} is no name of a file")
    if re.match(r"[a-zA-Z][a-zA-Z0-9+.-]+://", text):
        raise UsageError(f"{shown(text)} is an address; download the file first and give its name")
    return Path(text)


def address(text: str) -> str:
    """Read the address of a scheduler, as ``host:8786`` or ``tcp://host:8786``."""
    found = re.fullmatch(r"((tcp|tls)://)?([\w.-]{1,253}|\[[0-9a-fA-F:.]+\]):([0-9]{1,5})", text)
    if found is None or not text.isascii() or not 0 < int(found[4]) < 65536:
        raise UsageError(f"{shown(text)} is not of the form tcp://HOST:PORT")
    return text


def checked(name: str, value: Any, read: Callable[[str], _Value]) -> _Value:
    """Read a value, which may be no text, by what reads it from text; an error has its name."""
    text = str(value)
    if not isinstance(value, str):
        with suppress(TypeError):  # of one value
            text = (" " if name == "masses" else ",").join(map(str, value))
    try:
        return read(text)
    except UsageError as error:
        raise UsageError(f"{name}: {error}") from error


def number_words(value: float) -> str:
    """Write a number as people do, in digits: ``0.000001``, ``1000``, ``10 000 000``."""
    if value and not 1e-9 <= abs(value) < 1e16:  # nobody counts so many zeros
        return f"{value:g}"
    whole, _, decimals = f"{value:.9f}".partition(".")
    grouped = f"{int(whole):,}".replace(",", " ") if len(whole) > 4 else whole
    return f"{grouped}.{decimals}".rstrip("0").rstrip(".")


def shown(text: str) -> str:
    """Quote a text from outside in one short line that a terminal shows and does not obey."""
    quoted = repr(text)
    if len(quoted) <= SHOWN_CHARACTERS + 2:
        return quoted
    return f"{quoted[:SHOWN_CHARACTERS]}…{quoted[-1]}"


@contextmanager
def regular_file(path: Path) -> Iterator[BufferedReader]:
    """Open a regular file; what is none, a pipe for example, may never open nor end.

    Raises UsageError for such a one, and OSError if it cannot be read.
    """
    with open(os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0)), "rb") as file:
        if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
            raise UsageError(f"{path}: this is no regular file; save it to one first")
        yield file


def read_text(
    path: Path, most_bytes: int, advice: str = "save it as such, a table as CSV UTF-8"
) -> str:
    """Read a text file in UTF-8, with or without a mark in front; UsageError if it is none."""
    try:
        with regular_file(path) as file:
            content = file.read(most_bytes + 1)
        if len(content) > most_bytes:
            raise UsageError(
                f"{path}: more than {most_bytes // 1_000_000} MB; give the file that is meant"
            )
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise UsageError(f"{path}: this is no text in UTF-8; {advice}") from error
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise UsageError(
            f"{path}: cannot be read: {reason}; check the name and its rights"
        ) from error


def read_json_object(path: Path) -> dict[str, object]:
    """Read a file that holds one JSON object; numbers without a value (NaN) are refused."""
    text = read_text(path, MOST_JSON_BYTES, "give the JSON file as it was saved")
    try:
        stored = json_value(text, parse_constant=_no_number)
    except ValueError as error:
        raise UsageError(f"{path}: this is no JSON; give the file as it was saved") from error
    if not isinstance(stored, dict):
        raise UsageError(f"{path}: this is no JSON object; give the file as it was saved")
    return stored


def json_value(text: str | bytes, **more: Any) -> Any:
    """Parse JSON from outside as ``json.loads`` does; ValueError also if it is nested too deep."""
    try:
        return json.loads(text, **more)
    except RecursionError as error:
        raise ValueError("nested too deeply") from error


def _no_number(name: str) -> NoReturn:
    raise ValueError(f"{name} is no number")


def content_digest(file: Path) -> str:
    """Digest all bytes of a file; raises as :func:`regular_file` does."""
    with regular_file(file) as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def signature(file: Path) -> Signature:
    """Size, times of the last change and number of a file; empty if there is none."""
    try:
        found = file.stat()
    except (OSError, ValueError):
        return ()
    return found.st_size, found.st_mtime_ns, found.st_ctime_ns, found.st_ino


def stored_number(value: object, allowed: Range) -> float | None:
    """Return a number from JSON; None for anything else, or outside of what is allowed."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    return float(value) if allowed.holds(value) else None

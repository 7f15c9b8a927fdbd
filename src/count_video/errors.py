"""The errors that a user can meet, as one tree.

CountVideoError
├── UsageError       the request itself is off: an option's value, an impossible combination
│   └── OutputError  what was asked for cannot be written
├── FootageError     the file cannot be read as footage
├── TrackingError    the footage does not show what can be counted
└── MachineError     this machine cannot do the work now, for want of memory

Every message says what failed, where, and what to do about it, on one line.
"""

from __future__ import annotations

from argparse import ArgumentTypeError


class CountVideoError(Exception):
    """Anything this package refuses to do, with a one-line message for the user."""


class UsageError(CountVideoError, ArgumentTypeError):
    """The request itself is off; argparse puts the option before it, if it is that of a value."""


class OutputError(UsageError):
    """What was asked for cannot be written."""


class FootageError(CountVideoError):
    """The file cannot be read as footage."""


class TrackingError(CountVideoError):
    """The footage does not show what can be counted."""


class MachineError(CountVideoError):
    """The machine cannot do the work now; another one, or a later run, may."""


def reason_of(error: CountVideoError | OSError, clip: object) -> str:
    """Return why a clip could not be worked on, without its path, which stands before the reason.

    An OSError's own text repeats number and path; its plain words are enough.
    """
    words = error.strerror if isinstance(error, OSError) else None
    return words or str(error).removeprefix(f"{clip}: ") or type(error).__name__

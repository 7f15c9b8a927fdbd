"""Values of options: read from text, or refused in one line that names the text.

Each function takes what the user typed and raises ``argparse.ArgumentTypeError`` for what is wrong.
"""

from __future__ import annotations

import argparse
import math
import re
from fractions import Fraction


def positive(text: str) -> float:
    """Read a finite number above 0."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not (value > 0 and math.isfinite(value)):
        raise argparse.ArgumentTypeError(f"{text!r} is not a number above 0")
    return value


def number_above_0(text: str) -> int:
    """Read a whole number from 1 to 9999."""
    if not re.fullmatch(r"0*[1-9][0-9]{0,3}", text):
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number from 1 to 9999")
    return int(text)


def frame(text: str) -> int:
    """Read the number of a frame, counted from 0."""
    if not re.fullmatch(r"[0-9]{1,15}", text):
        raise argparse.ArgumentTypeError(f"{text!r} is not a frame number (0, 1, 2 ...)")
    return int(text)


def region(text: str) -> tuple[int, int, int, int]:
    """Read a part of the picture in px: left edge, top edge, width, height."""
    if not re.fullmatch(r"[0-9]{1,6}(,[0-9]{1,6}){3}", text):
        raise argparse.ArgumentTypeError(f"{text!r} is not of the form X,Y,W,H in whole pixels")
    x, y, width, height = map(int, text.split(","))
    if width == 0 or height == 0:
        raise argparse.ArgumentTypeError(f"{text!r} has no area: give a width and a height above 0")
    return x, y, width, height


def mass(text: str) -> Fraction:
    """Read a mass at its exact decimal value."""
    # Bounded digits: Fraction("1e999999999") would fill the memory before it is refused.
    if re.fullmatch(r"[0-9]{1,60}(\.[0-9]{0,60})?(e[+-]?[0-9]{1,2})?", text, re.IGNORECASE):
        mass = Fraction(text)
        if mass > 0:
            return mass
    raise argparse.ArgumentTypeError(f"{text!r} is not a decimal number above 0, such as 10.5")


def not_negative(text: str) -> float:
    """Read a finite number from 0 on."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not (value >= 0 and math.isfinite(value)):
        raise argparse.ArgumentTypeError(f"{text!r} is not a number from 0 on")
    return value


def share(text: str) -> float:
    """Read a number from 0 to 1."""
    value = not_negative(text)
    if value > 1:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number from 0 to 1")
    return value


def whole_number(text: str) -> int:
    """Read a whole number from 0 on."""
    if not re.fullmatch(r"[0-9]{1,18}", text):
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number (0, 1, 2 ...)")
    return int(text)


TOLERANCES = {
    "gap": "gap_m",
    "release": "release_m",
    "thread": "thread_m",
    "mass": "mass",
    "restitution": "restitution",
    "scatter": "scatter",
}
"""Names of the tolerances for a person, and those of the fields that hold them."""


def tolerance(text: str) -> tuple[str, float]:
    """Read ``NAME=VALUE`` as the name of a field and its value."""
    name, sign, value = text.partition("=")
    if not sign or name not in TOLERANCES:
        raise argparse.ArgumentTypeError(
            f"{text!r} is not of the form NAME=VALUE with one of {', '.join(TOLERANCES)}"
        )
    return TOLERANCES[name], not_negative(value)

"""What all reports write with: text made safe, numbers with nouns, labels beside sentences."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # NumPy takes time, and the command needs this module at once
    from count_video.records import Estimate

WIDTH = 80
"""Columns that a terminal has at the least."""
_LABEL_WIDTH = 13
_NEARLY_CERTAIN = 0.99
RARE = 0.005
"""Less probable counts, and counts that fewer trials have, are not listed."""

Note = tuple[str, str]
"""A label and the sentence that stands beside it."""


def printable(text: str) -> str:
    """Escape what a terminal would obey instead of show: line ends, control codes, lost bytes."""
    return "".join(
        sign if sign.isprintable() else sign.encode("unicode_escape").decode("ascii")
        for sign in text
    )


def storable(text: str) -> str:
    """Replace what UTF-8 cannot hold: the unpaired surrogates of a file name that is not UTF-8."""
    return text.encode("utf-8", "backslashreplace").decode("utf-8")


def plural(number: int, noun: str) -> str:
    """Join a number and its noun: ``no collision``, ``1 collision``, ``31 collisions``."""
    if number == 0:
        return f"no {noun}"
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def counts_words(low: int, high: int) -> str:
    """Write a range of counts: ``31``, ``3 or 4``, ``29 to 31``."""
    return str(low) if low == high else f"{low}{' or ' if high == low + 1 else ' to '}{high}"


def ratio_words(ratio: Estimate | None, between: str = "±") -> str:
    """Write a mass ratio, the sign ``between``, and its uncertainty, 0 where the ratio was given.

    There are two digits of the uncertainty, and none of the ratio beyond them.
    """
    if ratio is None:
        return "not known"
    value, sigma = ratio.value, ratio.sigma
    if not sigma or not math.isfinite(sigma):
        return f"{value:.4g}" if value < 1e4 else f"{value:.0f}"  # never with an exponent
    digits = max(0, 1 - math.floor(math.log10(sigma)))
    return f"{value:.{digits}f} {between} {sigma:.{digits}f}"


def percent(chance: float) -> str:
    """Write a chance, with a decimal where it is nearly certain, and never as certain."""
    return f"{chance:.0%}" if chance < _NEARLY_CERTAIN else f"{min(chance, 0.999):.1%}"


def chances_words(probability: Mapping[int, float], most: int | None = None) -> str:
    """List the likely counts with their chances, the likeliest first, and ``most`` at the most."""
    ordered = sorted(probability.items(), key=lambda item: -item[1])[:most]
    return ", ".join(f"{count}: {percent(p)}" for count, p in ordered if p >= RARE)


def fixed(value: float, decimals: int) -> str:
    """Write a number with so many decimals, and 0 without a sign."""
    return f"{value:z.{decimals}f}"


def labelled(label: str, sentence: str, width: int = WIDTH) -> list[str]:
    """Write a label and, beside it, a sentence in lines of at most ``width`` columns."""
    return textwrap.wrap(
        printable(sentence),
        width,
        initial_indent=f"  {label:<{_LABEL_WIDTH}}",
        subsequent_indent=" " * (2 + _LABEL_WIDTH),
        break_on_hyphens=False,  # an option's name stays whole
    )


def answer_text(
    headline: str, notes: Iterable[Note], *tables: list[str], width: int = WIDTH
) -> str:
    """Write an answer: the headline, what it rests on, and tables, without a line's end at its end.

    An empty table is left out.
    """
    lines = [headline, ""]
    for label, sentence in notes:
        lines += labelled(label, sentence, width)
    for table in tables:
        lines += ["", *table] if table else []
    return "\n".join(lines)

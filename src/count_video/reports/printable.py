"""Text from elsewhere, made safe for a terminal."""

from __future__ import annotations


def printable(text: str) -> str:
    """Escape what a terminal would obey instead of show: line ends, control codes, lost bytes."""
    return "".join(
        sign if sign.isprintable() else sign.encode("unicode_escape").decode("ascii")
        for sign in text
    )


def storable(text: str) -> str:
    """Replace what UTF-8 cannot hold: the lone surrogates of a file name that is not UTF-8."""
    return text.encode("utf-8", "backslashreplace").decode("utf-8")

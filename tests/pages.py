"""The project's own pages: README.md, docs/ and what lies beside them, as the tests read them."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

TOP = Path(__file__).parents[1]
PAGES = (
    *sorted(TOP.glob("*.md")),
    *sorted((TOP / "docs").glob("*.md")),
    *(TOP / folder / "README.md" for folder in ("examples", "fixtures")),
)
"""Every page that a person is meant to read."""


@cache
def page(name: str) -> str:
    """Return the text of a page by its path from the top, such as ``docs/result.md``."""
    return (TOP / name).read_text("utf-8")


def section(name: str, heading: str) -> str:
    """Return what stands below a heading of a page, with or without smaller headings in it."""
    # A comment in a block of code begins like a heading: blocks are left out of the search.
    text = page(name)
    hidden = re.sub(r"^```.*?^```", lambda block: "~" * len(block[0]), text, flags=re.M | re.S)
    found = re.search(rf"^(#+) {re.escape(heading)}\n", hidden, re.M)
    assert found is not None, f"{name} has a section {heading}"
    end = re.compile(rf"^#{{1,{len(found[1])}}} ", re.M).search(hidden, found.end())
    return text[found.end() : end.start() if end else None]


def blocks(text: str, *languages: str) -> list[str]:
    """Return the blocks of code in some languages; those in lists have their indent."""
    found = re.findall(r"^ *```(\w*)\n(.*?)^ *```$", text, re.M | re.S)
    return [code for language, code in found if language in languages]

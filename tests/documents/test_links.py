"""Links, pictures and names of files in the pages lead somewhere."""

from __future__ import annotations

import re
import unicodedata
from pathlib import Path

import pytest

from pages import PAGES, TOP

LINK = re.compile(r"!?\[[^\]]*\]\((?!https?:)([^)\s]+)\)")
FILE_NAME = re.compile(r"`((?:src|synth|tests|docs|examples|fixtures)/[\w./-]*)`")
MOST_README_WORDS = 1500
"""So much a newcomer reads; everything longer has its own page."""


def without_code(text: str) -> str:
    return re.sub(r"^ *```.*?^ *```$", "", text, flags=re.M | re.S)


def anchors(path: Path) -> set[str]:
    """Return the names of a page's headings, as Markdown sites make them."""
    headings = re.findall(r"^#+ (.*)$", without_code(path.read_text("utf-8")), re.M)
    return {slug(heading) for heading in headings}


def slug(heading: str) -> str:
    plain = unicodedata.normalize("NFKD", heading).encode("ascii", "ignore").decode("ascii")
    return re.sub(r"[-\s]+", "-", re.sub(r"[^\w\s-]", "", plain).strip().lower())


@pytest.mark.parametrize("path", PAGES, ids=lambda path: str(path.relative_to(TOP)))
def test_every_link_of_a_page_leads_to_a_file_and_a_heading(path: Path) -> None:
    broken = []
    for link in LINK.findall(without_code(path.read_text("utf-8"))):
        target, _, anchor = link.partition("#")
        file = (path.parent / target).resolve() if target else path
        if not file.exists() or (anchor and anchor not in anchors(file)):
            broken.append(link)
    assert broken == []


@pytest.mark.parametrize("path", PAGES, ids=lambda path: str(path.relative_to(TOP)))
def test_every_file_that_a_page_names_is_there(path: Path) -> None:
    named = FILE_NAME.findall(path.read_text("utf-8"))
    assert [name for name in named if not (TOP / name).exists()] == []


def test_links_and_files_are_found_at_all() -> None:
    texts = [path.read_text("utf-8") for path in PAGES]
    assert sum(len(LINK.findall(text)) for text in texts) > 30
    assert sum(len(FILE_NAME.findall(text)) for text in texts) > 10


def test_a_page_of_the_site_links_to_no_file_outside_it() -> None:
    # The site has the pages of docs/ alone; what lies elsewhere is named, not linked.
    for path in (TOP / "docs").glob("*.md"):
        targets = [link.partition("#")[0] for link in LINK.findall(path.read_text("utf-8"))]
        outside = [target for target in targets if target.startswith("../")]
        assert outside == [], path.name


def test_the_readme_is_short() -> None:
    assert len((TOP / "README.md").read_text("utf-8").split()) <= MOST_README_WORDS

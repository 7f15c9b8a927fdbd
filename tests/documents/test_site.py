"""The site is built without a warning, and its pages are all in its menu."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from pages import TOP


def test_every_page_is_in_the_menu() -> None:
    menu = (TOP / "mkdocs.yml").read_text("utf-8").partition("nav:")[2].partition("plugins:")[0]
    named = set(re.findall(r"[\w-]+\.md", menu))
    assert named == {path.name for path in (TOP / "docs").glob("*.md")}


def test_the_site_is_built_without_a_warning(tmp_path: Path) -> None:
    pytest.importorskip("mkdocs", reason="comes with the extra 'docs'")
    pytest.importorskip("mkdocstrings", reason="comes with the extra 'docs'")
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet"]
    done = subprocess.run(
        [*command, "--site-dir", str(tmp_path)],
        cwd=TOP,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    page = (tmp_path / "api.html").read_text("utf-8")
    for name in ("count", "count_all", "theory", "plan"):
        assert f'id="count_video.{name}"' in page
    # What the pages load comes with them, so that they can be read without a network.
    loaded = re.findall(r'(?:src|<link[^>]*href)="(https?:[^"]*)"', page)
    assert loaded == []

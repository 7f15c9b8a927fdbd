"""Odd names stay text, other ways to film work, and a campaign links to its pages."""

from __future__ import annotations

import re
import shutil
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote

import numpy as np
import pytest
from evidence_made import FIXTURES, Made, count_with_evidence

from count_video import cli
from count_video.batch.summary import summarise
from count_video.evidence import EvidenceSettings
from count_video.pipeline import TrialSettings
from count_video.reports.page import PageMedia, campaign_page, clip_page
from count_video.video.reader import open_footage
from count_video.video.writer import write_clip
from table_rows import row

SMALL = FIXTURES / "ratio1-count3.mp4"
NAMES = (
    "<img src=x onerror=alert(1)>.mp4",
    "<!--<script>.mp4",
    "\"'{{ 7*7 }}'\".mp4",
    "a&amp;b \u2028\udcff.mp4",
)


class Tags(HTMLParser):
    """Counts the tags of a page."""

    def __init__(self) -> None:
        super().__init__()
        self.names: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.names.append(tag)


def tags(page: str) -> list[str]:
    parser = Tags()
    parser.feed(page)
    return parser.names


@pytest.mark.parametrize("name", NAMES)
def test_a_clips_name_is_text_and_never_markup(made: Made, name: str) -> None:
    media = PageMedia(b"clip", np.arange(3.0), np.arange(3.0), {})

    def page(clip: str) -> str:
        return clip_page(replace(made.result, clip=clip, reason=clip), media)

    assert tags(page(name)) == tags(page("plain.mp4"))
    assert name not in page(name)
    script = re.search(r'<script type="application/json"[^>]*>(.*?)</script>', page(name), re.S)
    assert script is not None
    assert "<" not in script[1]
    page(name).encode("utf-8")


@pytest.mark.parametrize("name", NAMES)
def test_in_a_campaign_too_a_clips_name_is_text(name: str) -> None:
    def page(clip: str) -> str:
        one = row(clip, None, clip=clip, reason=clip)
        return campaign_page([one], summarise([one]), (b"", "image/png"))

    assert tags(page(name)) == tags(page("plain.mp4"))


@pytest.mark.slow
def test_a_part_of_a_clip_that_moves_up_and_down_has_evidence_of_that_part(tmp_path: Path) -> None:
    turned = tmp_path / "turned.mp4"
    with open_footage(SMALL) as footage:
        write_clip(turned, (np.ascontiguousarray(frame.luma.T) for frame in footage.frames()))
    settings = TrialSettings(start=5, end=90)
    result = count_with_evidence(turned, settings, EvidenceSettings(tmp_path / "out", "svg"))
    assert result.count == 3
    with open_footage(tmp_path / "out" / "turned.annotated.mp4") as footage:
        assert sum(1 for _ in footage.frames()) == 85
    kept = {file.name.removeprefix("turned.") for file in (tmp_path / "out").glob("[!.]*")}
    assert kept >= {"annotated.mp4", "collisions.csv", "html", "strip.jpg", "svg", "track.csv"}
    assert "data:image/svg+xml;base64," in (tmp_path / "out" / "turned.html").read_text("utf-8")


def test_a_campaign_with_pages_links_each_trial_to_its_page(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    clips, results = tmp_path / "clips", tmp_path / "results"
    clips.mkdir()
    shutil.copy(SMALL, clips / "one & only.mp4")
    (clips / "broken.mp4").write_bytes(b"no clip")
    assert cli.main([str(clips), "-o", str(results), "--pages", "--jobs", "1"]) == 1
    page = (results / "campaign.html").read_text("utf-8")
    links = re.findall(r'(?:href|src)="((?!data:)[^"]+)"', page)
    assert set(links) >= {"trials.csv", "one%20%26%20only.html", "one%20%26%20only.strip.jpg"}
    assert [link for link in links if not (results / unquote(link)).is_file()] == []
    assert (results / "one & only.html").is_file()
    first, last = (page.index(f'data-value="{name}"') for name in ("broken", "one &amp; only"))
    assert first < last, "the doubtful come first"
    assert "2 trials" in page
    assert capsys.readouterr().out != ""

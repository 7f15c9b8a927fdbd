"""Pages with hostile names, notes and corrections in a real browser: no script of theirs runs."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from evidence_made import Made

from count_video.batch.summary import summarise
from count_video.planning.plan import make_plan
from count_video.planning.request import PlanRequest
from count_video.records import Correction
from count_video.reports.page import Footage, campaign_page, clip_page, plan_page
from table_rows import row

if TYPE_CHECKING:
    from playwright import sync_api

RUN = "document.documentElement.dataset.hostile = 'ran'"
HOSTILE = (
    f'<img src=x onerror="{RUN}">',
    f"<script>{RUN}</script>",
    f"</script><script>{RUN}</script>",
    f'"><svg onload="{RUN}">',
    f"' onmouseover='{RUN}",
    f"<!--<script>{RUN}</script>",
    f"]]><script>{RUN}</script>",
    f"javascript:{RUN}",
    "<base href='https://example.invalid/'><meta http-equiv=refresh content='0;url=data:,'>",
    f"${{{RUN}}}{{{{{RUN}}}}}",
    "\u2028\u2029\u202e\udcff",
)
INJECTED = (
    f"<script>{RUN}</script>",
    f'<img src="data:,x" onerror="{RUN}">',
    f'<svg onload="{RUN}"></svg>',
    f'<iframe srcdoc="<script>parent.{RUN}</script>"></iframe>',
    '<script src="other.js"></script>',
)


def opened(browser: sync_api.Browser, page: Path) -> tuple[sync_api.Page, list[str]]:
    """Open a page; return it and what it asked for beyond itself."""
    visit = browser.new_page()
    asked: list[str] = []
    visit.on("request", lambda request: asked.append(request.url))
    visit.on("dialog", lambda dialog: dialog.dismiss())
    visit.goto(page.as_uri())
    visit.wait_for_timeout(300)
    own = (page.as_uri(), "data:", "blob:")
    return visit, [address for address in asked if not address.startswith(own)]


def ran(visit: sync_api.Page) -> bool:
    return bool(visit.evaluate("document.documentElement.dataset.hostile === 'ran'"))


def page_of(made: Made, text: str) -> str:
    """Make the page of a clip whose every text is hostile."""
    corrections = (Correction("missed", text, 3.0, None, True),)  # type: ignore[arg-type]
    result = replace(
        made.result, clip=f"folder/{text}", reason=text, warnings=(text,), corrections=corrections
    )
    video = made.file("annotated.mp4").read_bytes()
    return clip_page(result, Footage(video, np.arange(9.0), np.arange(9.0), {}, text), None)


@pytest.mark.parametrize("text", HOSTILE, ids=range(len(HOSTILE)))
def test_hostile_text_on_a_clips_page_is_shown_and_does_nothing(
    browser: sync_api.Browser, made: Made, tmp_path: Path, text: str
) -> None:
    page = tmp_path / "page.html"
    page.write_text(page_of(made, text), "utf-8")
    visit, asked = opened(browser, page)
    assert not ran(visit)
    assert asked == []
    assert visit.locator("#list button").count() == len(made.result.collisions) + 1, "ours does run"
    assert visit.evaluate("document.querySelectorAll('iframe, base, object, svg').length") == 0
    visit.close()


@pytest.mark.parametrize("text", HOSTILE, ids=range(len(HOSTILE)))
def test_hostile_text_on_a_campaigns_page_is_shown_and_does_nothing(
    browser: sync_api.Browser, tmp_path: Path, text: str
) -> None:
    files = frozenset({"trial.html", "trial.strip.jpg"})
    one = row("trial", None, clip=text, reason=text, not_kept=text, files=files)
    page = tmp_path / "campaign.html"
    page.write_text(campaign_page([one], summarise([one]), (b"", "image/png")), "utf-8")
    visit, asked = opened(browser, page)
    assert not ran(visit)
    assert asked == [(tmp_path / "trial.strip.jpg").as_uri()], "our own picture alone"
    assert visit.locator("#trials tbody tr").count() == 1
    visit.close()


def test_the_trials_of_a_campaign_can_be_sorted_by_every_column(
    browser: sync_api.Browser, tmp_path: Path
) -> None:
    rows = [row("b10", 31, 0.95), row("b9", 29, 0.99), row("a", None)]
    page = tmp_path / "campaign.html"
    page.write_text(campaign_page(rows, summarise(rows), (b"", "image/png")), "utf-8")
    visit, _ = opened(browser, page)

    def names() -> list[str]:
        return [text.strip() for text in visit.locator("#trials tbody th").all_inner_texts()]

    assert names() == ["a.mp4", "b10.mp4", "b9.mp4"], "who needs a person comes first"
    orders = {
        "Trial": ["a.mp4", "b9.mp4", "b10.mp4"],
        "Count": ["a.mp4", "b9.mp4", "b10.mp4"],
        "Probability": ["a.mp4", "b10.mp4", "b9.mp4"],
    }
    for heading, order in orders.items():
        for direction in ("ascending", "descending"):
            visit.get_by_role("button", name=heading, exact=True).press("Enter")
            assert names() == (order if direction == "ascending" else order[::-1])
            assert visit.locator(f"th[aria-sort={direction}]").inner_text() == heading
    visit.close()


@pytest.mark.parametrize("markup", INJECTED, ids=range(len(INJECTED)))
def test_the_policy_stops_what_an_escape_would_have_let_through(
    browser: sync_api.Browser, made: Made, tmp_path: Path, markup: str
) -> None:
    text = made.file("html").read_text("utf-8")
    (tmp_path / "other.js").write_text(RUN, "utf-8")
    page = tmp_path / "page.html"
    page.write_text(text.replace("<main>", f"<main>{markup}"), "utf-8")
    visit, _ = opened(browser, page)
    assert not ran(visit)
    assert visit.locator("#list button").count() == len(made.result.collisions)
    visit.close()


def test_every_page_allows_only_itself(made: Made) -> None:
    pages = {
        "clip": made.file("html").read_text("utf-8"),
        "campaign": campaign_page([], summarise([]), (b"", "image/png")),
        "plan": plan_page(make_plan(PlanRequest(16, 1), with_table=False)),
    }
    for name, page in pages.items():
        policy = re.search(r'http-equiv="Content-Security-Policy" content="([^"]*)"', page)
        assert policy, name
        allowed = dict(rule.strip().split(" ", 1) for rule in policy[1].split(";"))
        # The first does not cover the next two.
        for rule in ("default-src", "base-uri", "form-action"):
            assert allowed[rule] == "'none'", f"{name}: {rule}"
        sources = " ".join(allowed.values())
        assert not re.search(r"unsafe|//|\*", sources), name


def test_without_the_policy_the_same_markup_would_run(
    browser: sync_api.Browser, made: Made, tmp_path: Path
) -> None:
    text = made.file("html").read_text("utf-8")
    page = tmp_path / "page.html"
    page.write_text(
        text.replace("Content-Security-Policy", "x").replace("<main>", f"<main>{INJECTED[0]}"),
        "utf-8",
    )
    visit, _ = opened(browser, page)
    assert ran(visit), "else the tests above show nothing"
    visit.close()


def test_the_saved_corrections_name_the_clip_by_its_digest(
    browser: sync_api.Browser, made: Made
) -> None:
    visit, _ = opened(browser, made.file("html"))
    fields = json.loads(visit.locator("#data").text_content() or "")
    assert len(fields["clip_sha256"]) == 64
    visit.close()

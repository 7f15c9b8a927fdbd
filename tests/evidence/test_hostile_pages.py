"""Pages with hostile names, notes and corrections in a real browser: no script of theirs runs."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from evidence_made import Made

from count_video.batch.summary import summarise
from count_video.planning.plan import make_plan
from count_video.planning.request import PlanRequest
from count_video.records import Correction
from count_video.reports.page import PageMedia, campaign_page, clip_page, plan_page
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


@dataclass(frozen=True)
class Visit:
    """A page that is open."""

    name: str
    page: sync_api.Page
    asked: list[str]
    """What it asked for beyond itself."""


@contextmanager
def opened(browser: sync_api.Browser, pages: Iterable[Path]) -> Iterator[list[Visit]]:
    """Open pages side by side and give their scripts time to run."""
    with browser.new_context() as context:
        visits = []
        for path in pages:
            visit = Visit(path.stem, context.new_page(), [])
            visit.page.on("request", partial(_note, visit.asked, path.as_uri()))
            visit.page.on("dialog", lambda dialog: dialog.dismiss())
            visit.page.goto(path.as_uri())
            visits.append(visit)
        visits[-1].page.wait_for_timeout(300)
        yield visits


def _note(asked: list[str], own: str, request: sync_api.Request) -> None:
    if not request.url.startswith((own, "data:", "blob:")):
        asked.append(request.url)


def written(folder: Path, pages: Iterable[str]) -> list[Path]:
    """Write pages into a folder, called by their numbers."""
    paths = []
    for number, page in enumerate(pages):
        paths.append(folder / f"{number}.html")
        paths[-1].write_text(page, "utf-8")
    return paths


def ran(visit: Visit) -> bool:
    return bool(visit.page.evaluate("document.documentElement.dataset.hostile === 'ran'"))


def page_of(made: Made, text: str) -> str:
    """Make the page of a clip whose every text is hostile."""
    corrections = (Correction("missed", text, 3.0, None, True),)  # type: ignore[arg-type]
    result = replace(
        made.result, clip=f"folder/{text}", reason=text, warnings=(text,), corrections=corrections
    )
    return clip_page(result, PageMedia(b"", np.arange(9.0), np.arange(9.0), {}, text))


def test_hostile_text_on_a_clips_page_is_shown_and_does_nothing(
    browser: sync_api.Browser, made: Made, tmp_path: Path
) -> None:
    pages = written(tmp_path, (page_of(made, text) for text in HOSTILE))
    with opened(browser, pages) as visits:
        for visit in visits:
            assert not ran(visit), visit.name
            assert visit.asked == [], visit.name
            buttons = visit.page.locator("#list button").count()
            assert buttons == len(made.result.collisions) + 1, "ours does run"
            foreign = "document.querySelectorAll('iframe, base, object, svg').length"
            assert visit.page.evaluate(foreign) == 0, visit.name


def test_hostile_text_on_a_campaigns_page_is_shown_and_does_nothing(
    browser: sync_api.Browser, tmp_path: Path
) -> None:
    def page(text: str) -> str:
        files = frozenset({"trial.html", "trial.strip.jpg"})
        one = row("trial", None, clip=text, reason=text, not_kept=text, files=files)
        return campaign_page([one], summarise([one]), (b"", "image/png"))

    with opened(browser, written(tmp_path, map(page, HOSTILE))) as visits:
        for visit in visits:
            assert not ran(visit), visit.name
            own_picture = (tmp_path / "trial.strip.jpg").as_uri()
            assert visit.asked == [own_picture], visit.name
            assert visit.page.locator("#trials tbody tr").count() == 1, visit.name


def test_the_trials_of_a_campaign_can_be_sorted_by_every_column(
    browser: sync_api.Browser, tmp_path: Path
) -> None:
    rows = [row("b10", 31, 0.95), row("b9", 29, 0.99), row("a", None)]
    pages = written(tmp_path, [campaign_page(rows, summarise(rows), (b"", "image/png"))])
    with opened(browser, pages) as (visit,):
        assert_sorted(visit.page)


def assert_sorted(page: sync_api.Page) -> None:
    def names() -> list[str]:
        return [text.strip() for text in page.locator("#trials tbody th").all_inner_texts()]

    assert names() == ["a", "b10", "b9"], "who needs a person comes first"
    orders = {
        "Trial": ["a", "b9", "b10"],
        "Count": ["a", "b9", "b10"],
        "Probability": ["a", "b10", "b9"],
    }
    for heading, order in orders.items():
        for direction in ("ascending", "descending"):
            page.get_by_role("button", name=heading, exact=True).press("Enter")
            assert names() == (order if direction == "ascending" else order[::-1])
            assert page.locator(f"th[aria-sort={direction}]").inner_text() == heading


def test_the_policy_stops_what_an_escape_would_have_let_through(
    browser: sync_api.Browser, made: Made, tmp_path: Path
) -> None:
    text = made.file("html").read_text("utf-8")
    (tmp_path / "other.js").write_text(RUN, "utf-8")
    pages = (text.replace("<main>", f"<main>{markup}") for markup in INJECTED)
    with opened(browser, written(tmp_path, pages)) as visits:
        for visit in visits:
            assert not ran(visit), visit.name
            assert visit.page.locator("#list button").count() == len(made.result.collisions)


def test_every_page_allows_only_itself(made: Made) -> None:
    pages = {
        "clip": made.file("html").read_text("utf-8"),
        "campaign": campaign_page([], summarise([]), (b"", "image/png")),
        "plan": plan_page(make_plan(PlanRequest(16, 1), with_table=False), "data:,"),
    }
    for name, page in pages.items():
        policy = re.search(r'http-equiv="Content-Security-Policy" content="([^"]*)"', page)
        assert policy, name
        allowed = dict(rule.strip().split(" ", 1) for rule in policy[1].split(";"))
        # The first does not cover the next two.
        for rule in ("default-src", "base-uri", "form-action"):
            assert allowed[rule] == "'none'", f"{name}: {rule}"
        # What a digest happens to spell is no address.
        sources = re.sub(r"'sha256-[\w+/=]+'", "", " ".join(allowed.values()))
        assert not re.search(r"unsafe|//|\*", sources), name


def test_without_the_policy_the_same_markup_would_run(
    browser: sync_api.Browser, made: Made, tmp_path: Path
) -> None:
    text = made.file("html").read_text("utf-8").replace("Content-Security-Policy", "x")
    pages = written(tmp_path, [text.replace("<main>", f"<main>{INJECTED[0]}")])
    with opened(browser, pages) as (visit,):
        assert ran(visit), "else the tests above show nothing"


def test_the_saved_corrections_name_the_clip_by_its_digest(
    browser: sync_api.Browser, made: Made
) -> None:
    with opened(browser, [made.file("html")]) as (visit,):
        fields = json.loads(visit.page.locator("#data").text_content() or "")
    assert len(fields["clip_sha256"]) == 64

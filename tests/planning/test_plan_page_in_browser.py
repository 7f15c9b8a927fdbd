"""The plan's page, used in a real browser as a person would."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from count_video.physics.setup import Setup
from count_video.physics.simulator import simulate
from count_video.planning.plan import make_plan
from count_video.planning.request import PlanRequest
from count_video.reports.page import plan_page
from visits import DESK, LINES_OF_OPTIONS, PHONE, Visit, open_page

if TYPE_CHECKING:
    from playwright import sync_api

FINGER_PX = 38


def slide(visit: Visit, name: str, value: float) -> None:
    """Put a slider to a value, as a drag does."""
    visit.page.evaluate(
        "([name, value]) => { const e = document.getElementById(name); e.value = value;"
        " e.dispatchEvent(new Event('input')); }",
        [name, value],
    )


def shares(visit: Visit) -> list[str]:
    return [" ".join(row.split()) for row in visit.page.locator(".shares tr").all_inner_texts()]


@pytest.fixture(scope="module")
def page_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    plan = make_plan(PlanRequest(1050, 10.5, capture_fps=240.0))
    path = tmp_path_factory.mktemp("plan") / "plan.html"
    path.write_text(plan_page(plan, "data:,"), "utf-8")
    return path


@pytest.fixture
def visit(browser: sync_api.Browser, page_file: Path) -> Iterator[Visit]:
    opened = open_page(browser, page_file, DESK)
    yield opened
    opened.page.close()


def count_of(**changes: float) -> int:
    return simulate(Setup(**{"wall_gap_m": 0.03, **changes})).count  # type: ignore[arg-type]


def test_the_page_loads_from_disk_without_complaint_or_network(
    visit: Visit, page_file: Path
) -> None:
    visit.wait_for_text("count", 31)
    assert visit.complaints == []
    assert [one for one in visit.requests if one != "data:,"] == [page_file.as_uri()]
    assert "Theory: 31, the same" in visit.text("theory")
    assert "1.16 ms" in visit.text("shortest")
    assert "2170 frames a second" in visit.text("needed")
    assert shares(visit) == ["31 81%", "30 19%"], "as the text has them"


def test_every_slider_changes_what_is_counted_as_the_simulator_has_it(visit: Visit) -> None:
    slide(visit, "gap", 0.05)
    visit.wait_for_text("count", count_of(wall_gap_m=0.05))
    assert visit.text("gap-value") == "50 mm"
    slide(visit, "release", 0.15)
    visit.wait_for_text("count", count_of(wall_gap_m=0.05, release_m=0.15))
    visit.page.locator("#reset").click()
    visit.wait_for_text("count", 31)
    slide(visit, "clay", -10)
    assert visit.text("clay-value") == "945"
    visit.wait_for_text("count", count_of(heavy_mass_kg=0.945))
    assert "Theory: 29" in visit.text("theory")
    assert visit.complaints == []


def test_the_rate_changes_what_the_camera_sees(visit: Visit) -> None:
    visit.wait_for_text("count", 31)
    assert "0.28 frames from one to the next" in visit.text("camera")
    assert "a chance of 98%" in visit.text("camera")
    slide(visit, "rate", 3.5)
    assert "sees each" in visit.text("camera")
    assert float(visit.text("rate-value").split()[0]) == pytest.approx(3162, rel=0.005)


def test_nonsense_is_said_and_not_counted(visit: Visit) -> None:
    slide(visit, "release", 0.02)
    visit.wait_for_text("count", "–")
    assert "larger than the release" in visit.text("theory")
    visit.page.locator("#reset").click()
    visit.wait_for_text("count", 31)


def test_keys_move_sliders_and_the_set_up_on_the_map(visit: Visit) -> None:
    visit.page.locator("#gap").focus()
    for _ in range(20):
        visit.page.keyboard.press("ArrowRight")  # half a millimetre each
    visit.wait_for_text("count", count_of(wall_gap_m=0.04))
    assert visit.text("gap-value") == "40 mm"
    visit.page.locator("#map").focus()
    for _ in range(10):
        visit.page.keyboard.press("ArrowRight")
    visit.wait_for_text("count", count_of(wall_gap_m=0.05))
    visit.page.keyboard.press("ArrowUp")
    assert visit.page.locator("#release").input_value() == "0.092"


def test_everything_can_be_reached_by_the_tab_key(visit: Visit) -> None:
    reached = set()
    for _ in range(20):
        visit.page.keyboard.press("Tab")
        reached.add(visit.page.evaluate("document.activeElement.id"))
    assert {"gap", "release", "clay", "rate", "reset", "map"} <= reached


def test_a_tap_on_the_map_takes_the_set_up_there(visit: Visit) -> None:
    box = visit.page.locator("#map").bounding_box()
    assert box is not None
    visit.page.mouse.click(box["x"] + 0.8 * box["width"], box["y"] + 0.3 * box["height"])
    gap_m = float(visit.page.locator("#gap").input_value())
    release_m = float(visit.page.locator("#release").input_value())
    assert gap_m > 0.06
    assert release_m > 0.12
    visit.wait_for_text("count", count_of(wall_gap_m=gap_m, release_m=release_m))


def test_the_command_shown_is_that_of_the_set_up(visit: Visit) -> None:
    slide(visit, "gap", 0.05)
    visit.wait_for_text("count", 29)
    assert "--plan 1050 10.5 --gap 0.05 --release 0.09 --thread 1 1 " in visit.text("command")


def test_dark_and_light_pages_differ_and_are_drawn(
    browser: sync_api.Browser, page_file: Path
) -> None:
    drawn = {}
    for scheme in ("light", "dark"):
        opened = open_page(browser, page_file, DESK, scheme)
        opened.wait_for_text("count", 31)
        assert opened.complaints == []
        drawn[scheme] = opened.page.evaluate(
            "[...document.querySelectorAll('#map *')].map((e) => getComputedStyle(e).fill)"
        )
        assert len(set(drawn[scheme])) >= 5  # theory, others, ground, letters, dot
        ink, paper = opened.page.evaluate(
            "[getComputedStyle(document.body).color, getComputedStyle(document.body)"
            ".backgroundColor].map((c) => Number(c.match(/[0-9]+/)[0]))"
        )
        assert abs(ink - paper) > 150  # readable
        assert (ink > paper) == (scheme == "dark")
        opened.page.close()
    assert drawn["light"] != drawn["dark"]


def test_nothing_sticks_out_of_a_phones_screen(browser: sync_api.Browser, page_file: Path) -> None:
    opened = open_page(browser, page_file, PHONE)
    opened.wait_for_text("count", 31)
    assert opened.page.evaluate("document.documentElement.scrollWidth") <= PHONE["width"]
    small = opened.page.evaluate(
        "[...document.querySelectorAll('button, input[type=range]')]"
        ".map((b) => b.getBoundingClientRect().height)"
    )
    assert min(small) >= FINGER_PX
    assert opened.page.evaluate(
        "(({ scrollWidth, clientWidth }) => scrollWidth <= clientWidth)"
        "(document.querySelector('.sheet'))"
    ), "the picture is shown whole"
    lines = opened.page.evaluate(LINES_OF_OPTIONS)
    assert {"--plan", "--gap", "--thread", "--capture-fps"} <= {option for option, _ in lines}
    assert {number for _, number in lines} == {1}
    opened.page.locator("#map").scroll_into_view_if_needed()
    assert opened.page.locator("#count").is_visible()  # it stays while one scrolls
    slide(opened, "gap", 0.05)
    opened.wait_for_text("count", 29)
    assert opened.complaints == []
    opened.page.close()

"""The page, used in a real browser as a person would."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from evidence_made import Made

from count_video.batch.summary import summarise
from count_video.corrections import reviewed
from count_video.reports.page import campaign_page
from count_video.video.reader import open_footage
from table_rows import row
from visits import DESK, LINES_OF_OPTIONS, PHONE, Visit, open_page

if TYPE_CHECKING:
    from playwright import sync_api

CONTRAST = """(element) => {
  // Contrast of the letters to their ground, by the formula of WCAG 2.
  const channel = (v) => (v <= 10 ? v / 3295 : ((v / 255 + 0.055) / 1.055) ** 2.4);
  const light = (colour) => { const [r, g, b] = colour.match(/[\\d.]+/g).map(Number);
    return 0.2126 * channel(r) + 0.7152 * channel(g) + 0.0722 * channel(b); };
  let ground = element;
  const paper = (e) => getComputedStyle(e).backgroundColor;
  while (/(, 0\\)|transparent)$/.test(paper(ground))) ground = ground.parentElement;
  const [a, b] = [light(getComputedStyle(element).color), light(paper(ground))];
  return (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05); }"""


def entries(visit: Visit) -> list[str]:
    return visit.page.locator("#list button").all_inner_texts()


def save(visit: Visit, folder: Path) -> Path:
    with visit.page.expect_download() as download:
        visit.page.locator("#save").click()
    path = folder / download.value.suggested_filename
    download.value.save_as(path)
    return path


@pytest.fixture(scope="module")
def uncorrected(browser: sync_api.Browser, made: Made) -> Iterator[Visit]:
    """The page, shared by tests that go through the collisions and correct none."""
    opened = open_page(browser, made.file("html"), DESK)
    yield opened
    opened.page.close()


@pytest.fixture
def visit(browser: sync_api.Browser, made: Made) -> Iterator[Visit]:
    opened = open_page(browser, made.file("html"), DESK)
    yield opened
    opened.page.close()


def test_the_page_loads_without_complaint_and_without_a_network(visit: Visit, made: Made) -> None:
    assert visit.complaints == []
    schemes = {address.partition(":")[0] for address in visit.requests}
    assert schemes <= {"file", "data", "blob"}
    assert [a for a in visit.requests if a.startswith("file")] == [made.file("html").as_uri()]
    assert visit.page.locator("h1").inner_text() == "12 collisions"
    assert len(entries(visit)) == 12


def test_the_video_plays(visit: Visit) -> None:
    # On a busy machine the clip would be over before the button is read.
    visit.page.evaluate("document.getElementById('video').loop = true")
    begins = visit.page.evaluate("document.getElementById('video').currentTime")
    visit.page.locator("#play").click()
    visit.wait_until("document.getElementById('play').textContent === 'Stop'")
    visit.wait_until(f"document.getElementById('video').currentTime !== {begins}")
    visit.page.locator("#play").click()
    visit.wait_until("document.getElementById('video').paused")
    assert visit.complaints == []


def test_the_top_says_count_probability_masses_theory_and_pi(
    uncorrected: Visit, made: Made
) -> None:
    facts = uncorrected.page.locator(".facts").inner_text().split("\n")
    assert dict(zip(facts[::2], facts[1::2], strict=True)).keys() == {
        "Probability",
        "Theory",
        "Mass ratio",
        "Bounds on π",
    }
    assert facts[facts.index("Theory") + 1] == "12"


def test_the_contact_frames_are_in_sight_on_a_desk_and_the_page_opens_with_the_first(
    visit: Visit, made: Made
) -> None:
    assert visit.text("contact-title").startswith("Collision 1 between the bodies")
    visit.wait_for_text("frame", round(made.result.collisions[0].frame))
    for number in (1, 12):
        visit.page.locator("#list button").nth(number - 1).click()
        for part in ("#cuts", "#video", "#play"):
            box = visit.page.locator(part).bounding_box()
            assert box is not None
            assert box["y"] >= 0
            assert box["y"] + box["height"] <= DESK["height"], part


def test_times_stand_beside_the_frames_where_a_rate_is_known(
    uncorrected: Visit, made: Made
) -> None:
    for collision, entry in zip(made.result.collisions, entries(uncorrected), strict=True):
        frame, time = entry.splitlines()[-1].removesuffix(" ms").split(" · ")
        assert collision.time_s is not None
        assert abs(float(frame) - collision.frame) <= 0.051  # as rounded
        assert abs(float(time) - 1000 * collision.time_s) <= 0.051
    assert uncorrected.text("unit") == "frame · time"


def test_a_click_into_the_picture_goes_to_the_nearest_collision(
    uncorrected: Visit, made: Made
) -> None:
    panels = json.loads(uncorrected.page.locator("#data").text_content() or "")["panels"]
    assert len(panels) == 3, "space and time whole and enlarged, and velocities"
    (left, top, right, bottom), (low, high) = panels[0]["box"], panels[0]["frames"]
    for number in (2, 11):
        wanted = made.result.collisions[number - 1]
        share = left + (right - left) * (wanted.frame - low) / (high - low)
        box = uncorrected.page.locator("#picture").bounding_box()
        assert box is not None
        place = {"x": share * box["width"], "y": (top + bottom) / 2 * box["height"]}
        uncorrected.page.locator("#picture").click(position=place)
        uncorrected.wait_for_text("frame", round(wanted.frame))
        assert uncorrected.text("contact-title").startswith(f"Collision {number} ")


def test_a_click_on_a_collision_goes_to_its_frame_and_shows_it_enlarged(
    uncorrected: Visit, made: Made
) -> None:
    for number in (1, 7, 12):
        uncorrected.page.locator("#list button").nth(number - 1).click()
        nearest = round(made.result.collisions[number - 1].frame)
        uncorrected.wait_for_text("frame", nearest)
        captions = uncorrected.page.locator("#cuts figcaption").all_inner_texts()
        assert captions == [f"frame {nearest + step}" for step in (-1, 0, 1)]
        widths = uncorrected.page.evaluate(
            "Promise.all([...document.querySelectorAll('#cuts img')]"
            ".map(async (i) => { await i.decode(); return i.naturalWidth; }))"
        )
        assert widths == [300, 300, 300]


def test_the_video_shows_the_frame_that_the_page_names(uncorrected: Visit, made: Made) -> None:
    # The header writes the frame's number; its picture is compared with the annotated clip's own.
    uncorrected.page.locator("#list button").nth(5).click()
    index = round(made.result.collisions[5].frame)
    uncorrected.wait_for_text("frame", index)
    shown = uncorrected.page.evaluate(
        """() => { const v = document.getElementById('video');
        const c = document.createElement('canvas');
        c.width = v.videoWidth; c.height = v.videoHeight;
        const p = c.getContext('2d'); p.drawImage(v, 0, 0);
        const d = p.getImageData(0, 0, c.width, 72).data;
        return Array.from({length: c.width * 72}, (_, k) => d[4 * k + 1]); }"""
    )
    from_clip = header_of(made, index)
    others = [header_of(made, index + step) for step in (-1, 1)]
    off = [sum(abs(a - b) for a, b in zip(shown, h, strict=True)) for h in (from_clip, *others)]
    assert off[0] < min(off[1:])


def header_of(made: Made, index: int) -> list[int]:
    with open_footage(made.file("annotated.mp4")) as footage:
        return [int(v) for v in next(footage.frames(index)).luma[:72].ravel()]


def test_keys_go_through_the_collisions_and_the_frames(visit: Visit, made: Made) -> None:
    first, second, third = (round(c.frame) for c in made.result.collisions[:3])
    visit.wait_for_text("frame", first)
    visit.page.keyboard.press("ArrowDown")
    visit.wait_for_text("frame", second)
    visit.page.keyboard.press("ArrowRight")
    visit.wait_for_text("frame", third)
    visit.page.keyboard.press("ArrowLeft")
    visit.wait_for_text("frame", second)
    visit.page.keyboard.press("ArrowUp")
    visit.wait_for_text("frame", first)
    visit.page.keyboard.press(".")
    visit.wait_for_text("frame", first + 1)
    visit.page.keyboard.press(",")
    visit.wait_for_text("frame", first)
    visit.page.keyboard.press(" ")
    visit.wait_until("!document.getElementById('video').paused")


def test_everything_can_be_reached_by_the_tab_key(visit: Visit) -> None:
    visit.page.keyboard.press("ArrowDown")
    visit.page.keyboard.press("x")  # so that no button is switched off
    reached = set()
    for _ in range(20):
        visit.page.keyboard.press("Tab")
        name = visit.page.evaluate(
            "document.activeElement.id || document.activeElement.dataset?.key || ''"
        )
        reached.add(name)
    buttons = {"play", "seek", "back", "forth", "wrong", "add-bodies", "undo", "save", "enlarge"}
    assert buttons | {"note", "load", "sheet"} <= reached
    assert len({name for name in reached if "/" in name}) == 1, "the list is one stop"


def test_marking_wrong_changes_the_reviewed_count_and_marking_again_takes_it_back(
    visit: Visit,
) -> None:
    visit.page.locator("#list button").nth(2).click()
    assert visit.text("reviewed") == ""
    visit.page.locator("#wrong").click()
    assert visit.text("reviewed") == "Reviewed count: 11 (1 marked wrong, 0 added)"
    assert "marked wrong" in entries(visit)[2]
    assert visit.text("wrong").startswith("Mark right")
    struck = visit.page.locator("#list button").nth(2).locator(".removed").all_inner_texts()
    assert struck == ["bodies"], "the note beside it can be read"
    visit.page.keyboard.press("X")  # as with the capitals locked
    assert visit.text("reviewed") == ""
    assert visit.text("wrong").startswith("Mark wrong")


def test_a_missed_collision_is_added_at_the_frame_on_screen_and_can_be_taken_away(
    visit: Visit, made: Made
) -> None:
    visit.page.locator("#list button").nth(1).click()
    index = round(made.result.collisions[1].frame)
    visit.wait_for_text("frame", index)
    visit.page.locator("#forth").click()
    visit.wait_for_text("frame", index + 1)
    visit.page.locator("#add-wall").click()
    assert visit.text("reviewed") == "Reviewed count: 13 (0 marked wrong, 1 added)"
    assert len(entries(visit)) == 13
    assert "added" in entries(visit)[2]
    visit.page.locator("#list button").nth(2).click()
    visit.page.locator("#wrong").click()
    assert len(entries(visit)) == 12


def test_undo_goes_back_step_by_step(visit: Visit) -> None:
    assert visit.page.locator("#undo").is_disabled()
    visit.page.locator("#list button").nth(0).click()
    visit.page.keyboard.press("x")
    visit.page.keyboard.press("b")
    assert "Reviewed count: 12" in visit.text("reviewed")
    visit.page.keyboard.press("u")
    assert "Reviewed count: 11" in visit.text("reviewed")
    visit.page.locator("#undo").click()
    assert visit.text("reviewed") == ""
    assert visit.page.locator("#undo").is_disabled()
    assert visit.page.locator("#save").is_disabled()


def test_saved_corrections_change_the_reviewed_count_of_the_tool(
    visit: Visit, made: Made, tmp_path: Path
) -> None:
    for number in (3, 4):
        visit.page.locator("#list button").nth(number - 1).click()
        visit.page.keyboard.press("x")
    visit.page.keyboard.press("w")
    path = save(visit, tmp_path)
    assert path.name == f"{made.clip.stem}.corrections.json"
    stored = json.loads(path.read_text("utf-8"))
    assert stored["reviewed_count"] == 11
    result = reviewed(made.result, path)
    assert (result.count, result.reviewed_count) == (12, 11)
    assert [c.number for c in result.corrections] == [3, 4, None]
    assert visit.complaints == []


def test_after_saving_nothing_is_unsaved(visit: Visit, tmp_path: Path) -> None:
    visit.page.keyboard.press("x")
    assert visit.text("state").startswith("Not saved to a file yet")
    save(visit, tmp_path)
    assert visit.text("state") == "Saved to a file"
    asked = []
    visit.page.on("dialog", lambda dialog: (asked.append(dialog.type), dialog.accept()))
    visit.page.reload()
    visit.wait_until("document.getElementById('video').readyState >= 2")
    assert asked == []


def test_changes_and_notes_are_there_again_when_the_page_is_opened_again(visit: Visit) -> None:
    visit.page.keyboard.press("x")
    visit.page.locator("#note").fill("a shadow passes")  # and it is not left: letters are kept
    visit.page.on("dialog", lambda dialog: dialog.accept())
    visit.page.reload()
    visit.wait_until("document.getElementById('video').readyState >= 2")
    assert visit.text("reviewed").startswith("Reviewed count: 11")
    assert visit.page.locator("#note").input_value() == "a shadow passes"
    assert "note" in entries(visit)[0]
    visit.page.locator("#undo").click()
    assert visit.text("reviewed") == "", "what was there at first is one step back"


def test_what_was_saved_to_a_file_is_still_said_to_be_when_the_page_is_opened_again(
    visit: Visit, tmp_path: Path
) -> None:
    visit.page.keyboard.press("x")
    save(visit, tmp_path)
    visit.page.reload()
    visit.wait_until("document.getElementById('video').readyState >= 2")
    assert visit.text("state") == "Saved to a file"
    visit.page.keyboard.press("b")
    assert visit.text("state").startswith("Not saved to a file yet")


def test_one_step_back_takes_a_whole_note_away(visit: Visit) -> None:
    visit.page.locator("#note").click()
    visit.page.keyboard.type("a shadow")
    visit.page.locator("#undo").click()
    assert visit.page.locator("#note").input_value() == ""
    assert visit.page.locator("#undo").is_disabled()


def test_keys_typed_into_a_note_are_letters_of_the_note(visit: Visit) -> None:
    visit.page.locator("#note").click()
    visit.page.keyboard.type("box x u s")
    assert visit.page.locator("#note").input_value() == "box x u s"
    assert visit.text("reviewed") == ""


def test_a_saved_file_can_be_gone_on_from_and_notes_are_in_it(
    visit: Visit, made: Made, tmp_path: Path
) -> None:
    visit.page.locator("#list button").nth(3).click()
    visit.page.keyboard.press("x")
    visit.page.locator("#note").fill("no touch to be seen")
    visit.page.locator("#note").blur()
    path = save(visit, tmp_path)
    assert list(json.loads(path.read_text("utf-8"))["notes"].values()) == ["no touch to be seen"]
    assert reviewed(made.result, path).reviewed_count == 11
    visit.page.locator("#undo").click()
    visit.page.locator("#undo").click()
    assert visit.text("reviewed") == ""
    visit.page.locator("#load").set_input_files(path)
    visit.wait_until("document.getElementById('reviewed').textContent.startsWith('Reviewed')")
    assert "note" in entries(visit)[3]


def test_corrections_of_another_clip_of_this_name_change_nothing(
    visit: Visit, tmp_path: Path
) -> None:
    visit.page.keyboard.press("x")
    path = save(visit, tmp_path)
    stored = json.loads(path.read_text("utf-8")) | {"clip_sha256": "0" * 64}
    path.write_text(json.dumps(stored), "utf-8")
    visit.page.keyboard.press("x")
    visit.page.locator("#load").set_input_files(path)
    visit.wait_until("document.getElementById('state').textContent.includes('no corrections')")
    assert visit.text("reviewed") == ""


def test_what_a_file_says_can_be_taken_back_by_the_next(visit: Visit, tmp_path: Path) -> None:
    visit.page.keyboard.press("x")
    save(visit, tmp_path)
    visit.page.keyboard.press("x")
    assert visit.text("state").startswith("Not saved to a file yet")
    stored = json.loads(save(visit, tmp_path).read_text("utf-8"))
    assert stored["corrections"] == []
    assert visit.text("state") == ""


def test_keys_of_a_checkbox_and_of_a_table_are_their_own(visit: Visit) -> None:
    visit.page.locator("#enlarge").focus()
    visit.page.keyboard.press("Space")
    assert visit.page.locator("#enlarge").is_checked()
    assert visit.text("play") == "Play", "the clip stands"
    visit.page.locator("pre").last.focus()
    visit.page.keyboard.press("ArrowRight")
    assert visit.text("contact-title").startswith("Collision 1 ")


def test_one_that_is_taken_away_takes_its_note_and_its_heading_with_it(visit: Visit) -> None:
    visit.page.locator("#forth").click()
    visit.page.locator("#add-wall").click()
    visit.page.locator("#list button", has_text="added").click()
    visit.page.locator("#note").fill("a reflection")
    visit.page.locator("#note").blur()
    visit.page.locator("#wrong").click()
    assert not any("added" in entry for entry in entries(visit))
    assert visit.text("contact-title") == "Choose a collision to see its frames"
    assert visit.page.locator("#save").is_disabled(), "nothing is left to save"


@pytest.mark.parametrize("content", ["{", "[]", '{"clip": "other.mp4", "corrections": []}'])
def test_a_file_that_is_none_of_this_clips_corrections_changes_nothing(
    visit: Visit, tmp_path: Path, content: str
) -> None:
    wrong = tmp_path / "wrong.json"
    wrong.write_text(content, "utf-8")
    visit.page.locator("#load").set_input_files(wrong)
    visit.wait_until("document.getElementById('state').textContent.includes('no corrections')")
    assert visit.text("reviewed") == ""


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_words_can_be_read_by_day_and_by_night(
    browser: sync_api.Browser, made: Made, scheme: str
) -> None:
    context = browser.new_context(viewport=DESK, color_scheme=scheme)
    page = context.new_page()
    page.goto(made.file("html").as_uri())
    page.wait_for_timeout(300)
    for part in ("h1", ".facts dt", "#list button span:nth-child(3)", "#wrong", ".hint", "pre"):
        assert page.locator(part).first.evaluate(CONTRAST) >= 4.5, part
    dark = page.locator("section").first.evaluate(
        "(e) => Number(getComputedStyle(e).backgroundColor.match(/\\d+/)[0]) < 128"
    )
    assert dark == (scheme == "dark")
    context.close()


def test_the_picture_can_be_enlarged_on_a_phone(browser: sync_api.Browser, made: Made) -> None:
    opened = open_page(browser, made.file("html"), PHONE)
    width = "document.getElementById('picture').getBoundingClientRect().width"
    small = opened.page.evaluate(width)
    opened.page.locator("#enlarge").click()
    assert opened.page.evaluate(width) >= 3 * small
    assert opened.page.evaluate("document.documentElement.scrollWidth") <= PHONE["width"]
    assert not opened.page.locator(".keys").is_visible(), "no word of keys where there are none"
    assert opened.page.locator(".touch").is_visible()
    opened.page.close()


def test_a_page_made_with_corrections_starts_from_them(
    browser: sync_api.Browser, reviewed_page: Path
) -> None:
    opened = open_page(browser, reviewed_page, DESK)
    assert opened.text("reviewed") == "Reviewed count: 11 (1 marked wrong, 0 added)"
    opened.page.close()


@pytest.fixture
def reviewed_page(made: Made, tmp_path: Path) -> Path:
    """The page again, with a correction in it."""
    text = made.file("html").read_text("utf-8")
    one = '{"action": "wrong", "frame": 1.0, "kind": "wall", "number": 2}'
    page = tmp_path / "reviewed.html"
    assert '"corrections": []' in text
    page.write_text(text.replace('"corrections": []', f'"corrections": [{one}]'), "utf-8")
    return page


def test_nothing_sticks_out_of_a_phones_screen(browser: sync_api.Browser, made: Made) -> None:
    opened = open_page(browser, made.file("html"), PHONE)
    width = opened.page.evaluate("document.documentElement.scrollWidth")
    assert width <= PHONE["width"]
    opened.page.locator("#list button").nth(3).click()
    opened.wait_for_text("frame", round(made.result.collisions[3].frame))
    small = opened.page.evaluate(
        "[...document.querySelectorAll('button')].map((b) => b.getBoundingClientRect().height)"
    )
    assert min(small) >= 38  # a finger's width
    assert ["--corrections", 1] in opened.page.evaluate(LINES_OF_OPTIONS)
    assert opened.complaints == []
    opened.page.close()


def test_what_to_do_about_a_trial_can_be_read_on_a_phone(
    browser: sync_api.Browser, tmp_path: Path
) -> None:
    rows = [row("a trial with a name of some length", None, reason="film nearer, " * 9), row()]
    page = tmp_path / "campaign.html"
    page.write_text(campaign_page(rows, summarise(rows), (b"", "image/png")), "utf-8")

    opened = open_page(browser, page, PHONE)
    cells = "[...document.querySelectorAll('.trials td')]"
    right = opened.page.evaluate(f"{cells}.map((cell) => cell.getBoundingClientRect().right)")

    assert len(right) == 8
    assert max(right) <= PHONE["width"]
    opened.page.close()

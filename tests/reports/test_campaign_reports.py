"""The campaign's text, table and JSON from rows made by hand."""

from __future__ import annotations

import csv
import io
import json
import os
import pty
import select
from dataclasses import replace
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from count_video.batch.summary import summarise
from count_video.progress import TerminalBar
from count_video.records import Estimate
from count_video.reports.campaign import (
    TrialRow,
    campaign_text,
    histogram_lines,
    name_columns,
    trial_heading,
    trial_line,
)
from count_video.reports.exports import TRIAL_COLUMNS, campaign_json, trials_csv
from count_video.reports.page import campaign_page
from count_video.reports.words import printable
from table_rows import row

KEYS = [
    *("schema_version", "trials", "counted", "maximum", "minimum", "mean", "sd_population"),
    *("sd_sample", "histogram", "mean_uncertainty", "mean_expected", "theory", "theory_source"),
    *("theory_low", "theory_high", "mass_ratio", "restitution_bodies", "restitution_wall"),
    *("energy_kept", "geometric_share", "need_a_person", "groups"),
]


def test_a_nearly_certain_count_is_nowhere_called_certain() -> None:
    one = row(chance=0.998)
    assert "99.8%" in trial_line(one)
    page = campaign_page([one], summarise([one]), (b"", "image/png"))
    assert "99.8%" in page
    assert "100%" not in page.partition("<tbody>")[2]


@pytest.mark.parametrize("longest", [1, 24, 25, 60])
def test_columns_of_the_table_hold_the_longest_name(longest: int) -> None:
    trials = [replace(row(), name="n" * length) for length in (1, longest)]
    columns = name_columns(one.name for one in trials)
    ends = {line.index("%") for line in (trial_line(one, columns) for one in trials)}
    assert ends == {len(trial_heading(columns)) - 1}
    assert name_columns(["n" * 300]) == name_columns(["n" * 60])


def text_of(*rows: TrialRow) -> str:
    return campaign_text(rows, summarise(rows))


def cells_of(*rows: TrialRow) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(trials_csv(rows))))


def test_a_table_is_written_as_other_spreadsheets_read_it() -> None:
    trial = row("1.5", chance=0.25, reason="1.5; or 2", energy_kept=(2.5e-5,))
    (cells,) = csv.DictReader(io.StringIO(trials_csv([trial], "semicolon")), delimiter=";")
    assert cells["probability"] == "0,25"
    assert cells["energy_kept"] == "2,5e-05"
    assert cells["pi_low"] == ""
    assert cells["name"] == "1.5"  # a text is no number
    assert cells["reason"] == "1.5; or 2"
    assert cells_of(trial)[0]["probability"] == "0.25"


def test_the_theory_of_a_trial_is_that_of_its_masses_given_or_measured() -> None:
    measured = row("measured", mass_ratio=100.0, mass_ratio_sigma=0.5)
    vague = row("vague", mass_ratio=1.0, mass_ratio_sigma=0.01)  # 3 or 4
    known = replace(vague, name="known", masses=(Fraction(16), Fraction(1)))
    said = {cells["name"]: cells["theory"] for cells in cells_of(measured, vague, known)}
    assert said == {"measured": "31", "vague": "", "known": "12"}


@pytest.mark.parametrize(
    ("trial", "doubtful"),
    [
        (row(), False),
        (row(chance=0.9), False),
        (row(chance=0.89), True),
        (row(count=None), True),
        (row(not_kept="no space"), True),
    ],
    ids=["sure", "just sure", "less than sure", "not counted", "not kept"],
)
def test_who_needs_a_person_is_marked_everywhere_with_what_to_do(
    trial: TrialRow, doubtful: bool
) -> None:
    assert trial.needs_a_person == doubtful
    assert ("needs a person" in trial_line(trial)) == doubtful
    assert ("1 of 1 trial needs a person" in text_of(trial)) == doubtful
    assert (trial.advice != "") == doubtful
    assert (cells_of(trial)[0]["needs_a_person"] == "yes") == doubtful
    said = json.loads(campaign_json([trial], summarise([trial])))["need_a_person"]
    assert [doubt["what_to_do"] for doubt in said] == [trial.advice] * doubtful


def test_who_gave_no_video_is_not_advised_to_film_again() -> None:
    asked = "film it again"
    assert asked not in row(count=None, frames_decoded=None, what_to_do=asked).advice
    assert asked in row(count=None, frames_decoded=300, what_to_do=asked).advice


def test_those_who_need_a_person_come_first_with_the_reason() -> None:
    rows = [row("a"), row("b", None), row("c", 30, 0.6)]
    lines = text_of(*rows).splitlines()
    assert lines[0] == "2 of 3 trials need a person:"
    words = " ".join(text_of(*rows).split())
    assert "b: nothing moves" in words
    assert "c: probably 30 (30: 60%, 29: 40%)" in words
    assert words.index("b: nothing moves") < words.index("Number of trials")
    assert [cells["name"] for cells in cells_of(*rows)] == ["b", "c", "a"]


def test_the_summary_is_the_papers_table() -> None:
    rows = [
        row(str(k), count, mass_ratio=None)
        for k, count in enumerate([31] * 22 + [30] * 4 + [29] * 3 + [28])
    ]
    said = {line[:30].strip(): line[30:].split()[0] for line in text_of(*rows).splitlines()[:8]}
    assert said == {
        "Number of trials": "30",
        "of these counted": "30",
        "Maximum value": "31",
        "Minimum value": "28",
        "Mean value": "30.57",
        "Standard deviation": "0.80",
        "of a sample": "0.82",
        "Theory": "-",
    }


def test_the_histogram_has_a_line_a_count_and_marks_the_theory() -> None:
    rows = [
        row(str(k), count, masses=(Fraction(100), Fraction(1)))
        for k, count in enumerate([31, 31, 28])
    ]
    lines = text_of(*rows).partition("Collisions  trials\n")[2].splitlines()
    assert [line.split() for line in lines] == [
        ["31", "2", "##", "<", "theory"],
        ["30", "0"],
        ["29", "0"],
        ["28", "1", "#"],
    ]


def test_counts_far_apart_have_dots_between_them_and_not_a_line_each() -> None:
    histogram = {595: 1, 584: 2, 583: 1, 317: 4}
    lines = histogram_lines(histogram, [400])[2:]
    assert {int(line.split()[0]): int(line.split()[1]) for line in lines if "..." not in line} == {
        **dict.fromkeys((594, 585, 582, 401, 400, 399, 318), 0),
        **histogram,
    }
    assert sum("..." in line for line in lines) == 3
    assert [line for line in lines if "theory" in line] == ["       400       0    < theory"]


def test_a_long_campaign_keeps_its_histogram_on_the_screen() -> None:
    rows = [row(str(k)) for k in range(1000)]
    assert max(map(len, text_of(*rows).splitlines())) <= 80


def test_one_trial_alone_has_no_spread() -> None:
    assert "SD" not in text_of(row("a", restitution_wall=0.98))
    assert "SD 0.010 over 2" in text_of(
        row("a", restitution_wall=0.98), row("b", restitution_wall=0.96)
    )


@pytest.mark.parametrize("width", [40, 60])
def test_sentences_are_as_wide_as_is_asked_for(width: int) -> None:
    rows = [row("a", None, reason=" ".join(["word"] * 40))]
    lines = campaign_text(rows, summarise(rows), width).partition("Number of")[0].splitlines()
    assert max(map(len, lines)) <= width
    assert len(lines) > 3


def test_no_trial_at_all_has_a_summary() -> None:
    assert "Number of trials                     0" in text_of()
    assert json.loads(campaign_json([], summarise([])))["mean"] is None


@pytest.mark.parametrize("count", [31, None])
def test_the_keys_of_the_json_are_always_the_same(count: int | None) -> None:
    said = json.loads(campaign_json([row(count=count)], summarise([row(count=count)])))
    assert list(said) == KEYS


def test_the_physics_is_given_where_it_is_known() -> None:
    rows = [row("a", restitution_wall=0.98, ending="geometric"), row("b", restitution_wall=0.96)]
    said = json.loads(campaign_json(rows, summarise(rows)))
    assert said["restitution_wall"] == {
        "number": 2,
        "mean": pytest.approx(0.97),
        "sd": pytest.approx(0.01),
    }
    assert said["restitution_bodies"] is None
    assert said["geometric_share"] == 1.0
    assert "Restitution at the wall" in text_of(*rows)
    assert "Restitution" not in text_of(row())


@given(st.text(max_size=30), st.text(max_size=30))
def test_any_name_and_reason_stay_in_their_cell_and_off_the_terminal(
    name: str, reason: str
) -> None:
    trial = row(name, None, reason=reason, clip=name)
    (cells,) = cells_of(trial)
    assert set(cells) == set(TRIAL_COLUMNS)
    assert cells["name"] in (printable(name), f"'{printable(name)}")
    assert all(sign.isprintable() or sign == "\n" for sign in text_of(trial))
    assert trial_line(trial).isprintable()


@pytest.mark.parametrize("name", ["=1+1", "+1", "-1", "@x"])
def test_a_name_is_never_a_spreadsheets_formula(name: str) -> None:
    assert cells_of(row(name))[0]["name"] == f"'{name}"


def test_the_bar_shows_clips_done_and_gives_way_to_a_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "120")
    reader, writer = pty.openpty()
    with os.fdopen(writer, "w", encoding="utf-8") as terminal:
        bar = TerminalBar(terminal, "clips")
        bar.start(30, "")
        bar.advance(12)
        with bar.aside():
            terminal.write("a line\n")
            terminal.flush()
        bar.finish()
        shown = ""
        while "a line" not in shown:  # what is written may arrive in pieces
            assert select.select([reader], [], [], 60.0)[0]
            shown += os.read(reader, 1 << 16).decode()
    os.close(reader)
    assert "12/30" in shown
    assert "/min" in shown
    assert "a line" in shown


def test_a_trial_whose_motion_contradicts_its_masses_needs_a_person() -> None:
    masses = (Fraction(36), Fraction(1))
    shown = Estimate(16.001, 0.017)
    rows = [
        row("a", 12, masses=masses, mass_ratio=36.0, mass_ratio_sigma=None),
        row(
            "b",
            12,
            masses=masses,
            mass_ratio=36.0,
            mass_ratio_sigma=None,
            contradicting_ratio=shown,
        ),
    ]
    words = " ".join(campaign_text(rows, summarise(rows)).split())
    assert "1 of 2 trials needs a person" in words
    assert "b: the masses given have the ratio 36, the motion shows 16.001 +- 0.017" in words
    assert "the motion shows 16.001 +- 0.017" in campaign_page(rows, summarise(rows), (b"", ""))

"""The chances that a plan names are those of the tables of docs/accuracy.md."""

from __future__ import annotations

import pytest

from count_video.planning import plan as measured
from count_video.planning.plan import Measured, most_like
from pages import page, section

ACCURACY = "docs/accuracy.md"


def rows(heading: str) -> list[list[str]]:
    """Return the cells of all table rows of a section of the page."""
    lines = [line for line in section(ACCURACY, heading).splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]


def test_resolved_clips_are_those_of_the_suite() -> None:
    (row,) = [row for row in rows("As people really film") if row[0] == "all"]
    clips, exact, not_counted, wrong = map(int, row[2:6])
    assert (clips, exact, not_counted, wrong) == numbers(measured.RESOLVED)


def test_clips_between_the_frames_are_those_of_the_filmed_study() -> None:
    table = [row for row in rows("Between the frames") if len(row) == 7 and row[0].isdigit()]
    filmed = [list(map(int, row[1:2] + row[3:6])) for row in table if row[6].startswith("0.")]
    assert len(filmed) == 3
    assert tuple(map(sum, zip(*filmed, strict=True))) == numbers(measured.BETWEEN)


def test_close_clips_are_those_of_the_planned_study() -> None:
    (row,) = [row for row in rows("Planned and counted") if row[0].startswith("0.08")]
    assert tuple(map(int, row[1:5])) == numbers(measured.CLOSE)


def test_long_bursts_are_those_with_the_masses_given() -> None:
    table = [row for row in rows("Between the frames") if len(row) == 6 and row[1] == "given"]
    exact = sum(int(row[2]) for row in table)
    silent, wrong = (sum(int(row[column]) for row in table) for column in (3, 4))
    # Ten tracks in the table, ten rendered clips in the text below it.
    assert "all came out exactly with their masses given" in " ".join(page(ACCURACY).split())
    assert (exact + silent + wrong + 10, exact + 10, silent, wrong) == numbers(measured.LONG)


def numbers(clips: Measured) -> tuple[int, int, int, int]:
    return clips.clips, clips.exact, clips.not_counted, clips.wrong


@pytest.mark.parametrize(
    ("count", "frames", "fps", "way", "like"),
    [
        (31, 2.5, 2000.0, "seen", measured.RESOLVED),
        (400, 2.5, 2e5, "seen", measured.RESOLVED),
        (31, 2.4, 2000.0, "inferred", measured.BETWEEN),
        (31, 0.25, 240.0, "inferred", measured.BETWEEN),
        (31, 0.24, 240.0, "inferred", measured.CLOSE),
        (31, 0.05, 60.0, "not measured", None),
        (60, 1.0, 960.0, "not measured", None),
        (314, 0.01, 1000.0, "inferred", measured.LONG),
        (314, 0.01, 240.0, "not measured", None),
    ],
)
def test_a_plan_is_promised_what_clips_like_it_have_shown(
    count: int, frames: float, fps: float, way: str, like: Measured | None
) -> None:
    assert most_like(count, frames, fps) == (way, like)


def test_a_chance_is_never_certain() -> None:
    assert 0.5 < Measured("", clips=1, exact=1, not_counted=0, wrong=0).chance < 1
    assert measured.BETWEEN.chance < 1

from __future__ import annotations

import csv
import json
from dataclasses import replace
from fractions import Fraction
from typing import Any

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from count_video.batch.results import packed, unpacked
from count_video.batch.summary import summarise
from count_video.records import Ending, Estimate, TrialResult
from count_video.reports.campaign import TrialRow, campaign_text
from count_video.reports.exports import campaign_json, trials_csv
from count_video.reports.page import campaign_page

RESULT = TrialResult("trial.mp4", "not_counted", "nothing moves")


def row_with(masses: tuple[Fraction, Fraction] | None = None, **changes: Any) -> TrialRow:
    return TrialRow("trial", replace(RESULT, **changes), masses)


def cells_of(row: TrialRow) -> dict[str, str]:
    return dict(zip(*csv.reader(trials_csv([row]).splitlines()), strict=True))


def test_a_result_without_physics_leaves_its_columns_open() -> None:
    row = row_with()
    assert (row.result.count, row.result.reason, row.result.chance) == (None, "nothing moves", None)
    names = ("restitution_bodies", "restitution_wall", "energy_kept", "ending")
    assert [cells_of(row)[name] for name in names] == [""] * 4


def test_the_physics_of_a_result_is_read() -> None:
    cells = cells_of(
        row_with(
            restitution_bodies=Estimate(0.99, 0.01),
            energy_kept=(1.0, 0.98, 0.97),
            ending=Ending("geometric", 0.97, 0.9, 0.5),
        )
    )
    assert (cells["restitution_bodies"], cells["restitution_wall"]) == ("0.99", "")
    assert (cells["energy_kept"], cells["ending"]) == ("0.97", "geometric")


def test_the_theory_of_a_row_is_exact() -> None:
    assert row_with((Fraction(1), Fraction(1))).theory == 3


def test_a_probability_is_that_of_the_count() -> None:
    row = row_with(status="counted", count=31, probability={30: 0.2, 31: 0.8})
    assert row.result.chance == pytest.approx(0.8)
    assert row.needs_a_person


ANY_JSON = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers() | st.text(max_size=20),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner),
    max_leaves=5,
)
KEPT = json.loads(packed(RESULT))


@given(st.dictionaries(st.sampled_from(sorted(KEPT)), ANY_JSON, min_size=1, max_size=3))
@example({"status": "counted", "count": 10**400, "probability": {}})
@example({"status": "counted", "count": 31, "probability": {"31": float("inf")}})
@example({"status": "counted", "count": 31, "probability": {"x": 1}})
@example({"status": "counted", "count": 31, "probability": {"31": None}})
@example({"status": "counted", "count": None, "probability": {}})
@example({"energy_kept": [float("nan")], "ending": {"kind": {}}})
@example({"restitution_bodies": {"value": 10**400}})
@example({"status": "counted", "count": 31, "mass_ratio": 1e-300, "mass_ratio_sigma": 1e-300})
@example({"status": "counted", "count": 31, "mass_ratio": 1e40, "mass_ratio_sigma": -1})
@example({"status": "counted", "count": 31, "mass_ratio": 1e-40, "mass_ratio_sigma": 1e-49})
def test_an_edited_result_fits_into_all_tables_or_is_none(changes: dict[str, object]) -> None:
    try:
        row = replace(row_with(), result=unpacked(TrialResult, json.dumps(KEPT | changes)))
    except ValueError:
        return
    summary = summarise([row])
    assert json.loads(campaign_json([row], summary))["trials"] == 1
    assert len(trials_csv([row]).splitlines()) == 2
    assert campaign_text([row], summary)
    assert "<tbody" in campaign_page([row], summary, (b"", "image/png"))


@given(st.text() | ANY_JSON.map(json.dumps) | st.integers(1, 9999).map(lambda deep: "[" * deep))
def test_a_text_that_is_no_result_is_refused_as_such(text: str) -> None:
    with pytest.raises(ValueError, match=r"."):
        unpacked(TrialResult, text)

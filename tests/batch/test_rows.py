from __future__ import annotations

import csv
import json

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from count_video.batch.manifest import Job
from count_video.batch.summary import row_of, summarise
from count_video.pipeline import TrialSettings
from count_video.records import unread_result
from count_video.reports.campaign import campaign_json, campaign_text
from count_video.reports.json_object import json_object, read_result
from count_video.reports.page import campaign_page
from count_video.reports.tables import trials_csv

JOB = Job("trial", "trial.mp4", TrialSettings())
RESULT = json_object(unread_result("trial.mp4", "nothing moves"))


def test_a_result_without_physics_leaves_its_columns_open() -> None:
    row = row_of(JOB, json.dumps(RESULT))
    assert (row.count, row.result["reason"], row.probability) == (None, "nothing moves", None)
    cells = dict(zip(*csv.reader(trials_csv([row]).splitlines()), strict=True))
    names = ("restitution_bodies", "restitution_wall", "energy_kept", "ending")
    assert [cells[name] for name in names] == [""] * 4


def test_the_physics_of_a_result_is_read() -> None:
    physics = {
        "restitution": {"bodies": {"value": 0.99, "sigma": 0.01}, "wall": None},
        "energy_kept": [1.0, 0.98, 0.97],
        "ending": {"kind": "geometric"},
    }
    row = row_of(JOB, json.dumps(RESULT | physics))
    cells = dict(zip(*csv.reader(trials_csv([row]).splitlines()), strict=True))
    assert (cells["restitution_bodies"], cells["restitution_wall"]) == ("0.99", "")
    assert (cells["energy_kept"], cells["ending"]) == ("0.97", "geometric")


def test_a_burst_without_energies_leaves_the_energy_open() -> None:
    assert row_of(JOB, json.dumps(RESULT | {"energy_kept": []})).figure("energy_kept") is None


def test_the_theory_of_a_row_is_exact() -> None:
    masses = TrialSettings(masses=(1, 1))  # type: ignore[arg-type]
    assert row_of(Job("a", "a.mp4", masses), json.dumps(RESULT)).theory == 3


def test_a_probability_is_that_of_the_count() -> None:
    counted = {"status": "counted", "count": 31, "probability": {"30": 0.2, "31": 0.8}}
    row = row_of(JOB, json.dumps(RESULT | counted))
    assert row.probability == pytest.approx(0.8)
    assert row.needs_a_person


ANY_JSON = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers() | st.text(max_size=20),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner),
    max_leaves=5,
)


@given(st.dictionaries(st.sampled_from(sorted(RESULT)), ANY_JSON, min_size=1, max_size=3))
@example({"status": "counted", "count": 10**400, "probability": {}})
@example({"status": "counted", "count": 31, "probability": {"31": float("inf")}})
@example({"status": "counted", "count": 31, "probability": {"x": 1}})
@example({"status": "counted", "count": 31, "probability": {"31": None}})
@example({"status": "counted", "count": None, "probability": {}})
@example({"energy_kept": [float("nan")], "ending": {"kind": {}}})
@example({"restitution": {"bodies": {"value": 10**400}}})
@example({"status": "counted", "count": 31, "mass_ratio": 1e-300, "mass_ratio_sigma": 1e-300})
@example({"status": "counted", "count": 31, "mass_ratio": 1e40, "mass_ratio_sigma": -1})
@example({"status": "counted", "count": 31, "mass_ratio": 1e-40, "mass_ratio_sigma": 1e-49})
def test_an_edited_result_fits_into_all_tables_or_is_none(changes: dict[str, object]) -> None:
    try:
        row = row_of(JOB, json.dumps(RESULT | changes))
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
        read_result(text)

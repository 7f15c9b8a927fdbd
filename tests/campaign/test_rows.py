from __future__ import annotations

import json

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from count_video.campaign.plan import Job
from count_video.campaign.rows import read_result, row_of
from count_video.campaign.statistics import summarise
from count_video.reports.campaign_json import campaign_json
from count_video.reports.campaign_page import campaign_page
from count_video.reports.campaign_table import trials_csv
from count_video.reports.campaign_text import campaign_text
from count_video.reports.json_object import json_object
from count_video.trial import TrialSettings
from count_video.verdict import unread_result

JOB = Job("trial", "trial.mp4", TrialSettings())
RESULT = json_object(unread_result("trial.mp4", "nothing moves"))


def test_a_result_without_physics_leaves_its_columns_open() -> None:
    row = row_of(JOB, json.dumps(RESULT))
    assert (row.status, row.reason, row.probability) == ("not_counted", "nothing moves", None)
    assert row.restitution_bodies is row.restitution_wall is row.energy_kept is row.ending is None


def test_the_physics_of_a_result_is_read() -> None:
    physics = {
        "restitution": {"bodies": {"value": 0.99, "sigma": 0.01}, "wall": None},
        "energy_kept": [1.0, 0.98, 0.97],
        "ending": {"kind": "geometric"},
    }
    row = row_of(JOB, json.dumps(RESULT | physics))
    assert (row.restitution_bodies, row.restitution_wall) == (0.99, None)
    assert (row.energy_kept, row.ending) == (0.97, "geometric")


def test_a_burst_without_energies_leaves_the_energy_open() -> None:
    assert row_of(JOB, json.dumps(RESULT | {"energy_kept": []})).energy_kept is None


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
def test_an_edited_result_fits_into_all_tables_or_is_none(changes: dict[str, object]) -> None:
    try:
        row = row_of(JOB, json.dumps(RESULT | changes))
    except ValueError:
        return
    summary = summarise([row])
    assert json.loads(campaign_json([row], summary))["trials"] == 1
    assert len(trials_csv([row]).splitlines()) == 2
    assert campaign_text([row], summary)
    assert "<li" in campaign_page([row], summary, (b"", "image/png"))


@given(st.text() | ANY_JSON.map(json.dumps) | st.integers(1, 9999).map(lambda deep: "[" * deep))
def test_a_text_that_is_no_result_is_refused_as_such(text: str) -> None:
    with pytest.raises(ValueError, match=r"."):
        read_result(text)

from __future__ import annotations

import json

import pytest

from count_video.campaign.plan import Job
from count_video.campaign.rows import row_of
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

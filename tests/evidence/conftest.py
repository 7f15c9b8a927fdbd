"""The evidence of one rendered clip with known truth, made once for all tests."""

from __future__ import annotations

import json

import numpy as np
import pytest
from evidence_made import CLIP, FIXTURES, Made, Truth

from count_video.evidence import EvidenceSettings, draw_evidence
from count_video.followed import followed
from count_video.pipeline import TrialSettings, work_through
from count_video.records import Floats


@pytest.fixture(scope="session")
def made(tmp_path_factory: pytest.TempPathFactory) -> Made:
    folder = tmp_path_factory.mktemp("evidence")
    settings = TrialSettings(capture_fps=480.0)
    trial = work_through(CLIP, settings)
    draw_evidence(followed(trial), EvidenceSettings(folder))
    return Made(CLIP, folder, trial, trial.result)


@pytest.fixture(scope="session")
def truth() -> Truth:
    stored = json.loads((FIXTURES / "ratio16-count12.truth.json").read_text("utf-8"))

    def points(face: str) -> Floats:
        return np.array([row[f"{face}_point_px"] for row in stored["frames"]], dtype=np.float64)

    ball = (points("ball_near") + points("ball_far")) / 2
    return Truth(ball[:, 0], ball[:, 1], stored["ball_diameter_px"], points("cylinder")[:, 0])

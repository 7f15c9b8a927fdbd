"""The evidence of one rendered clip with known truth, made once for all tests."""

from __future__ import annotations

import json
import os
import pickle

import numpy as np
import pytest
from evidence_made import CLIP, FIXTURES, Made, Truth

from count_video.evidence import EvidenceSettings, draw_evidence
from count_video.outputs import held, open_outputs
from count_video.pipeline import TrialSettings, work_through
from count_video.records import Floats


@pytest.fixture(scope="session")
def made(tmp_path_factory: pytest.TempPathFactory) -> Made:
    top = tmp_path_factory.getbasetemp()
    shared = top.parent if "PYTEST_XDIST_WORKER" in os.environ else top  # by all processes
    folder = shared / "evidence"
    hidden = open_outputs(folder).hidden
    stored = hidden / "trial.pickle"
    with held(hidden / "made.lock", wait=True):
        if not stored.exists():
            trial = work_through(CLIP, TrialSettings(capture_fps=480.0))
            draw_evidence(trial, EvidenceSettings(folder))
            stored.write_bytes(pickle.dumps(trial))
    kept = pickle.loads(stored.read_bytes())
    return Made(CLIP, folder, kept, kept.result)


@pytest.fixture(scope="session")
def truth() -> Truth:
    stored = json.loads((FIXTURES / "ratio16-count12.truth.json").read_text("utf-8"))

    def points(face: str) -> Floats:
        return np.array([row[f"{face}_point_px"] for row in stored["frames"]], dtype=np.float64)

    ball = (points("ball_near") + points("ball_far")) / 2
    return Truth(ball[:, 0], ball[:, 1], stored["ball_diameter_px"], points("cylinder")[:, 0])

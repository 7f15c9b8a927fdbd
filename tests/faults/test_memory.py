"""A machine without memory for a clip: one clear line, and the other clips are counted."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest
from command import faults_of
from test_any_request import answer_to

from count_video import pipeline
from count_video.batch.executor import count_job
from count_video.batch.manifest import Job
from count_video.errors import MachineError
from count_video.memory import shortage_told
from count_video.pipeline import TrialSettings

COUNTS_3 = Path(__file__).parents[2] / "fixtures" / "ratio1-count3.mp4"
MORE_THAN_ANY = 1 << 55


def too_much_for_numpy(*_: object) -> None:
    np.empty(MORE_THAN_ANY)


def too_much_for_opencv(*_: object) -> None:
    cv2.resize(np.zeros((2, 2), np.uint8), (1 << 30, 1 << 30))


def too_much_for_python(*_: object) -> None:
    bytearray(MORE_THAN_ANY)


TOO_MUCH = (too_much_for_numpy, too_much_for_opencv, too_much_for_python)


@pytest.mark.parametrize("demand", TOO_MUCH)
def test_a_shortage_is_one_sentence_whoever_meets_it(demand: Callable[[], None]) -> None:
    with pytest.raises(MachineError, match="not enough memory"), shortage_told():
        demand()


def test_any_other_error_of_opencv_stays_what_it_is() -> None:
    with pytest.raises(cv2.error), shortage_told():
        cv2.resize(np.zeros((2, 2), np.uint8), (0, 0))


@pytest.mark.parametrize("demand", TOO_MUCH)
def test_a_shortage_is_the_answer_of_its_clip(
    demand: Callable[..., None], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(pipeline, "work_through", demand)
    answer = answer_to("--json", str(COUNTS_3))
    assert (answer.code, faults_of(answer, 1)) == (1, [])
    assert "not enough memory" in json.loads(answer.out)["reason"]


@pytest.mark.parametrize("demand", TOO_MUCH)
def test_a_shortage_in_a_campaign_is_not_kept_as_the_answer_for_good(
    demand: Callable[..., None], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    clip = shutil.copy(COUNTS_3, tmp_path)
    monkeypatch.setattr(pipeline, "work_through", demand)
    answer = count_job(Job("clip", str(clip), TrialSettings()))
    assert not answer.final
    assert "not enough memory" in json.loads(answer.text)["reason"]

"""A machine without memory for a clip: one clear line, and the other clips are counted."""

from __future__ import annotations

import json
import resource
import shutil
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest
from command import ask, faults_of, unfinished
from test_any_request import answer_to

from count_video import pipeline, process
from count_video.batch.executor import count_job
from count_video.batch.manifest import Job
from count_video.errors import MachineError, UsageError
from count_video.pipeline import TrialSettings
from count_video.process import LEAST_BYTES, check_limits, check_memory, shortage_explained
from count_video.reports import plan_text
from count_video.video.writer import WriteOptions, write_clip

COUNTS_3 = Path(__file__).parents[2] / "fixtures" / "ratio1-count3.mp4"
MORE_THAN_ANY = 1 << 55
MUCH_BYTES = 1 << 30
LARGE_FRAMES = 20


def too_much_for_numpy(*_: object) -> None:
    np.empty(MORE_THAN_ANY)


def too_much_for_opencv(*_: object) -> None:
    cv2.resize(np.zeros((2, 2), np.uint8), (1 << 30, 1 << 30))


def too_much_for_python(*_: object) -> None:
    bytearray(MORE_THAN_ANY)


TOO_MUCH = (too_much_for_numpy, too_much_for_opencv, too_much_for_python)


@pytest.mark.parametrize("demand", TOO_MUCH)
def test_a_shortage_is_one_sentence_whoever_meets_it(demand: Callable[[], None]) -> None:
    with pytest.raises(MachineError, match="not enough memory"), shortage_explained():
        demand()


def test_whatever_fails_without_memory_fails_for_want_of_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(process, "check_memory", too_much_for_python)
    with pytest.raises(MachineError, match="not enough memory"), shortage_explained():
        raise ValueError("Input array could not be made C-contiguous")
    with pytest.raises(UsageError, match="no such"), shortage_explained():
        raise UsageError("no such option")


def test_any_other_error_of_opencv_stays_what_it_is() -> None:
    with pytest.raises(cv2.error), shortage_explained():
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
    assert "not enough memory" in str(answer.result.answer.reason)


def test_a_shortage_outside_of_the_clips_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(plan_text, "theory_text", too_much_for_python)
    answer = answer_to("--theory", "100", "1")
    assert (answer.code, faults_of(answer)) == (2, [])
    assert "not enough memory" in answer.err


@pytest.mark.parametrize("name", LEAST_BYTES)
def test_a_limit_that_no_clip_fits_into_is_named_before_anything_is_loaded(name: str) -> None:
    option, least = LEAST_BYTES[name]
    answer = ask("--json", COUNTS_3, limits={name: least - 1})
    assert (answer.code, answer.out, faults_of(answer)) == (2, "", [])
    assert f"ulimit -{option}" in answer.err


@pytest.mark.parametrize("name", LEAST_BYTES)
def test_a_small_clip_fits_into_the_least_limit(name: str) -> None:
    answer = ask("--json", COUNTS_3, limits={name: LEAST_BYTES[name][1]})
    assert (answer.code, faults_of(answer, 1)) == (0, [])


def test_a_process_without_limits_is_not_complained_about() -> None:
    check_limits()


@pytest.mark.slow
@pytest.mark.parametrize("megabytes", [50, *range(100, 2001, 100)])
@pytest.mark.parametrize("name", LEAST_BYTES)
def test_every_limit_ends_with_a_count_or_one_line(
    name: str, megabytes: int, large_clip: Path
) -> None:
    for clip, frames in ((COUNTS_3, 108), (large_clip, LARGE_FRAMES)):
        answer = ask("--json", clip, limits={name: megabytes * 1_000_000})
        assert faults_of(answer, 1) == []
        assert answer.code == 0 or answer.err.count("\n") == 1
        for line in answer.out.splitlines():
            assert json.loads(line)["frames_decoded"] in (None, frames), "frames lost on the way"


@pytest.mark.slow
@pytest.mark.parametrize("megabytes", range(600, 1101, 50))
@pytest.mark.parametrize(
    "arguments",
    [
        [COUNTS_3],
        [COUNTS_3, COUNTS_3.with_name("ratio16-count12.mp4"), "--pages", "--jobs=1"],
        ["--plan", "100", "1"],
    ],
    ids=["evidence", "campaign", "plan"],
)
def test_every_limit_leaves_evidence_whole_or_one_line(
    megabytes: int, arguments: list[object], tmp_path: Path
) -> None:
    answer = ask(*arguments, "-o", tmp_path, limits={"RLIMIT_AS": megabytes * 1_000_000})
    assert faults_of(answer) == []
    assert unfinished(tmp_path) == []


@pytest.fixture(scope="module")
def large_clip(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A clip of pictures of the largest size, whose decoder takes half a gigabyte."""
    clip = tmp_path_factory.mktemp("large") / "clip.mp4"
    picture = np.full((4320, 4096), 90, np.uint8)
    write_clip(
        clip, (picture + np.uint8(k) for k in range(LARGE_FRAMES)), WriteOptions(preset="ultrafast")
    )
    return clip


def test_to_ask_for_memory_fills_none() -> None:
    """Each packet that is refused asks: memory that is filled would take minutes."""
    before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
    check_memory(MUCH_BYTES)
    touched = resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before
    assert touched < MUCH_BYTES // resource.getpagesize() // 100


def test_masses_of_no_experiment_take_no_more_memory_than_others() -> None:
    """Theory has 314 159 collisions for them, each of which a fit would follow in thousands."""
    clip = COUNTS_3.with_name("ratio16-count12.mp4")

    answer = ask(clip, "--masses", "1e10", "1", limits={"RLIMIT_AS": 1_200_000_000})

    assert answer.code == 0
    assert answer.out.startswith(f"{clip.name}: 12 collisions")

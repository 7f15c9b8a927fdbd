from __future__ import annotations

import json
import os
from dataclasses import replace
from pathlib import Path

import pytest

from count_video.answers import Followed
from count_video.batch import executor, results
from count_video.batch.executor import Answer, tool_version
from count_video.batch.manifest import Job
from count_video.batch.results import ResultStore, open_store
from count_video.errors import UsageError
from count_video.inputs import content_digest, signature
from count_video.outputs import HIDDEN, OutputFolder
from count_video.pipeline import TrialSettings
from count_video.records import TrialResult
from count_video.reports.exports import json_line
from count_video.result import Result
from count_video.settings import EvidenceSettings


@pytest.fixture
def job(tmp_path: Path) -> Job:
    clip = tmp_path / "trial.mp4"
    clip.write_bytes(b"a clip")
    return Job("trial", str(clip), TrialSettings())


@pytest.fixture
def kept(tmp_path: Path) -> ResultStore:
    folder = tmp_path / "results"
    (folder / HIDDEN).mkdir(parents=True)
    return ResultStore(OutputFolder(folder), fresh=False)


def answer_to(job: Job, *, final: bool = True, reason: str = "nothing moves") -> Answer:
    found = Followed(TrialResult(job.clip, "not_counted", reason))
    content = content_digest(job.file) if final else None
    return Answer(Result(found, signature=signature(job.file)), content, tool_version())


def keep(kept: ResultStore, job: Job) -> Followed:
    answer = answer_to(job)
    kept.keep(job, answer)
    return answer.result.followed


def test_a_result_is_known_while_nothing_changes(kept: ResultStore, job: Job) -> None:
    assert kept.known(job) is None
    result = keep(kept, job)
    assert kept.known(job) == result
    written = (kept.outputs.folder / "trial.json").read_text("utf-8")
    assert written == f"{json_line(result.result)}\n"


def test_pages_in_another_dialect_are_written_again(kept: ResultStore, job: Job) -> None:
    folder = kept.outputs.folder
    job = replace(job, pages=EvidenceSettings(folder))
    kept.outputs.write("trial.html", b"a page")
    kept.keep(job, replace(answer_to(job), evidence=("trial.html",)))
    assert not isinstance(kept.recall(job), Job)
    again = kept.recall(replace(job, pages=EvidenceSettings(folder, csv_dialect="semicolon")))
    assert isinstance(again, Job)
    assert again.found is not None, "without a new count"


def test_another_content_makes_a_result_unknown(kept: ResultStore, job: Job) -> None:
    keep(kept, job)
    job.file.write_bytes(b"b clip")
    assert kept.known(job) is None


def test_the_same_content_in_a_newer_file_is_known(kept: ResultStore, job: Job) -> None:
    result = keep(kept, job)
    os.utime(job.file, ns=(1, 1))
    assert kept.known(job) == result


def test_a_clip_whose_signature_did_not_change_is_not_read(
    kept: ResultStore, job: Job, monkeypatch: pytest.MonkeyPatch
) -> None:
    result = keep(kept, job)

    def read(file: Path) -> str:
        raise AssertionError(f"{file} was read")

    monkeypatch.setattr(results, "content_digest", read)
    assert kept.known(job) == result


def test_other_options_make_a_result_unknown(kept: ResultStore, job: Job) -> None:
    keep(kept, job)
    other = replace(job, settings=TrialSettings(capture_fps=240.0))
    assert kept.known(other) is None


def test_another_version_of_the_tool_makes_a_result_unknown(
    kept: ResultStore, job: Job, monkeypatch: pytest.MonkeyPatch
) -> None:
    keep(kept, job)
    monkeypatch.setattr(results, "tool_version", lambda: "another")
    assert kept.known(job) is None


def test_a_fresh_start_knows_nothing(kept: ResultStore, job: Job) -> None:
    keep(kept, job)
    assert replace(kept, fresh=True).known(job) is None


def test_a_result_that_was_tampered_with_is_unknown(kept: ResultStore, job: Job) -> None:
    result = keep(kept, job)
    text = json_line(result.result).replace("null", "0")
    (kept.outputs.folder / "trial.json").write_text(f"{text}\n", "utf-8")
    assert kept.known(job) is None


@pytest.mark.parametrize("damage", [None, "", "{", "[]", '{"clip": 1, "tool": 1}', "a swing"])
def test_a_result_of_which_it_is_lost_what_it_depends_on_is_unknown(
    kept: ResultStore, job: Job, damage: str | None
) -> None:
    """It is counted again, so that its pages can be drawn later without that."""
    answer = answer_to(job)
    kept.keep(job, answer)
    assert kept.known(job) == answer.result.followed
    place = kept.outputs.folder / HIDDEN / "trial.jsonl"
    place.unlink() if damage is None else place.write_text(damage)
    assert kept.known(job) is None
    kept.keep(job, answer)
    assert kept.known(job) == answer.result.followed


def test_what_was_kept_for_a_result_that_never_came_is_no_result(
    kept: ResultStore, job: Job, monkeypatch: pytest.MonkeyPatch
) -> None:
    replace_file = os.replace

    def power_cut(source: Path, target: Path) -> None:
        if target.parent == kept.outputs.folder:
            raise KeyboardInterrupt
        replace_file(source, target)

    monkeypatch.setattr(os, "replace", power_cut)
    with pytest.raises(KeyboardInterrupt):
        keep(kept, job)
    assert (kept.outputs.folder / HIDDEN / "trial.jsonl").exists()
    assert kept.known(job) is None


def test_a_moved_clip_is_known_under_its_new_path(kept: ResultStore, job: Job) -> None:
    keep(kept, job)
    moved = replace(job, clip=str(job.file.with_name("other.mp4")))
    job.file.rename(moved.file)
    found = kept.known(moved)
    assert found is not None
    result = found.result
    assert result.clip == moved.clip
    assert (kept.outputs.folder / "trial.json").read_text("utf-8") == f"{json_line(result)}\n"


def test_a_passing_failure_is_written_but_not_used_again(kept: ResultStore, job: Job) -> None:
    kept.keep(job, answer_to(job, final=False, reason="the worker died"))
    written = (kept.outputs.folder / "trial.json").read_text("utf-8")
    assert json.loads(written)["reason"] == "the worker died"
    assert kept.known(job) is None


def test_a_passing_failure_does_not_cost_a_good_result(kept: ResultStore, job: Job) -> None:
    result = keep(kept, job)
    kept.keep(job, answer_to(job, final=False))
    assert kept.known(job) == result


def test_one_process_at_a_time_has_the_folder(tmp_path: Path) -> None:
    first, second = (open_store(tmp_path / "results", fresh=False) for _ in range(2))
    with first, pytest.raises(UsageError, match="another run is at work"), second:
        pass
    with open_store(tmp_path / "results", fresh=False) as again:
        assert again.outputs.folder.is_dir()


def test_a_folder_that_cannot_be_made_is_reported(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    store_there = open_store(tmp_path / "file" / "results", fresh=False)
    with pytest.raises(UsageError, match="no folder for results"), store_there:
        pass


def test_the_version_differs_with_the_code(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    versions = set()
    for code in ("a = 1\n", "a = 2\n"):
        (tmp_path / "__init__.py").write_text(code)
        monkeypatch.setattr("count_video.__file__", str(tmp_path / "__init__.py"))
        executor.tool_version.cache_clear()
        versions.add(tool_version())
    executor.tool_version.cache_clear()
    assert len(versions) == 2

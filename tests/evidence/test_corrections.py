"""A person's corrections: read from a file, laid over a result, printed by the command."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest
from evidence_made import CLIP, Made

from count_video import cli, pipeline
from count_video.corrections import reviewed
from count_video.errors import UsageError
from count_video.records import TrialResult
from count_video.reports.text import result_text

Entry = dict[str, object]


@pytest.fixture
def result(made: Made) -> TrialResult:
    return made.result


@pytest.fixture
def counted_before(made: Made, monkeypatch: pytest.MonkeyPatch) -> None:
    """Spare the command the counting of the clip."""
    monkeypatch.setattr(pipeline, "work_through", lambda *_: made.trial)


def saved(folder: Path, *entries: Entry, **changes: object) -> Path:
    path = folder / "saved.json"
    content = {"corrections_version": 1, "clip": CLIP.name, "corrections": list(entries)}
    path.write_text(json.dumps(content | changes), "utf-8")
    return path


def wrong(result: TrialResult, number: int, *, off: float = 0.0) -> Entry:
    collision = result.collisions[number - 1]
    frame = collision.frame + off
    return {"action": "wrong", "kind": collision.kind, "frame": frame, "number": number}


def missed(frame: float, kind: str = "wall") -> Entry:
    return {"action": "missed", "kind": kind, "frame": frame, "number": None}


def test_nothing_changed_leaves_the_count(result: TrialResult, tmp_path: Path) -> None:
    review = reviewed(result, saved(tmp_path))
    assert (review.count, review.reviewed_count, review.corrections) == (12, 12, ())


def test_a_wrong_collision_is_taken_away_and_a_missed_one_added(
    result: TrialResult, tmp_path: Path
) -> None:
    changes = [wrong(result, 3), wrong(result, 4), missed(60.0)]
    review = reviewed(result, saved(tmp_path, *changes))
    assert (review.count, review.reviewed_count) == (12, 11)
    assert [c.number for c in review.corrections] == [3, 4, None]


def test_what_a_person_wrote_is_in_the_result_and_its_text(
    result: TrialResult, tmp_path: Path
) -> None:
    notes = {"": "a draught", "3/bodies/71.5": "grazed", "+/wall/60.0": "between two frames"}
    review = reviewed(result, saved(tmp_path, notes=notes))

    assert review.notes == notes
    words = " ".join(result_text(review).split())
    for on in ("on the clip: a draught", "no. 3: grazed", "missed in frame 60.0: between two"):
        assert on in words
    with pytest.raises(UsageError, match="notes"):
        reviewed(result, saved(tmp_path, notes={"": 5}))


def test_a_note_stays_on_its_collision_where_a_recount_moves_it(
    result: TrialResult, tmp_path: Path
) -> None:
    own = result.collisions[4]
    key = f"9/{own.kind}/{own.frame + 0.01}"
    review = reviewed(result, saved(tmp_path, notes={key: "grazed"}))
    assert list(review.notes.values()) == ["grazed"]
    number, kind, frame = next(iter(review.notes)).split("/")
    assert (number, kind) == ("5", own.kind)
    assert float(frame) == pytest.approx(own.frame, rel=1e-11)


def test_what_lies_after_the_burst_does_not_change_the_count(
    result: TrialResult, tmp_path: Path
) -> None:
    shorter = replace(result, count=10)
    last = result.collisions[-1]
    review = reviewed(shorter, saved(tmp_path, wrong(result, 12), missed(last.frame + 5)))
    assert review.reviewed_count == 10
    assert [c.changes_count for c in review.corrections] == [False, False]


def test_a_clip_that_was_not_counted_is_counted_by_the_person(
    result: TrialResult, tmp_path: Path
) -> None:
    doubtful = replace(result, status="not_counted", reason="too fast", count=None, seen=12)
    review = reviewed(doubtful, saved(tmp_path, missed(61.0)))
    assert (review.count, review.reviewed_count) == (None, 13)


def test_a_collision_is_found_again_where_the_tool_moved_it_a_little(
    result: TrialResult, tmp_path: Path
) -> None:
    entry = wrong(result, 5, off=0.4) | {"number": 77}
    assert reviewed(result, saved(tmp_path, entry)).corrections[0].number == 5


BAD = {
    "another clip": {"clip": "other.mp4"},
    "another version": {"corrections_version": 2},
    "no list": {"corrections": None},
    "an entry that is none": {"corrections": ["x"]},
    "an unknown action": {"corrections": [{"action": "x", "kind": "wall", "frame": 1}]},
    "an unknown kind": {"corrections": [{"action": "missed", "kind": "x", "frame": 1}]},
    "no frame": {"corrections": [{"action": "missed", "kind": "wall"}]},
    "a frame that is no number": {
        "corrections": [{"action": "missed", "kind": "wall", "frame": True}]
    },
    "a frame before the clip": {"corrections": [{"action": "missed", "kind": "wall", "frame": -1}]},
    "a collision that is not there": {
        "corrections": [{"action": "wrong", "kind": "wall", "frame": 9e9, "number": 1}]
    },
}


@pytest.mark.parametrize("changes", BAD.values(), ids=BAD.keys())
def test_a_file_that_does_not_fit_is_refused_in_one_line(
    result: TrialResult, tmp_path: Path, changes: dict[str, object]
) -> None:
    with pytest.raises(UsageError) as refusal:
        reviewed(result, saved(tmp_path, **changes))
    assert "\n" not in str(refusal.value)


def test_one_collision_is_not_wrong_twice(result: TrialResult, tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="twice"):
        reviewed(result, saved(tmp_path, wrong(result, 2), wrong(result, 2)))


@pytest.mark.parametrize("content", [b"", b"{", b"[" * 100_000, b"\xff\xfe", b"[]", b"null"])
def test_a_file_that_is_no_such_json_is_refused(
    result: TrialResult, tmp_path: Path, content: bytes
) -> None:
    path = tmp_path / "broken.json"
    path.write_bytes(content)
    with pytest.raises(UsageError):
        reviewed(result, path)
    with pytest.raises(UsageError):
        reviewed(result, tmp_path / "missing.json")


def test_the_text_has_the_reviewed_count_beside_the_tools_own(
    result: TrialResult, tmp_path: Path
) -> None:
    text = result_text(reviewed(result, saved(tmp_path, wrong(result, 3), missed(60.0, "bodies"))))
    assert text.splitlines()[0] == f"{CLIP.name}: 12 collisions, 12 after review"
    words = " ".join(text.split())
    assert "no. 3 between the bodies is wrong" in words
    assert "one between the bodies was missed (frame 60.0)" in words


@pytest.mark.usefixtures("counted_before")
def test_the_command_reports_the_review(
    result: TrialResult, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = saved(tmp_path, wrong(result, 3))
    assert cli.main([str(CLIP), "--json", "--corrections", str(path)]) == 0
    said = json.loads(capsys.readouterr().out)
    assert (said["count"], said["reviewed_count"]) == (12, 11)
    assert [entry["number"] for entry in said["corrections"]] == [3]


@pytest.mark.usefixtures("counted_before")
def test_the_command_refuses_corrections_of_another_clip(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = saved(tmp_path, clip="other.mp4")
    assert cli.main([str(CLIP), "--corrections", str(path)]) == 2
    assert "other.mp4" in capsys.readouterr().err

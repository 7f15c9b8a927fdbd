"""Files that this program writes: whole, on record, and never over a file of somebody else."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
import unicodedata
from pathlib import Path
from typing import get_args

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from count_video import outputs
from count_video.batch.manifest import clips_in, jobs_of
from count_video.errors import UsageError
from count_video.outputs import (
    HIDDEN,
    LONGEST_NAME_BYTES,
    OutputFolder,
    appearing,
    clear_unfinished,
    held,
    open_outputs,
    output_name,
    write_whole,
)
from count_video.pipeline import TrialSettings
from count_video.reports.panels import PANELS
from count_video.settings import PictureFormat

FILE_NAME_BYTES = 255
"""What file systems take."""
ANY_NAME = st.text(st.characters(exclude_characters="/\0"), min_size=1, max_size=300)
PATIENCE_S = 60
"""To open a file takes milliseconds; a pipe is waited for without end."""
HESITATES_S = 0.2
"""For the lock to be taken too early, if it can be."""
WRITER = """
import os, signal, sys
from pathlib import Path
from count_video.outputs import appearing
with appearing(Path(sys.argv[1])) as partial:
    partial.write_text("half")
    print("begun", flush=True)
    sys.stdin.read()
"""


@pytest.fixture
def folder(tmp_path: Path) -> OutputFolder:
    return open_outputs(tmp_path / "results")


def test_a_file_that_was_there_is_not_replaced(folder: OutputFolder) -> None:
    mine = folder.folder / "a.html"
    mine.write_text("mine")
    with pytest.raises(UsageError, match="not written by this program"):
        folder.write("a.html", b"theirs")
    assert mine.read_text() == "mine"


def test_a_file_that_this_program_wrote_is_replaced_by_any_later_run(folder: OutputFolder) -> None:
    folder.write("a.html", b"first", "digest")
    later = open_outputs(folder.folder)
    assert later.written() == {"a.html": "digest"}
    later.write("a.html", b"second", "other")
    assert (folder.folder / "a.html").read_bytes() == b"second"
    assert folder.written() == {"a.html": "other"}


@pytest.mark.parametrize("name", ["a.html", f"{HIDDEN}/written", f"{HIDDEN}/lock"])
def test_no_link_is_followed_out_of_the_folder(tmp_path: Path, name: str) -> None:
    victim = tmp_path / "victim"
    victim.write_text("precious")
    folder = open_outputs(tmp_path / "results")
    (folder.folder / name).symlink_to(victim)
    with pytest.raises((UsageError, OSError)), held(folder.hidden / "lock"):
        folder.write("a.html", b"data")
    assert victim.read_text() == "precious"


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs named pipes")
@pytest.mark.parametrize("name", ["written", "lock"])
def test_no_pipe_is_waited_for(name: str, folder: OutputFolder) -> None:
    def waits(*_: object) -> None:
        raise AssertionError("it waits for somebody at the pipe's other end")

    os.mkfifo(folder.hidden / name)
    before = signal.signal(signal.SIGALRM, waits)
    signal.alarm(PATIENCE_S)
    try:
        one_line = pytest.raises((UsageError, OSError), match=r"regular file|No such device")
        with one_line, held(folder.hidden / "lock"):
            folder.write("a.html", b"ours")
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def test_a_file_is_no_folder_for_results(tmp_path: Path) -> None:
    (tmp_path / "results").touch()
    with pytest.raises(UsageError, match=r"no folder for results .*; give another folder with -o"):
        open_outputs(tmp_path / "results")


def test_a_hidden_folder_that_is_a_link_is_refused(tmp_path: Path) -> None:
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "results").mkdir()
    (tmp_path / "results" / HIDDEN).symlink_to(tmp_path / "elsewhere")
    with pytest.raises(UsageError, match="no folder for results"):
        open_outputs(tmp_path / "results")


@given(st.binary(max_size=200), st.integers(0, 60))
def test_a_torn_record_costs_its_last_line_alone(
    tmp_path_factory: pytest.TempPathFactory, rubbish: bytes, cut: int
) -> None:
    folder = open_outputs(tmp_path_factory.mktemp("torn"))
    folder.claim("a.html", "first")
    record = folder.hidden / "written"
    whole = record.read_bytes()
    record.write_bytes(whole + rubbish.replace(b"\n", b"") + whole[:cut])
    folder.claim("b.html", "second")
    written = OutputFolder(folder.folder).written()
    assert written["a.html"] == "first"
    assert written["b.html"] == "second"


def test_a_failure_leaves_neither_half_a_file_nor_the_loss_of_the_old_one(tmp_path: Path) -> None:
    target = tmp_path / "a.mp4"
    write_whole(target, b"old")

    def fail_half_way() -> None:
        with appearing(target) as partial:
            partial.write_bytes(b"half")
            assert target.read_bytes() == b"old"
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail_half_way()
    assert [file.name for file in tmp_path.iterdir()] == ["a.mp4"]
    assert target.read_bytes() == b"old"


def test_who_comes_second_writes_after_the_first(tmp_path: Path) -> None:
    lock = tmp_path / "lock"
    written = []

    def second() -> None:
        with held(lock, wait=True):
            written.append("second")

    thread = threading.Thread(target=second)
    with held(lock, wait=True):
        thread.start()
        thread.join(HESITATES_S)
        written.append("first")
    thread.join()
    assert written == ["first", "second"]


def test_what_a_killed_process_left_is_cleared_and_what_is_in_the_making_is_not(
    tmp_path: Path,
) -> None:
    own = tmp_path / ".mine.part.mp4"
    own.write_text("a file of somebody else that is called alike")
    with subprocess.Popen(
        [sys.executable, "-c", WRITER, str(tmp_path / "a.annotated.mp4")],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
    ) as writer:
        assert writer.stdout is not None
        assert writer.stdout.readline() == b"begun\n"
        (partial,) = set(tmp_path.iterdir()) - {own}
        clear_unfinished(tmp_path)
        assert partial.exists(), "it is in the making"
        writer.send_signal(signal.SIGKILL)
        writer.wait()
    assert partial.exists()
    clear_unfinished(tmp_path)
    assert set(tmp_path.iterdir()) == {own}


@given(ANY_NAME)
@example("a\u2028b")
@example("\udcff latin")
@example("..")
@example("n" * 255)
@example("é" * 127)
def test_a_name_fits_every_table_link_and_file_system(wish: str) -> None:
    name = output_name(wish)
    assert 0 < len(name.encode("utf-8")) <= LONGEST_NAME_BYTES
    assert name.isprintable()
    assert not set(name) & set("/\\")
    assert not name.startswith(".")
    assert output_name(name) == name


def test_the_longest_ending_of_a_result_fits_as_well() -> None:
    endings = [f".{panel}.{kind}" for panel in PANELS for kind in get_args(PictureFormat)]
    endings += [".collisions.csv", ".presenter.mp4", ".annotated.mp4"]
    assert LONGEST_NAME_BYTES + max(map(len, endings)) == FILE_NAME_BYTES


@pytest.mark.parametrize("name", ["trial 7", "a.b.c", "é😀", "100:1 (2)", "a'b\"c", "n" * 238])
def test_an_ordinary_name_stays_as_it_is(name: str) -> None:
    assert output_name(name) == name


@given(st.lists(ANY_NAME | st.sampled_from(["a", "A", "é", "e\u0301", "a.mp4", "a-2"]), max_size=9))
def test_no_two_clips_share_the_name_of_a_result(names: list[str]) -> None:
    clips = [Path(f"clips {k}", f"{name}.mp4") for k, name in enumerate(names)]
    jobs = jobs_of(clips, TrialSettings())
    alike = {unicodedata.normalize("NFC", job.name).casefold() for job in jobs}
    assert len(alike) == len(names)
    assert "campaign" not in alike


def test_what_this_program_wrote_beside_clips_is_no_clip(folder: OutputFolder) -> None:
    (folder.folder / "foo.mp4").write_bytes(b"a clip")
    (folder.folder / "bar.annotated.mp4").write_bytes(b"a clip of this name")
    folder.write("foo.annotated.mp4", b"ours")
    assert [clip.name for clip in clips_in(folder.folder)] == ["bar.annotated.mp4", "foo.mp4"]


def test_the_evidence_of_another_clip_is_distinguished_from_this_ones(
    folder: OutputFolder,
) -> None:
    clip = folder.folder.parent / "trial.mp4"
    clip.write_bytes(b"a clip")
    assert not folder.shows_another_clip("trial.html", clip)
    folder.write("trial.html", b"page", "digest of another")
    assert folder.shows_another_clip("trial.html", clip)


def test_a_record_without_end_is_read_to_its_limit(
    folder: OutputFolder, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("first.html", "last.html"):
        folder.write(name, b"ours", "digest")
    record = folder.hidden / "written"
    monkeypatch.setattr(outputs, "_MOST_RECORD_BYTES", record.stat().st_size - 1)
    later = OutputFolder(folder.folder)
    assert set(later.written()) == {"first.html"}
    with pytest.raises(UsageError, match="not written by this program"):
        later.write("last.html", b"theirs")
    assert set(later.written()) == {"first.html"}, "a second time reads no further"


def test_a_record_of_another_kind_of_file_is_none(folder: OutputFolder) -> None:
    os.mkfifo(folder.hidden / "written")
    assert folder.written() == {}


def test_the_record_is_one_json_object_a_line(folder: OutputFolder) -> None:
    folder.claim("a\udcff\n.html", "digest")
    lines = (folder.hidden / "written").read_text("ascii").split("\n")
    assert [json.loads(line) for line in lines if line] == [
        {"name": "a\udcff\n.html", "clip": "digest"}
    ]

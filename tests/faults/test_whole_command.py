"""Whatever comes in, the whole command gives one clear answer: a quick part, and the rest slow."""

from __future__ import annotations

import base64
import json
import os
import shutil
import signal
import subprocess
import time
from pathlib import Path

import numpy as np
import pytest
from command import ENDINGS, MOST_BYTES, ask, faults_of, start, unfinished
from mutations import mutated
from readers import READERS

import count_video
from count_video.video.reader import open_footage
from count_video.video.writer import WriteOptions, write_clip

FIXTURES = Path(__file__).parents[2] / "fixtures"
COUNTS_3 = FIXTURES / "ratio1-count3.mp4"
COUNTS_12 = FIXTURES / "ratio16-count12.mp4"
CORPUS = Path(__file__).with_name("corpus")
POLL_S = 0.01
SLOW = pytest.mark.slow

ODD_REQUESTS = (
    ["--start=--", COUNTS_3],
    ["--capture-fps=1e308", COUNTS_3],
    ["--region=0,0,1,1", COUNTS_3],
    ["--masses", "1e99", "1e-99", COUNTS_3],
    ["--end", "9" * 6000, COUNTS_3],
    ["-o", "", COUNTS_3],
    [""],
    ["--scheduler=", COUNTS_3],
    ["--plan", "1e99", "1e-99"],
    ["--plan", "100", "1", "--gap", "1e-300"],
    ["--plan", "100", "1", "--thread=--"],
    ["--plan-file", "", COUNTS_3],
)


@pytest.mark.parametrize("arguments", ODD_REQUESTS, ids=range(len(ODD_REQUESTS)))
def test_an_odd_request_is_one_line_and_exit_code_2(arguments: list[object]) -> None:
    answer = ask("--json", *arguments)
    assert faults_of(answer, 1) == []
    assert (answer.code, answer.out, answer.err.count("\n")) == (2, "", 1)


def test_a_part_that_cannot_be_loaded_is_one_line(tmp_path: Path) -> None:
    """Files of the user's own that are called like a library come before it."""
    (tmp_path / "numpy.py").write_text("import no_such_module_anywhere")
    places = os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")])
    answer = ask("--json", COUNTS_3, environment={"PYTHONPATH": places})
    assert faults_of(answer, 1) == []
    assert (answer.code, answer.out) == (2, "")
    assert "no_such_module_anywhere" in answer.err


def picture_drawn_in(folder: Path, settings: bytes) -> bytes:
    """Draw a theory where matplotlib finds settings; return the picture, or else the complaint."""
    folder.mkdir()
    (folder / "matplotlibrc").write_bytes(settings)
    places = {"PYTHONPATH": str(Path(count_video.__file__).parents[1])}
    answer = ask("--theory", "1", "1", "-o", folder, cwd=folder, environment=places)
    assert faults_of(answer) == []
    return (folder / "theory.png").read_bytes() if answer.code == 0 else answer.err.encode()


def test_settings_of_matplotlib_that_lie_about_change_no_picture(tmp_path: Path) -> None:
    plain = picture_drawn_in(tmp_path / "plain", b"")
    other = picture_drawn_in(tmp_path / "other", b"text.usetex: True\naxes.facecolor: red\n")
    assert plain == other
    assert b"matplotlibrc" in picture_drawn_in(tmp_path / "no text", b"\xff")


@pytest.mark.parametrize("kept", sorted(CORPUS.glob("m[pko][4v]*")), ids=lambda kept: kept.name)
def test_a_clip_that_once_failed_is_one_object(kept: Path) -> None:
    assert faults_of(ask("--json", kept), 1) == []


@pytest.mark.parametrize(
    "closed", [(1,), (2,), *(pytest.param(more, marks=SLOW) for more in ((0,), (1, 2), (0, 1, 2)))]
)
def test_closed_streams_get_nothing_and_disturb_nothing(
    closed: tuple[int, ...], tmp_path: Path
) -> None:
    answer = ask("--json", tmp_path / "missing.mp4", closed=closed)
    assert answer.code == 1
    objects = [json.loads(line) for line in answer.out.splitlines()]
    assert len(objects) == (1 not in closed)
    assert answer.err.count("count-video: ") == (2 not in closed)
    assert answer.err.count("\n") == (2 not in closed)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is always full")
@pytest.mark.parametrize("arguments", [["--help"], ["--version"], ["--theory", "1", "1"]])
def test_what_cannot_be_written_is_named(arguments: list[str]) -> None:
    with open("/dev/full", "w") as full:
        answer = ask(*arguments, stdout=full)
    assert answer.code == 1
    assert answer.err == "count-video: cannot write what was asked for: No space left on device\n"


@pytest.mark.parametrize(
    "ending", [ENDINGS[0], *(pytest.param(ending, marks=SLOW) for ending in ENDINGS[1:])]
)
def test_a_signal_ends_the_writing_of_evidence_with_its_own_code(
    ending: signal.Signals, tmp_path: Path
) -> None:
    def end(process: subprocess.Popen[bytes]) -> None:
        while process.poll() is None and not unfinished(tmp_path):
            time.sleep(POLL_S)
        process.send_signal(ending)

    answer = ask(COUNTS_3, "-o", tmp_path, during=end)
    assert answer.code == 128 + ending
    assert answer.err.startswith("count-video: ")
    assert answer.err.count("\n") == 1
    assert unfinished(tmp_path) == []


@SLOW
def test_a_kill_leaves_nothing_for_ever(tmp_path: Path) -> None:
    for number in range(5):

        def kill(process: subprocess.Popen[bytes], pause: float = 0.03 * number) -> None:
            while process.poll() is None and not unfinished(tmp_path):
                time.sleep(POLL_S)
            time.sleep(pause)
            process.kill()

        assert ask(COUNTS_3, "-o", tmp_path, during=kill).code == -signal.SIGKILL
    answer = ask(COUNTS_3, "-o", tmp_path)
    assert (answer.code, answer.err) == (0, "")
    assert unfinished(tmp_path) == []


@SLOW
def test_the_evidence_of_another_clip_of_the_name_is_replaced_with_a_word(tmp_path: Path) -> None:
    for folder, name in (("one", "ratio1-count3"), ("two", "ratio16-count12")):
        (tmp_path / folder).mkdir()
        shutil.copy(FIXTURES / f"{name}.mp4", tmp_path / folder / "trial.mp4")
    results = tmp_path / "results"
    assert ask(tmp_path / "one" / "trial.mp4", "-o", results).err == ""
    answer = ask(tmp_path / "two" / "trial.mp4", "-o", results)
    assert (answer.code, answer.err.count("\n")) == (0, 1)
    assert "replaced the evidence of another clip" in answer.err


@pytest.fixture(scope="module")
def small_clip(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """A clip of three collisions, half as large as the fixture and quick to count."""
    path = tmp_path_factory.mktemp("small") / "clip.mp4"
    with open_footage(COUNTS_3) as footage:
        halves = (np.ascontiguousarray(frame.luma[::2, ::2]) for frame in footage.frames())
        write_clip(path, halves, WriteOptions(crf=15))
    return path.read_bytes()


@SLOW
@pytest.mark.parametrize("seed", range(60))
def test_a_damaged_clip_is_one_object_and_never_surely_wrong(
    small_clip: bytes, seed: int, tmp_path: Path
) -> None:
    clip = tmp_path / "clip.mp4"
    clip.write_bytes(mutated(small_clip, seed))
    answer = ask("--json", clip)
    assert faults_of(answer, 1) == []
    objects = json.loads(answer.out)
    assert objects["count"] in (None, 3) or objects["probability"][str(objects["count"])] < 0.9


KINDS = ("black", "noise", "still noise", "flashes", "flashing noise", "pan")
KINDS += ("one frame", "two frames", "16 px")


def _frames(kind: str) -> list[np.ndarray]:
    rng = np.random.default_rng(3)
    noise = rng.integers(0, 255, (90, 160), np.uint8)
    return {
        "black": [np.zeros((90, 160), np.uint8)] * 90,
        "noise": [rng.integers(0, 255, (90, 160), np.uint8) for _ in range(90)],
        "still noise": [noise] * 90,
        "flashes": [np.full((90, 160), 255 * (k % 2), np.uint8) for k in range(90)],
        "flashing noise": [noise if k % 2 else np.zeros_like(noise) for k in range(90)],
        "pan": [np.roll(noise, 2 * k, axis=1) for k in range(90)],
        "one frame": [noise],
        "two frames": [noise, noise[::-1].copy()],
        "16 px": [noise[:16, :16] // 4 * (k % 4) for k in range(60)],
    }[kind]


@SLOW
@pytest.mark.parametrize("kind", KINDS)
def test_a_clip_that_shows_no_trial_is_refused(kind: str, tmp_path: Path) -> None:
    clip = tmp_path / "clip.mp4"
    write_clip(clip, _frames(kind))
    answer = ask("--json", clip)
    assert faults_of(answer, 1) == []
    assert answer.code == 1


@SLOW
def test_pictures_of_the_largest_size_take_less_than_a_gigabyte(tmp_path: Path) -> None:
    clip = tmp_path / "clip.mp4"
    picture = np.full((4320, 4096), 90, np.uint8)
    write_clip(clip, (picture + np.uint8(k) for k in range(20)), WriteOptions(preset="ultrafast"))
    answer = ask("--json", clip)
    assert faults_of(answer, 1) == []
    assert answer.most_bytes < MOST_BYTES


@SLOW
@pytest.mark.parametrize(
    "name", [name for name in READERS if name in ("mov", "mkv", "avi", "webm")]
)
def test_every_container_cut_anywhere_is_one_object(name: str, tmp_path: Path) -> None:
    clip = tmp_path / READERS[name].file
    READERS[name].sound(clip)
    whole = clip.read_bytes()
    for share in (0.02, 0.2, 0.5, 0.8, 0.98):
        clip.write_bytes(whole[: int(share * len(whole))])
        assert faults_of(ask("--json", clip), 1) == []


ODD_SURROUNDINGS = (
    {"COUNT_VIDEO_THREADS": "9" * 5000},
    {"COUNT_VIDEO_THREADS": "0"},
    {"COUNT_VIDEO_THREADS": "2000"},
    {"HOME": "/nonexistent", "TMPDIR": "/nonexistent"},
    {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"},
    {"PYTHONIOENCODING": "ascii:strict"},
    {"COLUMNS": "1", "TERM": "dumb", "MPLBACKEND": "TkAgg"},
)


@SLOW
@pytest.mark.parametrize("environment", ODD_SURROUNDINGS, ids=range(len(ODD_SURROUNDINGS)))
def test_odd_surroundings_are_named_or_make_no_difference(
    environment: dict[str, str], tmp_path: Path
) -> None:
    clip = tmp_path / "é😀.mp4"
    shutil.copy(COUNTS_3, clip)
    answer = ask("--json", clip, environment=environment)
    assert faults_of(answer, 1) == []
    assert "COUNT_VIDEO_THREADS" in answer.err or answer.code == 0


@SLOW
@pytest.mark.parametrize("address", ["tls://127.0.0.1:1", "127.0.0.1:1"])
def test_an_address_at_which_nobody_answers_is_one_line(address: str) -> None:
    pytest.importorskip("distributed")
    answer = ask("--json", f"--scheduler={address}", COUNTS_3)
    assert faults_of(answer, 1) == []
    assert (answer.code, answer.err.count("\n")) == (2, 1)


@SLOW
def test_a_campaign_of_hostile_names_has_a_row_and_a_page_for_each(tmp_path: Path) -> None:
    clips, results = os.fsencode(tmp_path / "clips"), tmp_path / "results"
    os.mkdir(clips)
    names = [
        *(b"<img src=x onerror=alert(1)>", b"a\nb", b"a\x1b[2Jb", b"=1+1", b"-o", b"@x", b"%00"),
        *(b"\xff\xfe latin \xe9", b"n" * 251, "a\u2028b".encode(), "a\u0085b".encode(), b"a\\b"),
        *("é".encode(), "e\u0301".encode(), b"A", b"a", b"campaign", b"a.track", b"img%03d"),
    ]
    for name in names:
        with open(clips + b"/" + name + b".mp4", "wb") as file:
            file.write(b"no clip")
    answer = ask("--json", tmp_path / "clips", "-o", results, "--pages")
    assert (answer.code, faults_of(answer)) == (1, [])
    assert len(answer.out.splitlines()) == len(names)
    assert len((results / "trials.csv").read_text("utf-8").splitlines()) == 1 + len(names)
    kept = {file.name.casefold() for file in results.glob("*.json")}
    assert len(kept) == len(names) + 1, "a result a clip, and the summary"


@SLOW
def test_two_clips_of_one_name_at_the_same_time_leave_the_files_of_one(tmp_path: Path) -> None:
    clips = []
    for clip in (COUNTS_3, COUNTS_12):
        (tmp_path / clip.stem).mkdir()
        clips.append(shutil.copy(clip, tmp_path / clip.stem / "trial.mp4"))
    out = tmp_path / "out"
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    both = [start(clip, "-o", out, **quiet) for clip in clips]
    assert [process.wait() for process in both] == [0, 0]
    count = json.loads((out / "trial.json").read_text("utf-8"))["count"]
    assert count in (3, 12)
    assert len((out / "trial.collisions.csv").read_text("utf-8").splitlines()) == 1 + count
    page = (out / "trial.html").read_text("utf-8")
    assert f"<h1>{count} collisions" in page
    video = base64.b64encode((out / "trial.annotated.mp4").read_bytes()).decode("ascii")
    assert video in page

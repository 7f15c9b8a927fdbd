"""Files in which nothing can be counted, given to the whole command."""

from __future__ import annotations

import io
import json
import wave
from collections.abc import Callable
from contextlib import redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from count_video.cli import main
from count_video.video.writer import WriteOptions, write_clip

FRAMES = 60
SHAPE = (120, 320)


def missing(path: Path) -> None:
    assert not path.exists()


def empty(path: Path) -> None:
    path.touch()


def text(path: Path) -> None:
    path.write_text("31 collisions were counted.\n" * 200, "utf-8")


def random_bytes(path: Path) -> None:
    path.write_bytes(np.random.default_rng(1).bytes(20_000))


def audio_only(path: Path) -> None:
    with path.open("wb") as file, wave.open(file) as sound:
        sound.setnchannels(1)
        sound.setsampwidth(2)
        sound.setframerate(8000)
        sound.writeframes(bytes(16_000))


def picture(path: Path) -> None:
    encoded, data = cv2.imencode(".png", scenery())
    assert encoded
    path.write_bytes(data.tobytes())


def nothing_moves(path: Path) -> None:
    write_clip(path, [scenery()] * FRAMES, WriteOptions())


def only_noise_moves(path: Path) -> None:
    rng = np.random.default_rng(2)
    noisy = (scenery() + rng.normal(0, 4, SHAPE) for _ in range(FRAMES))
    write_clip(path, (np.clip(frame, 0, 255).astype(np.uint8) for frame in noisy), WriteOptions())


def cut_in_the_middle(path: Path) -> None:
    only_noise_moves(path)
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def scenery() -> np.ndarray:
    """Draw something to see that does not move: a ramp with a disc on it."""
    rows, columns = np.indices(SHAPE)
    ramp = 60 + columns * 100 // SHAPE[1]
    disc = (rows - 60) ** 2 + (columns - 160) ** 2 < 400
    return np.where(disc, 220, ramp).astype(np.uint8)


UNREADABLE = (missing, empty, text, random_bytes, audio_only)
NOTHING_TO_COUNT = (picture, nothing_moves, only_noise_moves)
EVERY_BAD_CLIP = (*UNREADABLE, *NOTHING_TO_COUNT, cut_in_the_middle)


@pytest.mark.parametrize("make", [*UNREADABLE, *NOTHING_TO_COUNT], ids=lambda make: make.__name__)
def test_a_bad_clip_is_one_clear_line_and_exit_code_1(
    make: Callable[[Path], None], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    clip = tmp_path / "trial.mp4"
    make(clip)
    assert main([str(clip)]) == 1
    out, err = capsys.readouterr()
    assert err.startswith(f"count-video: {clip}: ")
    assert err.count("\n") == 1
    if make in UNREADABLE:
        assert out == ""
    else:
        head, _, *notes = out.splitlines()
        assert head == "trial.mp4: not counted"
        labels = [line[2:15].strip() for line in notes]
        assert [*filter(None, labels)] == ["Why", "What to do", "Footage"]


@dataclass(frozen=True)
class Said:
    """What the command says of a folder with every bad clip in it."""

    code: int
    answers: dict[str, dict[str, Any]]
    """The object of each clip, by the clip's name."""
    unchanged: bool
    """Whether the folder was left as it was."""


@pytest.fixture(scope="module")
def said(tmp_path_factory: pytest.TempPathFactory) -> Said:
    folder = tmp_path_factory.mktemp("bad")
    for make in EVERY_BAD_CLIP:
        make(folder / f"{make.__name__}.mp4")
    before = {file: file.read_bytes() for file in folder.iterdir()}
    out = io.StringIO()
    with redirect_stdout(out):
        code = main(["--json", str(folder), str(folder / "missing.mp4")])
    answers = [json.loads(line) for line in out.getvalue().splitlines()]
    unchanged = {file: file.read_bytes() for file in folder.iterdir()} == before
    return Said(code, {Path(one["clip"]).stem: one for one in answers}, unchanged)


@pytest.mark.parametrize("make", EVERY_BAD_CLIP, ids=lambda make: make.__name__)
def test_a_bad_clip_is_one_object_with_its_reason(make: Callable[[Path], None], said: Said) -> None:
    answer = said.answers[make.__name__]
    assert (answer["status"], answer["count"]) == ("not_counted", None)
    assert len(answer["reason"]) > 10
    assert answer["collisions"] == []


def test_bad_clips_leave_their_folder_as_it_was_and_each_has_its_answer(said: Said) -> None:
    assert said.code == 1
    assert said.unchanged
    assert len(said.answers) == len(EVERY_BAD_CLIP)


def test_a_cut_clip_says_how_much_of_it_is_missing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    clip = tmp_path / "trial.mp4"
    cut_in_the_middle(clip)
    assert main(["--json", str(clip)]) == 1
    answer = json.loads(capsys.readouterr().out)
    assert answer["frames_promised"] == FRAMES
    assert 0 < answer["frames_decoded"] < FRAMES
    assert main([str(clip)]) == 1
    out, err = capsys.readouterr()
    assert str(FRAMES) in out
    assert str(answer["frames_decoded"]) in out
    assert err.count("\n") == 1

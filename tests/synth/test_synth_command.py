from __future__ import annotations

import json
from pathlib import Path

import pytest

from synth_video import cli
from synth_video.cli import main
from synth_video.scene_file import load_scene, scene_names

SMALL = ["--set", "camera.width_px=160", "--set", "camera.height_px=64", "--set", "clip.frames=4"]


def test_the_command_writes_a_clip_and_its_truth(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    clip = tmp_path / "trial.mp4"
    wish = [str(clip), "--scene", "gap5-29", "--seed", "7", "--set", "camera.capture_fps=1500"]
    assert main([*wish, *SMALL]) == 0
    assert sorted(p.name for p in tmp_path.iterdir()) == ["trial.mp4", "trial.truth.json"]
    truth = json.loads((tmp_path / "trial.truth.json").read_text(encoding="utf-8"))
    assert (truth["seed"], truth["capture_fps"]) == (7, 1500.0)
    printed = capsys.readouterr()
    assert f"4 frames, {truth['count']} collisions" in printed.out
    assert not printed.err


def test_the_list_names_every_scene_with_its_sentence(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--list"]) == 0
    out = capsys.readouterr().out
    listed = " ".join(f"{name} {load_scene(name).purpose}" for name in scene_names())
    assert out.split() == listed.split()
    assert max(map(len, out.splitlines())) <= 80


def test_help_explains_every_option(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--help"]) == 0
    printed = capsys.readouterr().out
    assert all(
        option in printed for option in ("--scene", "--seed", "--set", "--vary", "--list", "clip")
    )


@pytest.mark.parametrize(
    "arguments",
    [
        [],
        ["--scene", "moon"],
        ["--seed", "-1"],
        ["--seed", "many"],
        ["--set", "camera.tilt_deg=20"],
        ["--set", "camera.tilt_deg"],
        ["--set", "encoding.codec=nonsense"],
        ["--set", "view.width_m=0.001"],
        ["--frobnicate"],
    ],
)
def test_a_wrong_request_ends_with_two_and_leaves_no_file(
    arguments: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    clip = [str(tmp_path / "clip.mp4")] if arguments else []
    assert main([*clip, *arguments]) == 2
    printed = capsys.readouterr()
    assert printed.err.startswith("synth-video: ")
    assert printed.err.count("\n") == 1
    assert not printed.out
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("setting", ["camera.tilt=20", "encoding.codec=nonsense"])
def test_a_refused_setting_is_said_in_one_line(
    setting: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([str(tmp_path / "clip.mp4"), *SMALL, "--set", setting]) == 2
    printed = capsys.readouterr().err
    assert printed.count("\n") == 1
    assert printed.startswith("synth-video: ")


def test_an_interruption_is_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(cli, "render_clip", interrupted)
    assert main([str(tmp_path / "clip.mp4"), *SMALL]) == 130
    assert capsys.readouterr() == ("", "synth-video: interrupted\n")


def test_a_folder_that_is_not_there_is_said_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([str(tmp_path / "none" / "clip.mp4"), *SMALL]) == 2
    assert capsys.readouterr().err.count("\n") == 1


@pytest.mark.parametrize(
    "there",
    [
        {"trial.mp4": "a film"},
        {"trial.truth.json": "notes"},
        {"trial.mp4": "a film", "trial.truth.json": '{"count": 3}'},
    ],
)
def test_files_of_somebody_else_stay(
    there: dict[str, str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name, text in there.items():
        (tmp_path / name).write_text(text, "utf-8")
    assert main([str(tmp_path / "trial.mp4"), "--scene", "equal-masses", *SMALL]) == 2
    assert "no clip of this program" in capsys.readouterr().err
    assert {one.name: one.read_text("utf-8") for one in tmp_path.iterdir()} == there


def test_a_clip_may_be_rendered_again_but_no_other_of_its_name(tmp_path: Path) -> None:
    wish = ["--scene", "equal-masses", *SMALL]
    assert main([str(tmp_path / "trial.mp4"), *wish]) == 0
    assert main([str(tmp_path / "trial.mp4"), *wish, "--seed", "3"]) == 0
    assert json.loads((tmp_path / "trial.truth.json").read_text("utf-8"))["seed"] == 3
    assert main([str(tmp_path / "trial.mkv"), *wish]) == 2

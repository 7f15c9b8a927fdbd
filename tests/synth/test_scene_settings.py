from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest

from count_video.errors import UsageError
from synth_video.scene import Scene
from synth_video.scene_file import load_scene, scene_names


@pytest.mark.parametrize("name", scene_names())
def test_every_scene_loads_and_says_what_it_is_for(name: str) -> None:
    scene = load_scene(name)
    assert scene.name == name
    assert len(scene.purpose.split()) >= 6
    assert scene.purpose.endswith(".")


def test_scenes_differ_from_one_another() -> None:
    scenes = {repr(dataclasses.replace(load_scene(n), name="", purpose="")) for n in scene_names()}
    assert len(scenes) == len(scene_names())


@pytest.mark.parametrize(
    ("override", "section", "key", "value"),
    [
        ("camera.capture_fps=2000", "camera", "capture_fps", 2000.0),
        ("camera.capture_fps = 2e3", "camera", "capture_fps", 2000.0),
        ("camera.width_px=800", "camera", "width_px", 800),
        ("view.rising_path=false", "view", "rising_path", False),
        ("wall.side=right", "wall", "side", "right"),
        ('wall.side="right"', "wall", "side", "right"),
        ("ball.color=[1, 2, 3]", "ball", "color", (1, 2, 3)),
        ("ball.mark=", "ball", "mark", ""),
        ("encoding.codec=libx265", "encoding", "codec", "libx265"),
        ("setup.wall_gap_m=0.03", "setup", "wall_gap_m", 0.03),
        ("setup.mounting=suspended", "setup", "mounting", "suspended"),
    ],
)
def test_a_setting_takes_effect_in_its_own_type(
    override: str, section: str, key: str, value: object
) -> None:
    found = getattr(getattr(load_scene("paper", [override]), section), key)
    assert found == value
    assert type(found) is type(value)


def test_the_last_of_two_settings_holds() -> None:
    scene = load_scene("paper", ["camera.tilt_deg=1", "camera.tilt_deg=2"])
    assert scene.camera.tilt_deg == 2


@pytest.mark.parametrize(
    ("override", "complaint"),
    [
        ("camera", "section.key=value"),
        ("camera.tilt_deg", "section.key=value"),
        ("tilt=3", "section.key=value"),
        ("kamera.tilt_deg=3", "no section 'kamera'"),
        ("purpose.x=3", "'purpose' is no section"),
        ("camera.tilt=3", "no setting camera.tilt; camera has: width_px"),
        ("camera.tilt_deg=steep", "camera.tilt_deg must be a number, not 'steep'"),
        ("camera.tilt_deg=9", "camera.tilt_deg must lie between -8 and 8"),
        ("camera.tilt_deg=nan", "must be a finite number"),
        ("camera.width_px=640.5", "must be a whole number"),
        ("camera.width_px=641", "must be even"),
        ("camera.width_px=true", "must be a whole number"),
        ("camera.shutter=0", "camera.shutter must be above 0"),
        ("wall.side=up", "must be one of left, right"),
        ("ball.color=orange", "must be a colour"),
        ("ball.color=[1, 2]", "must be a colour"),
        ("ball.color=[1, 2, 256]", "must be a colour"),
        ("view.rising_path=1", "must be true or false"),
        ("setup.restitution_wall=1.2", "restitution_wall"),
        ("setup.heavy_mass_kg=0", "heavy_mass_kg"),
    ],
)
def test_a_wrong_setting_is_refused_in_one_line_that_names_it(
    override: str, complaint: str
) -> None:
    with pytest.raises(UsageError) as refusal:
        load_scene("paper", [override])
    assert complaint in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_an_unknown_scene_is_refused_with_the_names_there_are() -> None:
    with pytest.raises(UsageError, match=r"no scene 'moon'; there are: .*paper"):
        load_scene("moon")


def test_a_scene_is_read_from_a_file_of_ones_own(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text('purpose = "Mine."\n[view]\nwidth_m = 0.5\n', encoding="utf-8")
    scene = load_scene(str(file))
    assert (scene.name, scene.purpose, scene.view.width_m) == ("mine", "Mine.", 0.5)


@pytest.mark.parametrize("content", [b"view = 3\n", b"[view\n", b"\xff\xfe", b"colour = 'red'\n"])
def test_a_scene_file_that_is_none_is_refused(tmp_path: Path, content: bytes) -> None:
    file = tmp_path / "broken.toml"
    file.write_bytes(content)
    with pytest.raises(UsageError):
        load_scene(str(file))


def test_a_scene_file_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"gone\.toml"):
        load_scene(str(tmp_path / "gone.toml"))


def test_a_scene_without_a_file_is_whole() -> None:
    assert Scene().camera.width_px > 0

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from filming import NOISELESS, filmed, small_scene

from count_video.video.reader import open_footage
from synth_video.film import render_clip
from synth_video.scene_file import load_scene, scene_names
from synth_video.truth import truth_path
from tiers import rest_slow


def scenes_by_kind() -> list[str]:
    """All scenes, one of each kind of experiment first."""
    kinds = {name: load_scene(name).experiment.kind for name in scene_names()}
    first = {kind: name for name, kind in reversed(kinds.items())}
    return sorted(kinds, key=lambda name: first[kinds[name]] != name)


KINDS = len({load_scene(name).experiment.kind for name in scene_names()})


@pytest.mark.parametrize("name", rest_slow(scenes_by_kind(), quick=KINDS))
def test_every_scene_makes_a_clip_in_which_something_moves(name: str, tmp_path: Path) -> None:
    short = ["clip.frames=12", "camera.capture_fps=240"]
    scene = load_scene(name, short)
    if scene.experiment.kind == "pi":
        scene = small_scene(name, *short)
    render_clip(scene, 1, tmp_path / "clip.mp4")
    with open_footage(tmp_path / "clip.mp4") as footage:
        luma = [frame.luma.astype(int) for frame in footage.frames()]
    assert len(luma) == 12
    assert luma[0].shape == (scene.camera.height_px, scene.camera.width_px)
    assert luma[0].std() > 3  # not blank
    assert np.abs(luma[-1] - luma[0]).max() > 8 * scene.camera.read_noise


def test_the_same_seed_gives_the_same_bytes_and_another_seed_others(tmp_path: Path) -> None:
    scene = small_scene("shelf", "clip.frames=6")
    for name, seed in (("one", 5), ("two", 5), ("other", 6)):
        render_clip(scene, seed, tmp_path / f"{name}.mp4")
    one, two, other = (
        ((tmp_path / f"{n}.mp4").read_bytes(), (tmp_path / f"{n}.truth.json").read_bytes())
        for n in ("one", "two", "other")
    )
    assert one == two
    assert one[0] != other[0]
    assert one[1] != other[1]


def test_the_clip_has_as_many_frames_as_the_truth_and_its_own_playing_rate(tmp_path: Path) -> None:
    scene = small_scene("equal-masses", "encoding.container_fps=24", "clip.tail_frames=5")
    clip = tmp_path / "clip.mp4"
    render_clip(scene, 1, clip)
    truth = json.loads(truth_path(clip).read_text(encoding="utf-8"))
    with open_footage(clip) as footage:
        frames = sum(1 for _ in footage.frames())
        assert footage.info.container_fps == pytest.approx(24)
    assert frames == len(truth["frames"])
    assert truth["events"][-1]["frame"] < frames
    assert truth["capture_fps"] == 240


@pytest.mark.parametrize(("suffix", "codec"), [(".mkv", "libx265"), (".avi", "mjpeg")])
def test_other_containers_and_codecs_can_be_asked_for(
    tmp_path: Path, suffix: str, codec: str
) -> None:
    scene = small_scene("equal-masses", "clip.frames=4", f"encoding.codec={codec}")
    clip = tmp_path / f"clip{suffix}"
    render_clip(scene, 1, clip)
    with open_footage(clip) as footage:
        assert len(list(footage.frames())) == 4


def test_a_wall_on_the_right_gives_the_mirror_image() -> None:
    still = (*NOISELESS, "clip.frames=5")
    _, _, left = filmed(small_scene("shelf", *still, "camera.tilt_deg=5"))
    _, _, right = filmed(small_scene("shelf", *still, "camera.tilt_deg=-5", "wall.side=right"))
    assert all(np.array_equal(a, b[:, ::-1]) for a, b in zip(left, right, strict=True))


def test_what_does_not_move_stays_the_same_to_the_bit() -> None:
    _, _, frames = filmed(small_scene("shelf", *NOISELESS, "clip.frames=6"))
    still = np.ptp(np.stack(frames), axis=0).max(axis=2) == 0
    # Bodies, threads and shadows fill the middle of the picture; the rest is shelf.
    assert still[:, 250:].all()
    assert still[:, :60].all()
    assert not still.all()


def test_a_picture_depends_on_its_own_moment_only() -> None:
    whole = small_scene("ratio16", *NOISELESS, "clip.frames=40")
    _, _, frames = filmed(whole)
    _, _, first = filmed(small_scene("ratio16", *NOISELESS, "clip.frames=41"))
    assert all(np.array_equal(a, b) for a, b in zip(frames, first, strict=False))


def test_the_wall_is_painted_where_the_truth_has_it() -> None:
    overrides = ("ball.ring=false", "wall.edge=1", "wall.opacity=0", "background.texture=0")
    plain = ("background.blur_m=0", "camera.blur_px=0", "wall.front_m=0", "wall.reflection=0")
    scene = small_scene("paper", *NOISELESS, *overrides, *plain, "clip.frames=1")
    _, _, frames = filmed(scene)
    row = frames[0][30, :, 0].astype(float)
    wall_x = scene.view.wall_m / scene.view.width_m * 320 - 0.5
    bare = row[round(wall_x) + 4]
    dark = np.clip(bare - row[round(wall_x) - 3 : round(wall_x) + 4], 0, None)
    place = np.arange(round(wall_x) - 3, round(wall_x) + 4)
    # The plate's dark face is 0.7 mm wide and ends at the wall: its middle lies half that inside.
    middle = wall_x - 0.00035 * 320 / scene.view.width_m
    assert (dark * place).sum() / dark.sum() == pytest.approx(middle, abs=0.15)

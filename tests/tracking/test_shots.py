"""Clips that are cut: the longest shot is counted, and what belongs together is not parted."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest
from drawn import Luma, texture

import count_video
from count_video.tracking.shots import Shots
from count_video.video.reader import open_footage
from count_video.video.writer import WriteOptions, write_clip

FIXTURES = Path(__file__).parents[2] / "fixtures"
TRIAL = FIXTURES / "ratio16-count12.mp4"
SIZE = (96, 256)
TIME_FRAMES = 0.25
"""A tenth of the interval from which on collisions are resolved."""


def scene(seed: int, count: int, step_px: int = 3, block: int = 12) -> list[Luma]:
    """Pictures of one scene, with a body that moves through it."""
    pictures = []
    for number in range(count):
        picture = texture(seed, SIZE, 40, 200, block)
        left = 10 + step_px * number % 200
        picture[30:60, left : left + 30] = 240
        pictures.append(picture)
    return pictures


def longest(pictures: Sequence[Luma]) -> range:
    shots = Shots()
    for picture in pictures:
        shots.add(picture)
    return shots.longest()


def test_the_longest_shot_is_kept() -> None:
    assert longest([*scene(1, 30), *scene(2, 50), *scene(3, 20)]) == range(30, 80)


def test_one_scene_is_not_parted_however_its_light_changes() -> None:
    pictures = scene(1, 40)
    light = 1 + 0.2 * (np.arange(40) > 20) + 0.1 * np.sin(np.arange(40))
    levels = [np.clip(g * one, 0, 255) for g, one in zip(light, pictures, strict=True)]
    assert longest([one.astype(np.uint8) for one in levels]) == range(40)


def flash(picture: Luma) -> Luma:
    return np.full_like(picture, 255)


def damage(picture: Luma) -> Luma:
    grey = picture.copy()
    grey[:, 60:] = 128
    return grey


@pytest.mark.parametrize("change", [flash, damage])
def test_one_odd_picture_parts_nothing(change: Callable[[Luma], Luma]) -> None:
    pictures = scene(1, 40)
    pictures[20] = change(pictures[20])
    assert longest(pictures) == range(40)


@pytest.mark.parametrize("step_px", [1, 40])
def test_a_body_parts_nothing_however_fast_it_moves(step_px: int) -> None:
    assert longest(scene(1, 60, step_px)) == range(60)


def test_noise_in_the_dark_parts_nothing() -> None:
    rng = np.random.default_rng(4)
    assert longest([rng.integers(10, 16, SIZE).astype(np.uint8) for _ in range(40)]) == range(40)


@pytest.mark.parametrize("count", [0, 1, 2])
def test_hardly_any_pictures_are_one_shot(count: int) -> None:
    assert longest(scene(1, count)) == range(count)


def test_a_trial_after_another_scene_is_counted_and_said_to_be_one_shot(tmp_path: Path) -> None:
    with open_footage(TRIAL) as footage:
        trial = [frame.luma.copy() for frame in footage.frames()]
    title = _walk(trial[0].shape, 60)
    path = tmp_path / "cut.mp4"
    write_clip(path, [*title, *trial], WriteOptions(crf=18, preset="superfast"))
    result = count_video.count(path).to_dict()
    truth = json.loads(TRIAL.with_suffix(".truth.json").read_text("utf-8"))
    assert result["count"] == truth["count"]
    assert any(f"frames 60 to {59 + len(trial)}" in said for said in result["warnings"])
    away = [
        found["frame"] - 60 - true["frame"]
        for found, true in zip(result["collisions"], truth["events"], strict=False)
    ]
    assert np.median(np.abs(away)) < TIME_FRAMES


def _walk(shape: tuple[int, ...], count: int) -> list[Luma]:
    """Another scene, in which something walks past."""
    height, width = shape
    pictures = []
    for number in range(count):
        picture = texture(7, (height, width), 30, 220, 40)
        left = 20 + 6 * number
        picture[40:, left : left + 50] = 15
        pictures.append(picture)
    return pictures

from __future__ import annotations

from itertools import product
from pathlib import Path

import numpy as np
import pytest
from numbered_frames import HEIGHT, WIDTH, Luma

from count_video.video.reader import open_footage
from count_video.video.writer import WriteOptions, write_clip

ROTATIONS = (0, 90, 180, 270)
CORNERS = {"top left": 220, "top right": 160, "bottom left": 100, "bottom right": 40}
CODING_ERROR_LEVELS = 2.0


def scene() -> Luma:
    """A picture with a different grey in each quarter: no turn or mirror image equals it."""
    picture = np.empty((HEIGHT, WIDTH), np.uint8)
    halves = product((slice(None, HEIGHT // 2), slice(HEIGHT // 2, None)), (False, True))
    for (rows, right), grey in zip(halves, CORNERS.values(), strict=True):
        picture[rows, WIDTH // 2 :] = grey if right else picture[rows, WIDTH // 2 :]
        picture[rows, : WIDTH // 2] = picture[rows, : WIDTH // 2] if right else grey
    return picture


@pytest.fixture(params=ROTATIONS)
def rotation(request: pytest.FixtureRequest) -> int:
    return int(request.param)


def filmed(path: Path, rotation: int, pixel_format: str = "yuv420p") -> Path:
    """Film the scene with a camera that was turned, as a phone writes it: sensor rows as they
    are, and a note how far display has to turn them back counter-clockwise."""
    sensor = np.rot90(scene(), -rotation // 90)
    options = WriteOptions(rotation_deg=rotation, pixel_format=pixel_format)
    write_clip(path, [np.ascontiguousarray(sensor)] * 3, options)
    return path


@pytest.mark.parametrize("suffix", [".mp4", ".mov", ".mkv"])
def test_the_scene_is_upright_however_the_camera_was_held(
    tmp_path: Path, suffix: str, rotation: int
) -> None:
    path = filmed(tmp_path / f"clip{suffix}", rotation)
    with open_footage(path) as footage:
        frames = list(footage.frames())
        assert footage.info.rotation_deg == rotation
        assert (footage.info.height_px, footage.info.width_px) == scene().shape
    for frame in frames:
        assert frame.luma.shape == scene().shape
        assert np.abs(frame.luma.astype(float) - scene()).mean() < CODING_ERROR_LEVELS


def test_ten_bit_pictures_are_turned_too(tmp_path: Path, rotation: int) -> None:
    path = filmed(tmp_path / "clip.mp4", rotation, "yuv420p10le")
    with open_footage(path) as footage:
        luma = next(iter(footage.frames())).luma
        assert np.abs(luma.astype(float) - scene()).mean() < CODING_ERROR_LEVELS

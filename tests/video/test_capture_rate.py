from __future__ import annotations

from pathlib import Path

import pytest
from numbered_frames import write_numbered

from count_video.video.reader import open_footage, stated_rate
from count_video.video.writer import WriteOptions

ANDROID = "com.android.capture.fps"


def clip(folder: Path, name: str, tags: dict[str, str]) -> Path:
    return write_numbered(folder / name, 3, WriteOptions(metadata=tags))


@pytest.mark.parametrize("name", ["clip.mp4", "clip.mov", "clip.mkv"])
def test_the_rate_that_a_phone_wrote_is_used(tmp_path: Path, name: str) -> None:
    with open_footage(clip(tmp_path, name, {ANDROID: "240.000000"})) as footage:
        assert footage.info.capture_fps == 240.0
        assert footage.info.capture_fps_source == "metadata"
        assert footage.info.container_fps == 30.0


def test_the_user_knows_better_than_the_file(tmp_path: Path) -> None:
    path = clip(tmp_path, "clip.mp4", {ANDROID: "240"})
    with open_footage(path, capture_fps=959.04) as footage:
        assert footage.info.capture_fps == 959.04
        assert footage.info.capture_fps_source == "option"


@pytest.mark.parametrize("text", ["0", "-30", "nan", "inf", "fast", ""])
def test_a_rate_that_is_no_rate_is_as_good_as_none(text: str) -> None:
    assert stated_rate([(ANDROID, text)]) is None


def test_without_option_and_tag_the_rate_is_unknown(tmp_path: Path) -> None:
    with open_footage(clip(tmp_path, "clip.mp4", {"encoder": "240"})) as footage:
        assert footage.info.capture_fps is None
        assert footage.info.capture_fps_source == "unknown"


def test_a_worthless_tag_does_not_hide_a_good_one() -> None:
    tags = [(ANDROID, "0"), (ANDROID.upper(), "120")]
    assert stated_rate(tags) == 120.0

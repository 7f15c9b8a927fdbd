from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from numbered_frames import write_numbered

from coded import time_stamps_s
from count_video.video.writer import WriteOptions


@pytest.mark.parametrize(
    "fps", [Fraction(30), Fraction(30000, 1001), Fraction(240), Fraction(25, 2)]
)
def test_time_stamps_are_multiples_of_the_playing_rate_rounded_once(
    tmp_path: Path, fps: Fraction
) -> None:
    path = write_numbered(tmp_path / "clip.mp4", 20, WriteOptions(container_fps=fps))
    assert time_stamps_s(path) == [float(k / fps) for k in range(20)]


@pytest.mark.parametrize("codec", ["libx264", "libx265"])
def test_time_stamps_of_a_variable_rate_are_exact(tmp_path: Path, codec: str) -> None:
    # Steps of a phone that films between 33 and 108 ms a frame, on the clock of MPEG.
    steps = np.random.default_rng(3).integers(3000, 9700, 29)
    times = [Fraction(int(ticks), 90_000) for ticks in np.concatenate([[0], np.cumsum(steps)])]
    options = WriteOptions(codec=codec, frame_times_s=times)
    path = write_numbered(tmp_path / "clip.mp4", 30, options)
    assert time_stamps_s(path) == [float(time) for time in times]


def test_matroska_rounds_time_stamps_to_its_own_milliseconds(tmp_path: Path) -> None:
    path = write_numbered(tmp_path / "clip.mkv", 20)
    assert time_stamps_s(path) == [round(k * 1000 / 30) / 1000 for k in range(20)]

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numbered_frames import write_numbered

from count_video.footage.clock import (
    footage_time_s,
    frame_at_footage_time,
    frame_at_real_time,
    real_time_s,
)
from count_video.footage.reader import open_footage
from count_video.footage.writer import WriteOptions

ROUNDING = 1e-12


def stamps(path: Path) -> list[float]:
    with open_footage(path) as footage:
        return [frame.footage_time_s for frame in footage.frames()]


@pytest.mark.parametrize(
    "fps", [Fraction(30), Fraction(30000, 1001), Fraction(240), Fraction(25, 2)]
)
def test_time_stamps_are_multiples_of_the_playing_rate_rounded_once(
    tmp_path: Path, fps: Fraction
) -> None:
    path = write_numbered(tmp_path / "clip.mp4", 20, WriteOptions(container_fps=fps))
    assert stamps(path) == [float(k / fps) for k in range(20)]


@pytest.mark.parametrize("codec", ["libx264", "libx265"])
def test_time_stamps_of_a_variable_rate_are_exact(tmp_path: Path, codec: str) -> None:
    # Steps of a phone that films between 33 and 108 ms a frame, on the clock of MPEG.
    steps = np.random.default_rng(3).integers(3000, 9700, 29)
    times = [Fraction(int(ticks), 90_000) for ticks in np.concatenate([[0], np.cumsum(steps)])]
    options = WriteOptions(codec=codec, frame_times_s=times)
    path = write_numbered(tmp_path / "clip.mp4", 30, options)
    assert stamps(path) == [float(time) for time in times]


def test_matroska_rounds_time_stamps_to_its_own_milliseconds(tmp_path: Path) -> None:
    path = write_numbered(tmp_path / "clip.mkv", 20)
    assert stamps(path) == [round(k * 1000 / 30) / 1000 for k in range(20)]


@given(frame=st.floats(-10, 1e6), rate=st.floats(1.0, 1e5))
def test_real_time_and_frames_convert_both_ways(frame: float, rate: float) -> None:
    there_and_back = frame_at_real_time(real_time_s(frame, rate), rate)
    assert there_and_back == pytest.approx(frame, rel=ROUNDING, abs=ROUNDING)


def test_a_frame_at_the_capture_rate_is_a_second_of_real_time() -> None:
    assert real_time_s(240.0, 240.0) == 1.0
    assert real_time_s(0.5, 2000.0) == 0.00025


def test_footage_time_is_linear_between_time_stamps() -> None:
    times = np.array([0.0, 0.1, 0.4, 0.5])
    assert footage_time_s(1.5, times) == pytest.approx(0.25)
    assert frame_at_footage_time(0.25, times) == pytest.approx(1.5)


def test_footage_time_bridges_a_frame_without_time_stamp() -> None:
    times = np.array([0.0, np.nan, 0.2])
    assert footage_time_s(1.0, times) == pytest.approx(0.1)
    assert frame_at_footage_time(0.1, times) == pytest.approx(1.0)


def test_footage_time_is_unknown_outside_the_clip_and_without_time_stamps() -> None:
    times = np.array([0.0, 0.1])
    for outside in (-0.5, 1.5):
        assert np.isnan(footage_time_s(outside, times))
        assert np.isnan(frame_at_footage_time(outside, times))
    assert np.isnan(footage_time_s(0.0, np.array([np.nan])))
    assert np.isnan(frame_at_footage_time(0.0, np.array([])))

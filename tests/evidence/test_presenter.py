"""The clip for a talk: its size, its counter, and its GIF."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from evidence_made import CLIP
from PIL import Image

from count_video import cli
from count_video.footage.reader import open_footage
from count_video.reports.presenter import COUNTER_PX, SIZES, Shape
from tiers import rest_slow

SMALL = CLIP.with_name("ratio1-count3.mp4")


@pytest.mark.parametrize("shape", rest_slow(["wide", "upright"]))
def test_a_clip_for_a_talk_is_full_hd_and_counts_to_the_answer(
    shape: Shape, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main([str(SMALL), "-o", str(tmp_path), "--presenter", shape]) == 0
    assert "presenter.mp4" in capsys.readouterr().out
    with open_footage(tmp_path / "ratio1-count3.presenter.mp4") as footage:
        assert (footage.info.width_px, footage.info.height_px) == SIZES[shape]
        assert footage.info.codec == "h264"
        # The wall is on the left, so the counter stands in the corner on the right.
        corner = (slice(0, COUNTER_PX[shape]), slice(-COUNTER_PX[shape] // 2, None))
        counters = [frame.luma[corner].astype(np.int16) for frame in footage.frames()]
    with open_footage(SMALL) as plain:
        assert len(counters) == sum(1 for _ in plain.frames())
    steps = [np.abs(b - a).max() for a, b in pairwise(counters)]
    assert sum(step > 150 for step in steps) == 3
    with Image.open(tmp_path / "ratio1-count3.presenter.gif") as gif:
        assert getattr(gif, "n_frames", 1) > 20
        assert gif.info.get("loop") == 0
        width, height = SIZES[shape]
        assert gif.size[0] / gif.size[1] == pytest.approx(width / height, rel=0.01)


@pytest.mark.parametrize("arguments", [[], ["other.mp4", "-o", "out"]])
def test_a_clip_for_a_talk_needs_one_clip_and_a_folder(
    arguments: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main([str(SMALL), *arguments, "--presenter", "wide"]) == 2
    assert capsys.readouterr().err.count("\n") == 1

"""One body alone is counted, other scenes are refused with a reason, by the whole command."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from counting import Answer, answer

from count_video.video.writer import WriteOptions, write_clip
from tiers import rest_slow

SHAPE = (150, 220)
FLIGHTS = (26.0, 21.0, 17.0, 14.0)
DROP = 18.4
PULL = 0.55
FLOOR_PX = 120.0
RADIUS_PX = 9.0
TIME_FRAMES = 0.25
"""The same that the median error of the trials may be; every impact here is within it."""

Luma = np.ndarray[tuple[int, int], np.dtype[np.uint8]]


def heights() -> tuple[np.ndarray[tuple[int], np.dtype[np.float64]], list[float]]:
    impacts = [DROP, *(DROP + np.cumsum(FLIGHTS)).tolist()]
    frame = np.arange(int(impacts[-1]), dtype=np.float64)
    height = PULL / 2 * (DROP**2 - frame**2)
    for begin, end in pairwise(impacts):
        inside = (frame >= begin) & (frame < end)
        height[inside] = PULL / 2 * (frame[inside] - begin) * (end - frame[inside])
    return height, impacts[:-1]


def picture(x: float, y: float, rng: np.random.Generator) -> Luma:
    """A dark ball with a soft edge before a wall with a gradient."""
    rows, columns = np.indices(SHAPE, dtype=np.float64)
    canvas = 150.0 + 0.15 * columns + 8.0 * np.sin(rows / 9.0)
    share = np.clip(RADIUS_PX + 0.5 - np.hypot(columns - x, rows - y), 0.0, 1.0)
    canvas += share * (45.0 - canvas)
    return np.clip(canvas + rng.normal(0, 1.5, SHAPE), 0, 255).astype(np.uint8)


def counted(folder: Path, places: list[tuple[float, float]], turned: int = 0) -> Answer:
    rng = np.random.default_rng(7)
    pictures = [np.rot90(picture(x, y, rng), turned).copy() for x, y in places]
    path = folder / "clip.mp4"
    write_clip(path, pictures, WriteOptions(crf=18))
    return answer(path)


@pytest.mark.parametrize("turned", rest_slow([1, 0, 2]))
def test_a_bouncing_ball_is_counted_whichever_way_the_picture_is_held(
    tmp_path: Path, turned: int
) -> None:
    height, impacts = heights()
    places = [(60.0 + 0.8 * k, FLOOR_PX - h) for k, h in enumerate(height)]

    said = counted(tmp_path, places, turned)

    assert (said["status"], said["count"]) == ("counted", len(impacts)), said["reason"]
    assert {collision["kind"] for collision in said["collisions"]} == {"wall"}
    found = [collision["frame"] for collision in said["collisions"]]
    assert found == pytest.approx(impacts, abs=TIME_FRAMES)
    assert said["probability"][str(len(impacts))] > 0.9
    assert said["mass_ratio"] is said["pi_low"] is said["millimetres_per_px"] is None
    assert said["collisions"][0]["velocity_before_px_frame"]["heavy"] is None


def test_a_swing_is_not_counted_and_the_reason_is_reported(tmp_path: Path) -> None:
    places = [(110.0 + 70 * np.cos(k / 9.0), 75.0) for k in range(110)]

    said = counted(tmp_path, places)

    assert (said["status"], said["count"]) == ("not_counted", None)
    assert "smoothly" in said["reason"]


def test_a_body_that_walks_through_is_not_counted(tmp_path: Path) -> None:
    said = counted(tmp_path, [(15.0 + 2.5 * k, 75.0) for k in range(76)])

    assert said["status"] == "not_counted"
    assert said["reason"]

"""What the count does not depend on: light, side, place, turn and speed of playing.

Each law is tried on a rendered trial of twelve collisions at half its size and, with ``-m slow``,
at its own size and on a ray traced one.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import cv2
import numpy as np
import pytest
from counting import FIXTURES, Answer, answer, assert_counted, burst, truth_of
from numpy.typing import NDArray

from count_video.motion.descent import CONVERGED
from count_video.video.reader import open_footage
from count_video.video.writer import WriteOptions, write_clip
from tiers import rest_slow

Luma = NDArray[np.uint8]

CLIPS = ["half-the-size", "ratio16-count12", "cluttered-1to16"]
ENCODING = WriteOptions(crf=18, preset="superfast", more={"threads": "0"})
PLACE_ERROR_PX = 1.0
"""The same body in the same picture, found a second time from other pictures."""

on_each_clip = pytest.mark.parametrize("clip", rest_slow(CLIPS), indirect=True)


@pytest.fixture(scope="module")
def clip(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A clip, with its truth beside it."""
    if request.param != CLIPS[0]:
        return FIXTURES / f"{request.param}.mp4"
    full = FIXTURES / f"{CLIPS[1]}.mp4"
    small = rewritten(full, tmp_path_factory.mktemp("clip") / f"{CLIPS[0]}.mp4", halved)
    shutil.copy(full.with_suffix(".truth.json"), small.with_suffix(".truth.json"))
    return small


def rewritten(
    clip: Path, target: Path, change: Callable[[Luma], Luma], options: WriteOptions = ENCODING
) -> Path:
    """Write a clip again with each of its pictures changed."""
    with open_footage(clip) as footage:
        pictures = (np.ascontiguousarray(change(frame.luma)) for frame in footage.frames())
        write_clip(target, pictures, options)
    return target


def brightness(gain: float, offset: float) -> Callable[[Luma], Luma]:
    def change(luma: Luma) -> Luma:
        return np.clip(luma * gain + offset, 0, 255).astype(np.uint8)

    return change


def halved(luma: Luma) -> Luma:
    size = (luma.shape[1] // 2, luma.shape[0] // 2)
    return np.asarray(cv2.resize(luma, size, interpolation=cv2.INTER_AREA), np.uint8)


def with_bars(luma: Luma) -> Luma:
    height, width = luma.shape
    bars = [height // 6] * 2 + [width // 6] * 2
    return np.asarray(cv2.copyMakeBorder(luma, *bars, cv2.BORDER_CONSTANT, value=16), np.uint8)


def mirrored(luma: Luma) -> Luma:
    return luma[:, ::-1]


def half_turn(luma: Luma) -> Luma:
    return luma[::-1, ::-1]


def transposed(luma: Luma) -> Luma:
    return luma.T


def quarter_turn(luma: Luma) -> Luma:
    return np.rot90(luma)


def upside_down(luma: Luma) -> Luma:
    return luma[::-1]


@on_each_clip
@pytest.mark.parametrize(
    "change",
    rest_slow([brightness(0.5, 10), brightness(0.7, 75), brightness(1.2, 0)]),
    ids=["darker", "paler", "brighter"],
)
def test_light_does_not_change_the_count(
    clip: Path, change: Callable[[Luma], Luma], tmp_path: Path
) -> None:
    said = answer(rewritten(clip, tmp_path / "trial.mp4", change))
    assert_counted(said, truth_of(clip))
    assert said["wall_side"] == "left"


@on_each_clip
def test_bars_around_the_picture_do_not_change_the_count(clip: Path, tmp_path: Path) -> None:
    assert_counted(answer(rewritten(clip, tmp_path / "trial.mp4", with_bars)), truth_of(clip))


@on_each_clip
@pytest.mark.parametrize(
    ("change", "side"),
    rest_slow(
        [
            *((transposed, "left"), (half_turn, "right"), (mirrored, "right")),
            *((upside_down, "left"), (quarter_turn, "right")),
        ],
    ),
    ids=lambda value: getattr(value, "__name__", None),
)
def test_how_the_camera_is_held_does_not_change_the_count(
    clip: Path, change: Callable[[Luma], Luma], side: str, tmp_path: Path
) -> None:
    said = answer(rewritten(clip, tmp_path / "trial.mp4", change))
    assert_counted(said, truth_of(clip))
    assert said["wall_side"] == side


@on_each_clip
def test_a_clip_stored_on_its_side_is_counted_as_it_is_displayed(
    clip: Path, tmp_path: Path
) -> None:
    turned = replace(ENCODING, rotation_deg=90)  # counter-clockwise, as np.rot90 turns
    stored = rewritten(clip, tmp_path / "trial.mp4", lambda luma: np.rot90(luma, -1), turned)
    said = answer(stored)
    assert_counted(said, truth_of(clip))
    assert places(said) == pytest.approx(places(answer(clip)), abs=PLACE_ERROR_PX)


@on_each_clip
def test_a_mirrored_trial_is_the_mirror_image_of_the_answer(clip: Path, tmp_path: Path) -> None:
    said = answer(rewritten(clip, tmp_path / "trial.mp4", mirrored))
    with open_footage(clip) as footage:
        last_column = footage.info.width_px - 1
    turned_back = [last_column - place for place in places(said)]
    assert turned_back == pytest.approx(places(answer(clip)), abs=PLACE_ERROR_PX)
    speeds, own = (impact_speeds(one) for one in (said, answer(clip)))
    assert [s > 0 for s in speeds] == [s < 0 for s in own]


@on_each_clip
def test_a_region_around_the_bodies_does_not_change_the_count(clip: Path) -> None:
    said = answer(clip, "--region", region_around_the_bodies(clip))
    assert_counted(said, truth_of(clip))
    assert places(said) == pytest.approx(places(answer(clip)), abs=PLACE_ERROR_PX)


@on_each_clip
def test_a_cropped_clip_has_the_same_count_at_shifted_places(clip: Path, tmp_path: Path) -> None:
    x, y, width, height = map(int, region_around_the_bodies(clip).split(","))
    cropped = rewritten(
        clip, tmp_path / "trial.mp4", lambda luma: luma[y : y + height, x : x + width]
    )
    said = answer(cropped)
    assert_counted(said, truth_of(clip))
    shifted = [place + x for place in places(said)]
    assert shifted == pytest.approx(places(answer(clip)), abs=PLACE_ERROR_PX)


@on_each_clip
@pytest.mark.parametrize(
    "label", rest_slow([Fraction(24000, 1001), Fraction(240)]), ids=["slow", "fast"]
)
def test_the_playing_rate_changes_nothing(clip: Path, label: Fraction, tmp_path: Path) -> None:
    options = replace(ENCODING, container_fps=label)
    said = answer(rewritten(clip, tmp_path / "trial.mp4", lambda luma: luma, options))
    assert_counted(said, truth_of(clip))
    assert said["capture_fps"] is None
    assert [collision["time_s"] for collision in burst(said)] == [None] * said["count"]


FITTED_SHARE = 0.01
"""Shares of energy from two fits agree to this much."""
FITTED_SIGMAS = 2 * (2 * CONVERGED) ** 0.5
"""A fit ends where the loss, half a squared standard deviation, would fall by less: its times are
the root of twice that many uncertainties from the best ones at most, and two fits differ by twice
as much."""


@on_each_clip
def test_the_capture_rate_gives_times_and_changes_nothing_else(clip: Path) -> None:
    said, without = answer(clip, "--capture-fps", "960"), answer(clip)
    assert (said["capture_fps"], said["capture_fps_source"]) == (960, "option")
    times_s = [collision["time_s"] for collision in said["collisions"]]
    assert times_s == pytest.approx([c["frame"] / 960 for c in said["collisions"]])
    stated = {"capture_fps": None, "capture_fps_source": "unknown"}
    # These rest on a fit that starts from a pendulum's usual rate, where real time is known.
    ratio = ("mass_ratio", "mass_ratio_sigma", "pi_low", "pi_high")
    fitted = ("ending", "restitution", "energy_kept", "fitted_setup", "collisions", *ratio)
    plain = {key: value for key, value in said.items() if key not in fitted}
    assert {**plain, **stated} == {
        key: value for key, value in without.items() if key not in fitted
    }
    for one, other in zip(said["collisions"], without["collisions"], strict=True):
        assert [one[key] for key in ("number", "kind", "seen")] == [
            other[key] for key in ("number", "kind", "seen")
        ]
        assert one["frame"] == pytest.approx(
            other["frame"], abs=FITTED_SIGMAS * other["frame_sigma"]
        )
    assert said["ending"]["kind"] == without["ending"]["kind"]
    assert said["energy_kept"] == pytest.approx(without["energy_kept"], abs=FITTED_SHARE)
    sigma = without["mass_ratio_sigma"]
    assert said["mass_ratio"] == pytest.approx(without["mass_ratio"], abs=sigma)


def places(said: Answer) -> list[float]:
    return [collision["position_px"] for collision in burst(said)]


def impact_speeds(said: Answer) -> list[float]:
    return [collision["velocity_before_px_frame"]["ball"] for collision in burst(said)[1:]]


def region_around_the_bodies(clip: Path) -> str:
    """Leave out a strip above, below and at either side; the bodies stay inside."""
    with open_footage(clip) as footage:
        width, height = footage.info.width_px, footage.info.height_px
    x, y = dict(zip(CLIPS, ((15, 10), (30, 20), (60, 50)), strict=True))[clip.stem]
    return f"{x},{y},{width - 2 * x},{height - 2 * y}"

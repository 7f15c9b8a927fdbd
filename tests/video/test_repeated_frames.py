from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from count_video.records import Frame
from count_video.video.reader import open_footage
from count_video.video.repeats import HISTORY_AT_LEAST, PERIODS_SEEN, mark_repeats
from count_video.video.writer import WriteOptions, write_clip
from tiers import rest_slow

HEIGHT, WIDTH = 120, 320
RADIUS = 14.0
NOISE_LEVELS = 3.0
GOP = 50
ROWS, COLUMNS = np.indices((HEIGHT, WIDTH)).astype(float)
BACKGROUND = 90 + 20 * np.sin(COLUMNS / 9) * np.cos(ROWS / 7)
Luma = np.ndarray


def ball_at(x_px: float) -> Luma:
    """A ball on an uneven background; its outline is a ramp of one pixel, so it moves smoothly."""
    distance = np.hypot(ROWS - HEIGHT / 2, COLUMNS - x_px)
    cover = np.clip(RADIUS + 0.5 - distance, 0, 1)
    return BACKGROUND + (210 - BACKGROUND) * cover


def filmed(
    positions_px: Sequence[float], noise: float = 0.0, gain: Sequence[float] | None = None
) -> Iterator[Luma]:
    """Film a ball: each frame has its own noise, and its own brightness where lamps flicker."""
    rng = np.random.default_rng(8)
    for k, x_px in enumerate(positions_px):
        picture = ball_at(x_px) * (1.0 if gain is None else gain[k])
        yield np.clip(picture + rng.normal(0, noise, picture.shape), 0, 255).astype(np.uint8)


def zigzag(frames: int, speed_px: float, phase_px: float = 0.0) -> list[float]:
    """Positions of a ball that runs to and fro between two walls at constant speed."""
    span = WIDTH - 80.0
    path = (speed_px * np.arange(frames) + phase_px) % (2 * span)
    return list(40 + np.minimum(path, 2 * span - path))


def doubled(frames: list[Luma]) -> tuple[list[Luma], list[bool]]:
    return [frame for frame in frames for _ in range(2)], [False, True] * len(frames)


def pulled_down(frames: list[Luma]) -> tuple[list[Luma], list[bool]]:
    """Show every fourth picture twice, as 24 become 30 a second."""
    times = [2 if k % 4 == 3 else 1 for k in range(len(frames))]
    return repeated(frames, times)


def scattered(frames: list[Luma]) -> tuple[list[Luma], list[bool]]:
    """Show every tenth picture twice, by chance."""
    times = np.random.default_rng(6).choice([1, 2], len(frames), p=[0.9, 0.1])
    return repeated(frames, times)


def repeated(frames: list[Luma], times: Sequence[int]) -> tuple[list[Luma], list[bool]]:
    shown = [frame for frame, n in zip(frames, times, strict=True) for _ in range(n)]
    return shown, [copy > 0 for n in times for copy in range(n)]


def marked(lumas: Iterable[Luma]) -> list[bool]:
    """Whether each picture is taken for a copy of the one before."""
    return [copy for _, copy in mark_repeats((luma, None) for luma in lumas)]


Repeating = Callable[[list[Luma]], tuple[list[Luma], list[bool]]]


def read(folder: Path, frames: list[Luma], crf: int, codec: str = "libx264") -> list[Frame]:
    """Send frames through an encoder and read them back."""
    path = folder / "clip.mp4"
    write_clip(path, frames, WriteOptions(codec=codec, crf=crf, more={"g": str(GOP)}))
    with open_footage(path) as footage:
        return list(footage.frames())


@pytest.mark.parametrize("repeat", [doubled, pulled_down, scattered])
@pytest.mark.parametrize("noise", [0.0, NOISE_LEVELS])
def test_exact_copies_are_found_every_one(repeat: Repeating, noise: float) -> None:
    frames, copies = repeat(list(filmed(zigzag(60, 2.3), noise)))
    assert marked(frames) == copies


@pytest.mark.parametrize("codec", rest_slow(["libx264", "libx265"]))
@pytest.mark.parametrize("repeat", [doubled, pulled_down, scattered])
def test_copies_that_were_encoded_again_are_found_and_no_real_frame_is_taken_for_one(
    tmp_path: Path, repeat: Repeating, codec: str
) -> None:
    frames, copies = repeat(list(filmed(zigzag(120, 2.3), NOISE_LEVELS)))
    found = np.array([frame.repeats_previous for frame in read(tmp_path, frames, 16, codec)])
    truth = np.array(copies)
    assert not (found & ~truth).any()
    # A cadence shows after some periods, a single copy after some real frames.
    warm = max(PERIODS_SEEN * 5, HISTORY_AT_LEAST)
    assert found[warm:].sum() >= 0.8 * truth[warm:].sum()


@pytest.mark.parametrize("crf", [16, 28])
@pytest.mark.parametrize("speed_px", [0.05, 0.3, 1.0, 5.0])
def test_slow_and_fast_motion_in_noise_is_not_taken_for_copies(
    tmp_path: Path, speed_px: float, crf: int
) -> None:
    frames = read(tmp_path, list(filmed(zigzag(100, speed_px, phase_px=100), NOISE_LEVELS)), crf)
    marked = [(before, copy) for before, copy in pairwise(frames) if copy.repeats_previous]
    # Where an encoder finds too little news to store, it makes a true copy.
    assert all((before.luma == copy.luma).all() for before, copy in marked)
    assert speed_px < 0.3 or not marked


def test_a_ball_that_creeps_without_noise_repeats_only_what_is_identical() -> None:
    frames = list(filmed(zigzag(80, 0.0001)))
    identical = [False] + [bool((a == b).all()) for a, b in pairwise(frames)]
    assert any(identical)
    assert not all(identical[1:])
    assert marked(frames) == identical


@pytest.mark.parametrize("speed_px", [3.0, 8.0])
@pytest.mark.parametrize("phase", rest_slow([0.0, 0.4, 0.2, 0.6, 0.8], quick=2))
def test_a_bounce_that_two_frames_straddle_evenly_is_no_copy(speed_px: float, phase: float) -> None:
    frames = list(filmed(zigzag(200, speed_px, phase * speed_px), 0.4))
    assert not any(marked(frames))


@pytest.mark.parametrize("after", [0.0, 0.3])
def test_a_ball_that_is_stopped_by_a_collision_leaves_no_copies(after: float) -> None:
    before = 40 + 4.0 * np.arange(50)
    slow = before[-1] + after * np.arange(1, 31)
    frames = list(filmed([*before, *slow], 0.4))
    assert not any(marked(frames))


@pytest.mark.parametrize("period", [2.0, 2.4, 4.0, 8.8])
def test_lamps_that_flicker_make_no_copies(period: float) -> None:
    gain = 1 + 0.06 * np.sin(2 * np.pi * np.arange(120) / period)
    frames = list(filmed(zigzag(120, 0.3), 0.4, list(gain)))
    assert not any(marked(frames))


def test_a_still_scene_with_noise_is_not_marked(tmp_path: Path) -> None:
    frames = list(filmed([100.0] * 60, NOISE_LEVELS))
    assert not any(marked(frames))


def test_a_small_body_between_the_compared_rows_is_seen() -> None:
    tall = np.full((720, 320), 90, np.uint8)
    frames = []
    for k in range(40):
        picture = tall.copy()
        picture[307:310, 20 + 3 * k : 24 + 3 * k] = 200
        frames.append(picture)
    assert not any(marked(frames))


@pytest.mark.parametrize("shape", [(2, 2), (1, 400), (400, 1), (17, 33)])
def test_pictures_of_any_size_are_judged(shape: tuple[int, int]) -> None:
    rng = np.random.default_rng(1)
    first, second = rng.integers(0, 256, (2, *shape), dtype=np.uint8)
    assert marked([first, first.copy(), second]) == [False, True, False]


@pytest.mark.parametrize("frames", [0, 1, 2])
def test_the_shortest_clips_have_one_answer_a_frame(frames: int) -> None:
    assert marked(list(filmed(zigzag(frames, 3.0)))) == [False] * frames


def test_the_report_counts_copies_and_says_so(tmp_path: Path) -> None:
    frames, copies = doubled(list(filmed(zigzag(40, 2.3))))
    path = tmp_path / "clip.mkv"
    write_clip(path, frames, WriteOptions(codec="ffv1", pixel_format="gray"))
    with open_footage(path) as footage:
        assert [frame.repeats_previous for frame in footage.frames()] == copies
        (warning,) = footage.report().warnings
    assert "40 of 80 frames repeat" in warning


def test_a_long_wait_in_front_of_the_camera_is_not_worth_a_warning(tmp_path: Path) -> None:
    still = list(filmed([100.0])) * 50
    path = tmp_path / "clip.mkv"
    write_clip(
        path,
        [*still, *filmed(zigzag(20, 3.0))],
        WriteOptions(codec="ffv1", pixel_format="gray"),
    )
    with open_footage(path) as footage:
        assert sum(frame.repeats_previous for frame in footage.frames()) == 49
        assert footage.report().warnings == ()

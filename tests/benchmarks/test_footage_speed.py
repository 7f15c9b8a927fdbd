"""How much the frames cost beyond decoding, as a ratio to only decoding in the same run.

What is compared is the time of all processors together: it does not depend on how many there are
for the decoder's threads, nor on what else they do.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from pathlib import Path

import av
import numpy as np
import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from count_video.video.pictures import luma_of
from count_video.video.reader import open_footage
from count_video.video.repeats import mark_repeats
from count_video.video.writer import WriteOptions, write_clip

HEIGHT, WIDTH = 720, 1280
FRAMES = 200
GOP = 30
pytestmark = [pytest.mark.slow, pytest.mark.benchmark(timer=time.process_time)]

ROUNDS = 5
"""The best of so many is taken, of decoding alone as of what is measured, in turns: what else the
machine does then troubles both alike."""

MOST_FOR_A_VIEW = 1.10
"""A view costs nothing that can be measured; the rest is what two runs of a decoder differ by."""
MOST_FOR_FRAMES = 1.25
"""Opening, time stamps, and the comparison that finds copies."""
MOST_FOR_COPIES = 0.08
"""Finding copies takes about 0.04 ms a frame of this size."""


def pictures() -> Iterator[np.ndarray]:
    """A ball before a textured wall, with some noise, which is what takes an H.264 decoder time."""
    rng = np.random.default_rng(9)
    rows, columns = np.indices((HEIGHT, WIDTH))
    wall = 100 + 30 * np.sin(columns / 17) * np.cos(rows / 23)
    noise = rng.normal(0, 3, (8, HEIGHT, WIDTH))
    for k in range(FRAMES):
        picture = wall + noise[k % len(noise)]
        picture[(rows - 360) ** 2 + (columns - 100 - 3 * k) ** 2 < 60**2] = 220
        yield picture.clip(0, 255).astype(np.uint8)


@pytest.fixture(scope="module")
def clip(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("speed") / "clip.mp4"
    write_clip(path, pictures(), WriteOptions(crf=21, more={"g": str(GOP), "threads": "0"}))
    return path


def decode(path: Path, use: Callable[[av.VideoFrame], object] = lambda _: None) -> None:
    with av.open(str(path)) as container:
        stream = container.streams.video[0]
        stream.thread_type = "AUTO"
        for frame in container.decode(stream):
            use(frame)


def stream_frames(path: Path) -> None:
    with open_footage(path) as footage:
        for _ in footage.frames():
            pass


def ratio_to_decoding(
    benchmark: BenchmarkFixture, path: Path, measured: Callable[[], object]
) -> float:
    """Time what is measured, and before each round only decoding."""
    decoding_s = []

    def only_decode() -> None:
        start = time.process_time()
        decode(path)
        decoding_s.append(time.process_time() - start)

    benchmark.pedantic(measured, setup=only_decode, rounds=ROUNDS)
    if benchmark.stats is None:
        pytest.skip("benchmarks are switched off")
    ratio = float(benchmark.stats.stats.min / min(decoding_s))
    benchmark.extra_info["decoding_ms"] = 1e3 * min(decoding_s)
    benchmark.extra_info["ratio_to_decoding"] = ratio
    return ratio


def test_a_view_of_the_luma_plane_is_free(benchmark: BenchmarkFixture, clip: Path) -> None:
    ratio = ratio_to_decoding(benchmark, clip, lambda: decode(clip, luma_of))
    assert ratio <= MOST_FOR_A_VIEW


def test_a_conversion_to_grey_is_not(benchmark: BenchmarkFixture, clip: Path) -> None:
    def convert() -> None:
        decode(clip, lambda frame: frame.to_ndarray(format="gray"))

    assert ratio_to_decoding(benchmark, clip, convert) > MOST_FOR_A_VIEW


def test_a_stream_of_frames_costs_little_more_than_decoding(
    benchmark: BenchmarkFixture, clip: Path
) -> None:
    assert ratio_to_decoding(benchmark, clip, lambda: stream_frames(clip)) <= MOST_FOR_FRAMES


def test_copies_are_found_in_a_small_part_of_the_time(
    benchmark: BenchmarkFixture, clip: Path
) -> None:
    with open_footage(clip) as footage:
        lumas = [frame.luma for frame in footage.frames(end=20)]

    def compare() -> None:
        marked = mark_repeats((lumas[k % 20], None) for k in range(FRAMES))
        assert not any(copy for _, copy in marked)

    assert ratio_to_decoding(benchmark, clip, compare) <= MOST_FOR_COPIES

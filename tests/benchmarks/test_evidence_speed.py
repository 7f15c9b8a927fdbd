"""What the evidence costs, as a ratio to decoding and encoding the clip once, and what help costs.

Each is a process of its own, from the interpreter's start to its end, and they take turns; the best
of each is compared. Run it alone, on a machine with nothing else to do:

    pytest -m slow tests/benchmarks/test_evidence_speed.py
"""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path

import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from synth_video.film import render_clip
from synth_video.scene_file import load_scene

FRAMES = 1500
SCENE = (
    *("camera.width_px=1280", "camera.height_px=720", "camera.capture_fps=1750"),
    *(f"clip.frames={FRAMES}", "encoding.crf=20"),
)
ROUNDS = 3
HELP_ROUNDS = 10
MOST_TO_DECODING_AND_ENCODING = 4.0
MOST_TO_A_BARE_START = 8.0

DECODE_AND_ENCODE = """
import sys
from pathlib import Path
from count_video.video.reader import open_footage
from count_video.video.writer import write_clip
with open_footage(Path(sys.argv[1])) as footage:
    write_clip(Path(sys.argv[2]), (frame.luma for frame in footage.frames()))
"""

pytestmark = pytest.mark.slow


def taken_s(*arguments: str) -> float:
    """Run Python with these arguments to its end and time it."""
    start = time.perf_counter()
    subprocess.run([sys.executable, *arguments], check=True, stdout=subprocess.DEVNULL)
    return time.perf_counter() - start


@pytest.fixture(scope="module")
def clip(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("speed") / "trial.mp4"
    render_clip(load_scene("paper", SCENE), 7, path)
    return path


def test_all_evidence_costs_at_most_four_times_decoding_and_encoding_once(
    benchmark: BenchmarkFixture, clip: Path
) -> None:
    plain: list[float] = []
    evidence: list[float] = []
    folder, copy = clip.parent / "evidence", clip.parent / "copy.mp4"
    benchmark.pedantic(
        lambda: evidence.append(taken_s("-m", "count_video", str(clip), "-o", str(folder))),
        setup=lambda: plain.append(taken_s("-c", DECODE_AND_ENCODE, str(clip), str(copy))),
        rounds=ROUNDS,
    )
    if benchmark.stats is None:
        pytest.skip("benchmarks are switched off")
    ratio = min(evidence) / min(plain)
    benchmark.extra_info["ratio_to_decoding_and_encoding"] = ratio
    assert len(list(folder.iterdir())) == 6
    assert ratio <= MOST_TO_DECODING_AND_ENCODING, benchmark.extra_info


def test_help_costs_a_few_bare_starts_of_python(benchmark: BenchmarkFixture) -> None:
    bare: list[float] = []
    asked: list[float] = []
    taken_s("-m", "count_video", "--help")  # the first one reads the libraries from the disk
    benchmark.pedantic(
        lambda: asked.append(taken_s("-m", "count_video", "--help")),
        setup=lambda: bare.append(taken_s("-c", "pass")),
        rounds=HELP_ROUNDS,
    )
    if benchmark.stats is None:
        pytest.skip("benchmarks are switched off")
    ratio = min(asked) / min(bare)
    benchmark.extra_info["ratio_to_a_bare_start"] = ratio
    assert ratio <= MOST_TO_A_BARE_START, benchmark.extra_info

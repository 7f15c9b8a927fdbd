"""What ``count-video`` costs beyond decoding, as a ratio in the same run, and its memory.

Both are processes of their own, from the interpreter's start to its end: the whole command, and a
program that decodes the same clip with PyAV in the decoder's threads and does nothing else. They
take turns, and the best of each is compared. Run it alone, on a machine with nothing else to do:

    pytest -m slow tests/benchmarks/test_count_speed.py

Wall time is what is asked about. Beside it stands the time of all processors together, which
depends less on what else the machine does and on how many of them it has.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import av
import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from synth_video.film import render_clip
from synth_video.scene_file import load_scene

if not hasattr(os, "wait4"):
    pytest.skip("this system does not say what a process used", allow_module_level=True)

FRAMES = 1500
FEW_LOOPS, LOOPS = 2, 10
SCENE = (
    *("camera.width_px=1280", "camera.height_px=720", "camera.capture_fps=1750"),
    *(f"clip.frames={FRAMES}", "encoding.crf=20"),
)
"""The paper's trial, whole, in as many frames."""
ROUNDS = 3
MOST_TO_DECODING = 1.5
MOST_MEMORY_MB = 300.0
SAME_MEMORY = 0.10
"""Share by which two runs of one command differ in memory, and some more."""

DECODE = """
import sys
import av
with av.open(sys.argv[1]) as container:
    stream = container.streams.video[0]
    stream.thread_type = "AUTO"
    for frame in container.decode(stream):
        pass
"""

# A process of little memory starts what is measured: at its start, a process counts the memory of
# the one that it springs from as its own, and this one has rendered a clip.
MEASURE = """
import json, os, subprocess, sys, time
start = time.perf_counter()
process = subprocess.Popen([sys.executable, *sys.argv[1:]], stdout=subprocess.PIPE)
said = process.stdout.read().decode()
_, status, usage = os.wait4(process.pid, 0)
wall_s = time.perf_counter() - start
processors_s = usage.ru_utime + usage.ru_stime
json.dump([wall_s, processors_s, usage.ru_maxrss, said], sys.stdout)
"""
BYTES_OF_MAXRSS = 1 if sys.platform == "darwin" else 1024

pytestmark = pytest.mark.slow


@dataclass(frozen=True)
class Use:
    """What one process took."""

    wall_s: float
    processors_s: float
    """Of all processors together."""
    memory_mb: float
    """At its peak."""
    said: str
    """Its standard output."""


def used(*arguments: str) -> Use:
    """Run Python with these arguments to its end."""
    command = [sys.executable, "-c", MEASURE, *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    wall_s, processors_s, maxrss, said = json.loads(done.stdout)
    return Use(wall_s, processors_s, maxrss * BYTES_OF_MAXRSS / 1e6, said)


def count(clip: Path) -> Use:
    return used("-m", "count_video", "--json", str(clip))


def decode(clip: Path) -> Use:
    return used("-c", DECODE, str(clip))


@pytest.fixture(scope="module")
def clip(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("speed") / "trial.mp4"
    render_clip(load_scene("paper", SCENE), 7, path)
    return path


def looped(clip: Path, loops: int) -> Path:
    """The same trial over and over, packet by packet, in one file."""
    path = clip.with_name(f"loops{loops}.mp4")
    with av.open(str(clip)) as source, av.open(str(path), "w") as target:
        stream = source.streams.video[0]
        copy = target.add_stream_from_template(stream)
        packets = [packet for packet in source.demux(stream) if packet.dts is not None]
        ticks = sum(packet.duration or 0 for packet in packets)
        for loop in range(loops):
            for packet in packets:
                later = av.Packet(bytes(packet))
                later.pts = (packet.pts or 0) + loop * ticks
                later.dts = (packet.dts or 0) + loop * ticks
                later.duration, later.time_base = packet.duration, stream.time_base
                later.is_keyframe, later.stream = packet.is_keyframe, copy
                target.mux(later)
    return path


def test_counting_takes_little_longer_than_decoding(
    benchmark: BenchmarkFixture, clip: Path
) -> None:
    counting: list[Use] = []
    decoding: list[Use] = []
    count(clip)  # the first one reads the file and the libraries from the disk
    benchmark.pedantic(
        lambda: counting.append(count(clip)),
        setup=lambda: decoding.append(decode(clip)),
        rounds=ROUNDS,
    )
    if benchmark.stats is None:
        pytest.skip("benchmarks are switched off")
    truth = json.loads(clip.with_suffix(".truth.json").read_text("utf-8"))
    assert [json.loads(one.said)["count"] for one in counting] == [truth["count"]] * ROUNDS
    ratio = min(one.wall_s for one in counting) / min(one.wall_s for one in decoding)
    benchmark.extra_info["ratio_to_decoding"] = ratio
    benchmark.extra_info["ratio_of_processor_time"] = min(
        one.processors_s for one in counting
    ) / min(one.processors_s for one in decoding)
    assert ratio <= MOST_TO_DECODING, benchmark.extra_info


def test_memory_does_not_grow_with_the_length_of_the_clip(
    benchmark: BenchmarkFixture, clip: Path
) -> None:
    whole = count(clip)
    # Trials in a row are not counted, and what is not counted is tried in a second way.
    short = count(looped(clip, FEW_LOOPS))
    long: list[Use] = []
    long_clip = looped(clip, LOOPS)
    benchmark.pedantic(lambda: long.append(count(long_clip)), rounds=1)
    assert json.loads(long[0].said)["frames_decoded"] == LOOPS * FRAMES
    uses = {"one": whole, "short": short, "long": long[0]}
    memory_mb = {name: use.memory_mb for name, use in uses.items()}
    benchmark.extra_info["memory_mb"] = memory_mb
    assert max(memory_mb.values()) <= MOST_MEMORY_MB
    assert memory_mb["long"] == pytest.approx(memory_mb["short"], rel=SAME_MEMORY)

"""What the table of costs says, on clips so small that their cost itself says nothing."""

from __future__ import annotations

import os
import signal
from dataclasses import replace
from pathlib import Path

import pytest

if not hasattr(os, "wait4"):
    pytest.skip("this system does not say what a process used", allow_module_level=True)

from cost import (
    COLUMNS,
    TARGET_RATIO,
    TARGET_START_S,
    Cost,
    Decoding,
    Run,
    best_of,
    cost_of,
    decode,
    main,
    markdown,
    outcome_of,
    run,
    summary,
)

from count_video.video.reader import open_footage

FIXTURES = Path(__file__).parents[2] / "fixtures"
FIXTURE = FIXTURES / "ratio1-count3.mp4"
COST = Cost(Path("a.mp4"), Decoding(640, 240, 100, time_s=2.0), 5.0, 150.0, 250, "3, right")
COUNTED = '{"status": "counted", "count": 3, "reason": null, "probability": {}, "collisions": []}'
REFUSED = COUNTED.replace('"counted"', '"not_counted"').replace("3", "null")

# PyAV decodes in four ways; the program prints the pictures of each, and how many were counted.
DECODE_FOUR_WAYS = """
import sys
sys.argv = sys.argv[1:]
import mmap
from counting_pictures import count_pictures
tally = mmap.mmap(-1, 8)
count_pictures(tally)
import av
def pictures(way):
    with av.open(sys.argv[0]) as container:
        stream = container.streams.video[0]
        found = sum(len(list(part)) for part in way(container, stream))
    return found
ways = (
    lambda container, stream: [container.decode(stream)],
    lambda container, stream: (packet.decode() for packet in container.demux(stream)),
    lambda container, stream: (stream.decode(packet) for packet in container.demux(stream)),
    lambda container, stream: (
        stream.codec_context.decode(packet if packet.size else None)
        for packet in container.demux(stream)
    ),
)
before = 0
for way in ways:
    seen = pictures(way)
    counted = int.from_bytes(tally[:], "little")
    print(seen, counted - before)
    before = counted
"""


def test_pictures_are_counted_in_whichever_way_they_are_decoded(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parent))
    done = run("-c", DECODE_FOUR_WAYS, str(FIXTURE))
    assert done.status == 0, done.stderr
    frames = str(decode(FIXTURE).frames)
    assert [line.split() for line in done.stdout.splitlines()] == [[frames, frames]] * 4


def test_what_a_clip_costs_is_measured_and_its_answer_judged() -> None:
    with open_footage(FIXTURE) as footage:
        frames = sum(1 for _ in footage.frames())
        size = (footage.info.width_px, footage.info.height_px)
    cost = cost_of(FIXTURE)
    decoding = cost.decoding
    assert (decoding.width_px, decoding.height_px, decoding.frames) == (*size, frames)
    assert cost.decodings >= 1
    assert cost.command_s > decoding.time_s > 0
    assert cost.memory_mb > 0
    assert cost.outcome == "3, right"


@pytest.mark.parametrize(
    ("status", "stdout", "stderr", "outcome"),
    [
        (0, COUNTED, "", "3, right"),
        (0, COUNTED.replace("3", "2"), "", "2, WRONG, truth 3"),
        (1, REFUSED, "too dark", "not counted, truth 3"),
        (-signal.SIGXCPU, "", "", "time-out"),
        (1, "", "Traceback\nMemoryError", "failed with 1: MemoryError"),
        (-signal.SIGKILL, "", "", f"failed with {-signal.SIGKILL}: no word"),
    ],
)
def test_the_outcome_says_what_was_answered_and_whether_it_is_right(
    status: int, stdout: str, stderr: str, outcome: str
) -> None:
    assert outcome_of(FIXTURE, Run(1.0, 100.0, status, stdout, stderr)) == outcome


def test_over_is_what_the_target_is_missed_by() -> None:
    assert COST.ratio == 2.5
    assert COST.decodings == 2.5
    assert COST.over_s == pytest.approx(5.0 - TARGET_RATIO * 2.0 - TARGET_START_S)


def test_of_several_rounds_the_shortest_times_and_the_most_memory_count() -> None:
    slow = replace(COST, decoding=replace(COST.decoding, time_s=1.0), memory_mb=140.0)
    quick = replace(COST, command_s=4.0)
    best = best_of([slow, quick])
    assert (best.decoding.time_s, best.command_s, best.memory_mb) == (1.0, 4.0, 150.0)


def test_the_summary_names_the_worst_clips() -> None:
    other = replace(COST, clip=Path("b.mp4"), command_s=4.0, memory_mb=400.0)
    lines = list(summary([COST, other]))
    assert lines[0].startswith("1 of 2 clips within")
    assert lines[1:] == [
        "largest ratio: 2.5 (a.mp4)",
        "largest over s: +0.90 (a.mp4)",
        "largest memory MB: 400 (b.mp4)",
        "largest decodings: 2.50 (a.mp4)",
    ]


def test_the_table_is_markdown_when_asked_for_and_a_bad_clip_loses_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bad = tmp_path / "bad.mp4"
    bad.write_bytes(b"no film")
    assert main(["--markdown", str(bad), str(FIXTURE)]) == 1
    printed = capsys.readouterr()
    assert printed.err.startswith(f"{bad}: cannot be decoded")
    assert printed.err.count("\n") == 1
    rows = printed.out.splitlines()
    assert rows[0] == markdown([name for name, _, _ in COLUMNS])
    assert rows[2].startswith(f"| {FIXTURE.name} |")
    assert rows[2].endswith("| 3, right |")

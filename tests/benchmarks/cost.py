"""What ``count-video`` costs on any clips, beside what decoding them costs.

    python tests/benchmarks/cost.py fixtures/*.mp4
    python tests/benchmarks/cost.py --markdown clips/*.mp4 > table.md

Each clip is decoded and then counted, in two processes of their own, one after the other. Times are
those of all processors together, in user and in system mode, which depend little on what else the
machine does; the best of several rounds depends on it least. What is compared:

- The command: its whole process with all that it starts, from the interpreter's start to its end.
  Its modules are compiled before, as an installation does.
- Decoding: PyAV in one thread, every picture of the film once, nothing converted or copied. Only
  opening and decoding count, not the start of the interpreter, so that the ratio is not flattered.

``decodings`` is how many pictures PyAV decoded for the command, over the pictures in the clip.
``over`` is the command's time less the target: 1.3 times decoding and 1.5 s; above 0 it is missed.
Memory is the peak of the command's largest process; a peak below that of this script, some 90 MB,
would not show, as a process begins with the peak of the one that starts it. Where a clip's truth
lies beside it as ``CLIP.truth.json``, the outcome says whether the answer is right.
"""

from __future__ import annotations

import argparse
import compileall
import json
import math
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from counting_pictures import TALLY_BYTES

import count_video
from synth_video.suite.scoring import score

TARGET_RATIO = 1.3
TARGET_START_S = 1.5
"""The command may take so many times the decoding, and this on top: start and fits."""
PICTURES = Path(__file__).with_name("counting_pictures.py")
BYTES_OF_MAXRSS = 1 if sys.platform == "darwin" else 1024

DECODE = """
import json, sys, time
import av
start_s = time.process_time()
with av.open(sys.argv[1], metadata_errors="replace") as container:
    stream = container.streams.best("video")
    stream.thread_type = "NONE"
    frames, picture = 0, None
    for packet in container.demux(stream):
        try:
            for picture in stream.decode(packet):
                frames += 1
        except av.error.FFmpegError:
            continue
time_s = time.process_time() - start_s
json.dump([picture.width, picture.height, frames, time_s], sys.stdout)
"""


class UnreadableError(Exception):
    """A clip that PyAV does not decode, so that there is nothing to compare with."""


@dataclass(frozen=True)
class Decoding:
    """What decoding one clip takes."""

    width_px: int
    """Of the pictures as stored."""
    height_px: int
    frames: int
    time_s: float
    """Of all processors."""


@dataclass(frozen=True)
class Cost:
    """What one clip costs."""

    clip: Path
    decoding: Decoding
    command_s: float
    """Of all processors."""
    memory_mb: float
    """At the peak of the command's largest process."""
    pictures: int
    """How many PyAV decoded for the command."""
    outcome: str

    @property
    def ratio(self) -> float:
        """The command's time over that of decoding."""
        return self.command_s / self.decoding.time_s if self.decoding.time_s else math.inf

    @property
    def over_s(self) -> float:
        """The command's time less the target."""
        return self.command_s - TARGET_RATIO * self.decoding.time_s - TARGET_START_S

    @property
    def decodings(self) -> float:
        """How many times the clip was decoded."""
        return self.pictures / self.decoding.frames


@dataclass(frozen=True)
class Run:
    """What became of one process."""

    time_s: float
    memory_mb: float
    status: int
    """As ``subprocess`` has it: below 0 the signal that ended it."""
    stdout: str
    stderr: str


def run(*arguments: str) -> Run:
    """Run Python with these arguments to its end."""
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        process = subprocess.Popen([sys.executable, *arguments], stdout=out, stderr=err)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        out.seek(0)
        err.seek(0)
        return Run(
            time_s=usage.ru_utime + usage.ru_stime,
            memory_mb=usage.ru_maxrss * BYTES_OF_MAXRSS / 1e6,
            status=process.returncode,
            stdout=out.read().decode(errors="replace"),
            stderr=err.read().decode(errors="replace"),
        )


def decode(clip: Path) -> Decoding:
    """Decode a clip in a process of its own.

    Raises
    ------
    UnreadableError
        If that fails.
    """
    done = run("-c", DECODE, str(clip))
    if done.status:
        raise UnreadableError(f"{clip}: cannot be decoded ({_last_line(done.stderr)})")
    width_px, height_px, frames, time_s = json.loads(done.stdout)
    return Decoding(width_px, height_px, frames, time_s)


def cost_of(clip: Path, limit_s: int = 0) -> Cost:
    """Decode a clip, count it, and compare.

    Parameters
    ----------
    clip
        The file.
    limit_s
        Processor time after which the command is ended; 0 for no limit.

    Raises
    ------
    UnreadableError
        If PyAV does not decode the clip.
    """
    decoding = decode(clip)
    with tempfile.NamedTemporaryFile() as tally:
        tally.write(bytes(TALLY_BYTES))
        tally.flush()
        done = run(str(PICTURES), tally.name, str(limit_s), "--json", str(clip))
        tally.seek(0)
        pictures = int.from_bytes(tally.read(), "little")
    return Cost(clip, decoding, done.time_s, done.memory_mb, pictures, outcome_of(clip, done))


def best_of(rounds: Sequence[Cost]) -> Cost:
    """Take the shortest times of several rounds, the most memory, and all else from the last."""
    last = rounds[-1]
    decoding_s = min(cost.decoding.time_s for cost in rounds)
    return replace(
        last,
        decoding=replace(last.decoding, time_s=decoding_s),
        command_s=min(cost.command_s for cost in rounds),
        memory_mb=max(cost.memory_mb for cost in rounds),
    )


def outcome_of(clip: Path, done: Run) -> str:
    """Say what the command answered, and whether it is right where the truth is known."""
    if done.status == -signal.SIGXCPU:
        return "time-out"
    if not done.stdout.strip():
        return f"failed with {done.status}: {_last_line(done.stderr)}"
    found = json.loads(done.stdout)
    answer = str(found["count"]) if found["status"] == "counted" else "not counted"
    truth_file = clip.with_suffix(".truth.json")
    if not truth_file.exists():
        return answer
    truth: dict[str, Any] = json.loads(truth_file.read_text("utf-8"))
    judged = score(clip.stem, truth, found).outcome
    if judged == "exact":
        return f"{answer}, right"
    return f"{answer}, {'WRONG, ' if judged == 'wrong' else ''}truth {truth['count']}"


COLUMNS: Sequence[tuple[str, int, Callable[[Cost], str]]] = (
    ("clip", -34, lambda cost: cost.clip.name),
    ("size", 9, lambda cost: f"{cost.decoding.width_px}x{cost.decoding.height_px}"),
    ("frames", 6, lambda cost: f"{cost.decoding.frames}"),
    ("decoding s", 10, lambda cost: f"{cost.decoding.time_s:.2f}"),
    ("command s", 9, lambda cost: f"{cost.command_s:.2f}"),
    ("ratio", 6, lambda cost: f"{cost.ratio:.1f}"),
    ("over s", 7, lambda cost: f"{cost.over_s:+.2f}"),
    ("memory MB", 9, lambda cost: f"{cost.memory_mb:.0f}"),
    ("decodings", 9, lambda cost: f"{cost.decodings:.2f}"),
    ("outcome", -1, lambda cost: cost.outcome),
)
"""Name, width (below 0 for text, which stands on the left) and content."""


def plain(cells: Sequence[str]) -> str:
    """Write a line of the plain table."""
    aligned = [
        cell.ljust(-width) if width < 0 else cell.rjust(width)
        for cell, (_, width, _) in zip(cells, COLUMNS, strict=True)
    ]
    return "  ".join(aligned).rstrip()


def markdown(cells: Sequence[str]) -> str:
    """Write a line of the Markdown table."""
    return f"| {' | '.join(cell.replace('|', '/') for cell in cells)} |"


def head(line: Callable[[Sequence[str]], str]) -> Iterator[str]:
    """Yield the lines above the first clip."""
    yield line([name for name, _, _ in COLUMNS])
    if line is markdown:
        yield line(["---" if width < 0 else "---:" for _, width, _ in COLUMNS])


def summary(costs: Sequence[Cost]) -> Iterator[str]:
    """Yield what is worst among all clips."""
    within = sum(cost.over_s <= 0 for cost in costs)
    yield (
        f"{within} of {len(costs)} clips within {TARGET_RATIO:g} x decoding + {TARGET_START_S:g} s"
    )
    worst: Sequence[tuple[str, Callable[[Cost], float], str]] = (
        ("ratio", lambda cost: cost.ratio, ".1f"),
        ("over s", lambda cost: cost.over_s, "+.2f"),
        ("memory MB", lambda cost: cost.memory_mb, ".0f"),
        ("decodings", lambda cost: cost.decodings, ".2f"),
    )
    for name, value, form in worst:
        cost = max(costs, key=value)
        yield f"largest {name}: {value(cost):{form}} ({cost.clip.name})"


def _last_line(text: str) -> str:
    return (text.strip().splitlines() or ["no word"])[-1]


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        description="Measure what count-video costs on clips, beside decoding them."
    )
    parser.add_argument("clips", nargs="+", type=Path, metavar="CLIP")
    parser.add_argument("--markdown", action="store_true", help="write the table as Markdown")
    parser.add_argument("--rounds", type=int, default=1, help="rounds, of which the best counts")
    parser.add_argument(
        "--limit", type=int, default=0, metavar="S", help="end the command after so much time"
    )
    return parser


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure, and print a line a clip as it comes; 1 if a clip could not be decoded."""
    options = _parser().parse_args(arguments)
    compileall.compile_dir(Path(count_video.__file__).parent, quiet=1)
    line = markdown if options.markdown else plain
    costs = []
    _show(*head(line))
    for clip in options.clips:
        try:
            rounds = [cost_of(clip, options.limit) for _ in range(max(1, options.rounds))]
        except UnreadableError as error:
            sys.stderr.write(f"{error}\n")
            continue
        costs.append(best_of(rounds))
        _show(line([text(costs[-1]) for _, _, text in COLUMNS]))
    if costs:
        _show("", *summary(costs))
    return 0 if len(costs) == len(options.clips) else 1


def _show(*lines: str) -> None:
    sys.stdout.write("".join(f"{line}\n" for line in lines))
    sys.stdout.flush()


if __name__ == "__main__":
    raise SystemExit(main())

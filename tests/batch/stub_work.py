"""The work on a clip replaced by what the clip's text says.

A clip holds words: ``count N``, ``chance P``, ``ratio R``, ``sleep S``, ``die always``, ``die
once``, ``fault``, ``bad``. Every start of work is a line in the file named by the environment
variable ``STUB_LOG``.
"""

from __future__ import annotations

import os
import signal
import time
from dataclasses import replace
from pathlib import Path

from count_video import pipeline
from count_video.answers import Followed
from count_video.errors import FootageError
from count_video.progress import NO_PROGRESS, Progress
from count_video.records import TrialResult


def work_through(
    path: Path, settings: pipeline.TrialSettings, progress: Progress = NO_PROGRESS
) -> Followed:
    """Answer as the clip's words say."""
    words = path.read_text("utf-8").split()
    stated = dict(zip(words[::2], words[1::2], strict=True))
    log(path.name)
    time.sleep(float(stated.get("sleep", 0)))
    marker = path.with_suffix(".died")
    if "die" in stated and (stated["die"] == "always" or not marker.exists()):
        marker.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    if "fault" in stated:
        raise ZeroDivisionError("a fault of the program")
    if "bad" in stated:
        raise FootageError(f"{path}: the file is cut off; copy it again")
    count, chance = int(stated["count"]), float(stated.get("chance", 0.98))
    ratio = float(stated.get("ratio", 100.0))
    return Followed(
        replace(
            TrialResult(str(path), "not_counted", ""),
            status="counted",
            reason=None,
            count=count,
            seen=count,
            between_frames=0,
            probability={count: chance, count + 1: 1 - chance},
            capture_fps=settings.capture_fps,
            mass_ratio=ratio,
            mass_ratio_sigma=0.005 * ratio,
        )
    )


def log(line: str) -> None:
    """Write a line that other processes cannot tear apart."""
    place = os.environ.get("STUB_LOG")
    if place:
        descriptor = os.open(place, os.O_WRONLY | os.O_CREAT | os.O_APPEND)
        os.write(descriptor, f"{line}\n".encode())
        os.close(descriptor)

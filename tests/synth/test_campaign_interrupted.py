"""Ctrl-C in ``synth-video campaign``: it ends, and the clips that are complete stay."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from pathlib import Path

from count_video.video.reader import open_footage

PATIENCE_S = 120.0
COMMAND = "import sys; from synth_video.cli import run; sys.argv[0] = 'synth-video'; run()"


def test_ctrl_c_ends_the_rendering_and_keeps_whole_clips_alone(tmp_path: Path) -> None:
    small = ["--set", "camera.width_px=96", "--set", "camera.height_px=64"]
    arguments = ["campaign", "paper-30", str(tmp_path), "--jobs", "2", *small]
    with subprocess.Popen(
        [sys.executable, "-c", COMMAND, *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stdout is not None
        process.stdout.readline()  # the first clip is there
        began_s = time.monotonic()
        process.send_signal(signal.SIGINT)
        _, complaint = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 130
    assert complaint == "synth-video: interrupted\n", "no word of the processes' own"
    clips = list(tmp_path.glob("*.mp4"))
    assert 1 <= len(clips) < 10, f"of 30, {time.monotonic() - began_s:.0f} s after the signal"
    for clip in clips:
        with open_footage(clip) as footage:
            assert sum(1 for _ in footage.frames()) == footage.info.frames_promised
    assert [file.name for file in tmp_path.iterdir() if ".part" in file.name] == []

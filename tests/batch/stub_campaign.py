"""Campaigns of stub clips: their folder, the command as a process, and what it leaves behind."""

from __future__ import annotations

import os
import subprocess
import sys
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

COMMAND = Path(__file__).with_name("stub_command.py")


@dataclass(frozen=True)
class StubCampaign:
    """A folder of stub clips with its results beside it."""

    top: Path

    @property
    def clips(self) -> Path:
        return self.top / "clips"

    @property
    def results(self) -> Path:
        return self.top / "results"

    @property
    def log(self) -> Path:
        return self.top / "work.log"

    def add(self, **clips: str) -> None:
        """Write clips by name and words."""
        self.clips.mkdir(exist_ok=True)
        for name, words in clips.items():
            (self.clips / f"{name}.mp4").write_text(words, "utf-8")

    def start(
        self, *arguments: str, results: Path | None = None, jobs: str = "2"
    ) -> subprocess.Popen[str]:
        """Start the command on the folder of clips."""
        return subprocess.Popen(
            [
                *(sys.executable, str(COMMAND), str(self.clips)),
                *("-o", str(results or self.results), "--jobs", jobs, *arguments),
            ],
            env=os.environ | {"STUB_LOG": str(self.log), "PYTHONWARNINGS": "error"},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )

    def run(self, *arguments: str, results: Path | None = None) -> subprocess.CompletedProcess[str]:
        """Run the command to its end, with one worker: what two do is seen while they are at it."""
        with self.start(*arguments, results=results, jobs="1") as process:
            out, err = process.communicate(timeout=300)
        return subprocess.CompletedProcess(process.args, process.returncode, out, err)

    def worked(self) -> Counter[str]:
        """How often the work on each clip was begun."""
        return Counter(self.log.read_text("utf-8").split() if self.log.exists() else ())


def files_in(folder: Path) -> dict[str, bytes]:
    """All files below a folder, by their path in it; the record of them without its order."""
    return {
        str(file.relative_to(folder)): (
            b"".join(sorted(set(file.read_bytes().splitlines())))
            if file.name == "written"
            else file.read_bytes()
        )
        for file in sorted(folder.rglob("*"))
        if file.is_file()
    }

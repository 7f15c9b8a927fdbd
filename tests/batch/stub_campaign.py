"""Campaigns of stub clips: their folder, the command on them, and what it leaves behind."""

from __future__ import annotations

import io
import os
import subprocess
import sys
from collections import Counter
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import Future
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from unittest.mock import patch

from stub_work import work_through

from count_video import cli, pipeline
from count_video.batch import executor
from count_video.batch.executor import Answer
from count_video.batch.manifest import Job

COMMAND = Path(__file__).with_name("stub_command.py")
Done = subprocess.CompletedProcess[str]


def done_here(
    work: Callable[[Job], Answer], jobs: Sequence[Job], _: int | None
) -> Generator[tuple[Job, Future[Answer]], None, None]:
    """Take the place of processes: each job is done here, in its turn."""
    for job in jobs:
        future: Future[Answer] = Future()
        try:
            future.set_result(work(job))
        except Exception as fault:  # noqa: BLE001 - as a process hands it back
            future.set_exception(fault)
        yield job, future


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

    def here(self, *arguments: str, results: Path | None = None) -> Done:
        """Run the command in this process, workers and all: where processes make no difference."""
        out, err = io.StringIO(), io.StringIO()
        with (
            patch.dict(os.environ, {"STUB_LOG": str(self.log)}),
            patch.multiple(pipeline, work_through=work_through),
            patch.multiple(executor, as_done=done_here),
            redirect_stdout(out),
            redirect_stderr(err),
        ):
            clips = () if arguments and arguments[0].endswith(".csv") else (str(self.clips),)
            code = cli.main([*clips, *arguments, "-o", str(results or self.results)])
        return Done(arguments, code, out.getvalue(), err.getvalue())

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

    def run(self, *arguments: str, results: Path | None = None) -> Done:
        """Run the command to its end, with one worker: what two do is seen while they are at it."""
        with self.start(*arguments, results=results, jobs="1") as process:
            out, err = process.communicate(timeout=300)
        return Done(process.args, process.returncode, out, err)

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

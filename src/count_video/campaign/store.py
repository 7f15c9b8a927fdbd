"""The results of a campaign on disk: kept the moment they are there, found again the next time.

``NAME.json`` is a result, nothing else. What it depends on stands in ``.count-video/NAME.json``,
together with a digest of the result. That record is written first: a result without its record
cannot exist, and a record whose result never came (the power went in between) finds that the
digest does not fit. Every file is there whole or not at all. A file is written over only if this
program wrote it.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from count_video.campaign.fingerprint import settings_text, signature, text_digest, tool_version
from count_video.campaign.plan import Job
from count_video.campaign.rows import read_result
from count_video.campaign.work import Answer
from count_video.errors import UsageError
from count_video.inputs import content_digest, read_json_object, read_text
from count_video.outputs import HIDDEN, OutputFolder, held, open_outputs, write_whole
from count_video.reports.printable import storable

_MOST_BYTES = 100_000_000
"""Of a result or its record; larger ones are not ours."""


@dataclass(frozen=True)
class ResultStore:
    """A folder of results that this process alone writes to."""

    folder: Path
    fresh: bool
    """True if results of earlier runs are not to be used."""

    @cached_property
    def outputs(self) -> OutputFolder:
        """What this program wrote into the folder."""
        return OutputFolder(self.folder)

    def known(self, job: Job) -> str | None:
        """Return the result of an earlier run as its JSON text; None if it does not hold now.

        It holds while the clip's content, the options and the tool are the same, and the evidence
        that is wanted is there. A clip whose signature did not change is not read again.
        """
        record = {} if self.fresh else self._record(job)
        if not record or not self._has_wanted_evidence(job, record):
            return None
        with suppress(OSError, UsageError, ValueError):
            text = read_text(self._place(job), _MOST_BYTES).removesuffix("\n")
            now = signature(job.file)
            same_signature = record.get("signature") == now
            if text_digest(text) != record.get("result") or not (
                same_signature or content_digest(job.file) == record.get("content")
            ):
                return None
            renamed = _with_clip(text, job.clip)
            if renamed != text or not same_signature:
                self._write(job, renamed, record | {"signature": now})
            return renamed
        return None

    def evidence(self, job: Job) -> frozenset[str]:
        """Return the names of the files that show the job's kept result, as they were written."""
        evidence = self._record(job).get("evidence")
        if not isinstance(evidence, dict):
            return frozenset()
        return frozenset(name for name in evidence if evidence[name] == self._written_at(name))

    def shows_another_clip(self, job: Job) -> bool:
        """Return whether the result kept under a job's name is that of a clip elsewhere."""
        with suppress(OSError, UsageError, ValueError):
            clip = read_result(read_text(self._place(job), _MOST_BYTES))["clip"]
            content = read_json_object(self._record_place(job), _MOST_BYTES).get("content")
            elsewhere = os.path.abspath(clip) != os.path.abspath(storable(job.clip))
            return elsewhere and content_digest(job.file) != content
        return False

    def keep(self, job: Job, answer: Answer, seen: list[int]) -> None:
        """Keep an answer; one that is not final does not replace a result that may hold again.

        Parameters
        ----------
        seen
            Signature of the clip before the work on it began.

        Raises
        ------
        OSError
            If it cannot be written, for want of room for example.
        UsageError
            If it would replace a file that this program did not write.
        """
        if answer.final and answer.content is not None:
            record: dict[str, object] = {
                "tool": tool_version(),
                "options": settings_text(job.settings),
                "content": answer.content,
                "signature": seen,
                "evidence": {name: self._written_at(name) for name in answer.evidence},
            }
            self._write(job, answer.text, record)
        elif not self._record(job):
            self._record_place(job).unlink(missing_ok=True)
            self.write(self._place(job).name, answer.text + "\n")

    def write(self, name: str, text: str) -> None:
        """Write a file of the campaign, whole or not at all; raises as ``keep`` does."""
        self.outputs.write(name, text.encode("utf-8"))

    def _write(self, job: Job, text: str, record: dict[str, object]) -> None:
        self.outputs.claim(self._place(job).name, str(record["content"]))
        line = json.dumps(record | {"result": text_digest(text)}, indent=1) + "\n"
        write_whole(self._record_place(job), line.encode("utf-8"))
        write_whole(self._place(job), f"{text}\n".encode())

    def _record(self, job: Job) -> dict[str, object]:
        """Return what the kept result depends on; empty unless options and tool are the same."""
        try:
            record = read_json_object(self._record_place(job), _MOST_BYTES)
        except UsageError:
            return {}
        wanted = (tool_version(), settings_text(job.settings))
        return record if (record.get("tool"), record.get("options")) == wanted else {}

    def _has_wanted_evidence(self, job: Job, record: dict[str, object]) -> bool:
        if job.pages is None:
            return True
        written = record.get("evidence")
        there = self.evidence(job)
        if not isinstance(written, dict) or there != written.keys() or not there:
            return False
        # A clip in which no bodies were found has a page alone.
        return len(there) == 1 or f"{job.name}.{job.pages.picture_format}" in there

    def _written_at(self, name: str) -> list[int] | None:
        """Size and time of the last change of a file; None if it is not there."""
        try:
            stat = os.stat(self.folder / name)
        except (OSError, ValueError):
            return None
        return [stat.st_size, stat.st_mtime_ns]

    def _place(self, job: Job) -> Path:
        return self.folder / f"{job.name}.json"

    def _record_place(self, job: Job) -> Path:
        return self.folder / HIDDEN / f"{job.name}.json"


@contextmanager
def open_store(folder: Path, own: Iterable[str] = (), *, fresh: bool) -> Iterator[ResultStore]:
    """Open a folder for results, made if needed, for this process alone.

    Parameters
    ----------
    own
        Names of the campaign's own files, which must be free or written by this program.

    Raises
    ------
    UsageError
        The folder cannot be made, another run is at work in it, or a file is in the way.
    """
    outputs = open_outputs(folder)
    with held(outputs.hidden / "lock"):
        for name in own:
            outputs.check(name)
        yield ResultStore(folder, fresh)


def _with_clip(text: str, clip: str) -> str:
    """Put the clip's present path into a result; ValueError if the text is none."""
    result = read_result(text)
    path = storable(clip)
    return text if result["clip"] == path else json.dumps(result | {"clip": path})

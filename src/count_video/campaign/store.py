"""The results of a campaign on disk: kept the moment they are there, found again the next time.

``NAME.json`` is a result, nothing else. What it depends on stands in ``.count-video/NAME.json``,
together with a digest of the result. That record is written first: a result without its record
cannot exist, and a record whose result never came (the power went in between) finds that the
digest does not fit. Every file is written beside its place, flushed to the disk and renamed, so
that it is there whole or not at all.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from count_video.campaign.fingerprint import (
    content_digest,
    settings_text,
    signature,
    text_digest,
    tool_version,
)
from count_video.campaign.lock import held
from count_video.campaign.plan import Job
from count_video.campaign.work import Answer
from count_video.errors import UsageError

HIDDEN = ".count-video"


@dataclass(frozen=True)
class ResultStore:
    """A folder of results that this process alone writes to."""

    folder: Path
    fresh: bool
    """True if results of earlier runs are not to be used."""

    def known(self, job: Job) -> str | None:
        """Return the result of an earlier run as its JSON text; None if it does not hold now.

        It holds while the clip's content, the options and the tool are the same. A clip whose
        signature did not change is not read again.
        """
        record = None if self.fresh else self._record(job)
        if record is None:
            return None
        with suppress(OSError, UnicodeDecodeError):
            text = self._place(job).read_text("utf-8").removesuffix("\n")
            now = signature(job.file)
            same_signature = record.get("signature") == now
            if text_digest(text) != record.get("result") or not (
                same_signature or content_digest(job.file) == record.get("content")
            ):
                return None
            renamed = _with_clip(text, job.clip)
            if renamed != text or not same_signature:
                self._write(job, renamed, str(record["content"]), now)
            return renamed
        return None

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
        """
        if answer.final and answer.content is not None:
            self._write(job, answer.text, answer.content, seen)
        elif self._record(job) is None:
            self._record_place(job).unlink(missing_ok=True)
            self.write(self._place(job).name, answer.text + "\n")

    def write(self, name: str, text: str) -> None:
        """Write a file of the campaign, whole or not at all.

        Raises
        ------
        OSError
            If it cannot be written.
        """
        self._write_whole(self.folder / name, text)

    def _write(self, job: Job, text: str, content: str, seen: list[int]) -> None:
        record = {
            "tool": tool_version(),
            "options": settings_text(job.settings),
            "content": content,
            "signature": seen,
            "result": text_digest(text),
        }
        self._write_whole(self._record_place(job), json.dumps(record, indent=1) + "\n")
        self._write_whole(self._place(job), text + "\n")

    def _write_whole(self, place: Path, text: str) -> None:
        # One writer at a time, so one name will do; what a kill leaves there is overwritten.
        partial = self.folder / HIDDEN / "partial"
        with partial.open("w", encoding="utf-8", newline="\n") as stream:
            stream.write(text)
            stream.flush()
            os.fsync(stream.fileno())
        os.replace(partial, place)
        _flush_folder(place.parent)

    def _record(self, job: Job) -> dict[str, object] | None:
        """Return what the kept result depends on; None unless options and tool are the same."""
        try:
            record = json.loads(self._record_place(job).read_text("utf-8"))
        except (OSError, ValueError):
            return None
        if not isinstance(record, dict) or record.get("tool") != tool_version():
            return None
        return record if record.get("options") == settings_text(job.settings) else None

    def _place(self, job: Job) -> Path:
        return self.folder / f"{job.name}.json"

    def _record_place(self, job: Job) -> Path:
        return self.folder / HIDDEN / f"{job.name}.json"


@contextmanager
def open_store(folder: Path, *, fresh: bool) -> Iterator[ResultStore]:
    """Open a folder for results, made if needed, for this process alone.

    Raises
    ------
    UsageError
        The folder cannot be made, or another run is at work in it.
    """
    try:
        (folder / HIDDEN).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UsageError(f"{folder}: no folder for results ({error.strerror})") from error
    with held(folder / HIDDEN / "lock"):
        yield ResultStore(folder, fresh)


def _with_clip(text: str, clip: str) -> str:
    """Put the clip's present path into a result."""
    result = json.loads(text)
    path = clip.encode("utf-8", "backslashreplace").decode("utf-8")
    return text if result.get("clip") == path else json.dumps(result | {"clip": path})


def _flush_folder(folder: Path) -> None:
    """Make a renaming last through a power cut, where the system can."""
    with suppress(OSError):  # Windows opens no folders, and needs this not
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)

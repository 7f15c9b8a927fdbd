"""The results of a campaign on disk: kept the moment they are there, found again the next time.

``NAME.json`` is a result, nothing else. ``.count-video/NAME.jsonl`` has a line with what it depends
on, and one with the result and what was followed, from which pages can be drawn later. It is
written first: a result without it cannot exist, and one that never came (the power went in
between) or was changed is not that of the line. Every file is there whole or not at all; a result
that lost its other file is counted again. A file is written over only if this program wrote it.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass, is_dataclass, replace
from pathlib import Path
from types import UnionType
from typing import Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

import numpy as np

from count_video.answers import Followed
from count_video.batch.executor import Answer, tool_version
from count_video.batch.manifest import Job
from count_video.errors import UsageError
from count_video.inputs import content_digest, json_value, read_text, regular_file, signature
from count_video.outputs import OutputFolder, held, open_outputs, write_whole
from count_video.reports.campaign import CampaignSummary, TrialRow
from count_video.reports.exports import campaign_json, json_line, trials_csv
from count_video.reports.words import storable
from count_video.settings import CsvDialect, PictureFormat

OWN_FILES = ("campaign.html", "trials.csv", "campaign.json", "campaign.{}")
"""What belongs to a campaign as a whole; the last is the picture, by its format."""
_Record = TypeVar("_Record")
_MOST_BYTES = 100_000_000
"""Of a file that is kept; larger ones are not ours."""


@dataclass(frozen=True)
class ResultStore:
    """A folder of results that this process alone writes to."""

    outputs: OutputFolder
    fresh: bool
    """True if results of earlier runs are not to be used."""

    def recall(self, job: Job) -> TrialRow | Job:
        """Return the row of an earlier run if it holds, or what is left to do of the job."""
        found = self.known(job)
        if found is None:
            return job
        kept, there = self._kept(job), self.evidence(job)
        if job.pages is not None and kept.get("read"):
            # A clip in which no bodies were found has a page alone.
            pictured = len(there) == 1 or f"{job.name}.{job.pages.picture_format}" in there
            pictured &= kept.get("dialect") == job.pages.csv_dialect
            if not pictured or there != kept["evidence"].keys():
                return replace(job, found=found)
        return TrialRow(job.name, found.result, job.settings.masses, files=there)

    def known(self, job: Job) -> Followed | None:
        """Return what an earlier run counted and followed; None if it does not hold now.

        It holds while the clip's content, the options and the tool are the same. A clip whose
        signature did not change is not read again.
        """
        kept = {} if self.fresh else self._kept(job)
        with suppress(OSError, UsageError, ValueError, LookupError):
            found = unpacked(Followed, read_text(self._kept_place(job), _MOST_BYTES).split("\n")[1])
            if read_text(self._place(job), _MOST_BYTES) != f"{json_line(found.result)}\n":
                return None
            now = signature(job.file)
            same = kept["signature"] == list(now)
            if not same and content_digest(job.file) != kept["clip"]:
                return None
            renamed = replace(found, result=replace(found.result, clip=job.clip))
            if renamed.result.clip != found.result.clip or not same:
                self._write(job, {**kept, "signature": now}, renamed)
            return renamed
        return None

    def evidence(self, job: Job) -> frozenset[str]:
        """Return the names of the files that show the job's kept result, as they were written."""
        files = self._kept(job).get("evidence", {}).items()
        return frozenset(name for name, at in files if at and at == self._written_at(name))

    def shows_another_clip(self, job: Job) -> bool:
        """Return whether the result kept under a job's name is that of a clip elsewhere."""
        with suppress(OSError, UsageError, ValueError, LookupError, TypeError):
            clip = str(json_value(read_text(self._place(job), _MOST_BYTES))["clip"])
            elsewhere = os.path.abspath(clip) != os.path.abspath(storable(job.clip))
            return elsewhere and self.outputs.shows_another_clip(f"{job.name}.json", job.file)
        return False

    def keep(self, job: Job, answer: Answer) -> None:
        """Keep an answer; one that is not final does not replace a result that may hold again.

        Raises as :meth:`OutputFolder.claim` does.
        """
        found = answer.result.followed
        if answer.final:
            kept = {"clip": answer.content, **_made_with(job)}
            kept |= {"signature": answer.result.signature, "read": answer.result.error is None}
            kept["dialect"] = job.pages and job.pages.csv_dialect
            kept["evidence"] = {name: self._written_at(name) for name in answer.evidence}
            self._write(job, kept, found)
        elif not self._kept(job):
            self.outputs.write(self._place(job).name, f"{json_line(found.result)}\n".encode())

    def write_campaign(
        self,
        rows: Sequence[TrialRow],
        summary: CampaignSummary,
        picture_format: PictureFormat,
        csv_dialect: CsvDialect,
    ) -> Iterator[str]:
        """Write what the trials say together, each file whole or not at all; yield their names."""
        self.outputs.write("trials.csv", trials_csv(rows, csv_dialect).encode())
        yield "trials.csv"
        self.outputs.write("campaign.json", campaign_json(rows, summary).encode())
        yield "campaign.json"
        from count_video.reports.figure import campaign_files  # noqa: PLC0415 - matplotlib

        for name, content in campaign_files(rows, summary, picture_format).items():
            self.outputs.write(name, content)
            yield name

    def _write(self, job: Job, kept: Mapping[str, Any], found: Followed) -> None:
        self.outputs.claim(self._place(job).name, str(kept["clip"]))
        text = f"{json.dumps(kept)}\n{packed(found)}\n"
        write_whole(self._kept_place(job), text.encode("ascii"))
        write_whole(self._place(job), f"{json_line(found.result)}\n".encode("ascii"))

    def _kept(self, job: Job) -> Mapping[str, Any]:
        """Return what the kept result depends on; empty unless options and tool are the same."""
        with suppress(OSError, UsageError, ValueError), regular_file(self._kept_place(job)) as file:
            kept = json_value(file.readline(_MOST_BYTES))
            if isinstance(kept, dict) and isinstance(kept.get("evidence"), dict):
                return kept if _made_with(job).items() <= kept.items() else {}
        return {}

    def _written_at(self, name: str) -> list[int]:
        """Size and time of the last change of a file, as JSON has them; empty if it is missing."""
        return list(signature(self.outputs.folder / name)[:2])

    def _place(self, job: Job) -> Path:
        return self.outputs.folder / f"{job.name}.json"

    def _kept_place(self, job: Job) -> Path:
        return self.outputs.hidden / f"{job.name}.jsonl"


@contextmanager
def open_store(folder: Path, own: Iterable[str] = (), *, fresh: bool) -> Iterator[ResultStore]:
    """Open a folder for results, made if needed, for this process alone.

    UsageError if that fails, another run is at work in it, or one of the campaign's ``own`` files
    is somebody else's.
    """
    outputs = open_outputs(folder, own)
    with held(outputs.hidden / "lock"):
        yield ResultStore(outputs, fresh)


def _made_with(job: Job) -> dict[str, Any]:
    """Return tool and options, as texts that are the same for the same ones."""
    options = json.dumps(asdict(job.settings), default=str, sort_keys=True)
    return {"tool": tool_version(), "options": options}


# ---- records as text -----------------------------------------------------------------------------
# Text for this program alone, in Python's JSON, which has NaN: records are objects by the names
# of their fields, arrays are lists. What another version wrote may not fit, and is then of no use.


def packed(record: Any) -> str:
    """Write a record as text."""
    return json.dumps(asdict(record), default=lambda array: array.tolist())


def unpacked(kind: type[_Record], text: str) -> _Record:
    """Read a record of some kind from text; ValueError if it is none, or of another version."""
    try:
        found: _Record = _unpacked(kind, json_value(text))
    except (TypeError, LookupError, AttributeError, OverflowError) as error:
        raise ValueError(f"no {kind.__name__}: {error}") from error
    return found


def _unpacked(kind: Any, value: Any) -> Any:  # noqa: PLR0911 - a kind a line
    """Make a value of a kind, as a type hint names it."""
    origin, parts = get_origin(kind), get_args(kind)
    if origin in (Union, UnionType):
        return None if value is None else _unpacked(parts[0], value)
    if kind is float:
        return float(value)
    if isinstance(kind, type) and is_dataclass(kind):
        kinds = get_type_hints(kind)
        return kind(**{name: _unpacked(kinds[name], one) for name, one in value.items()})
    if origin is np.ndarray:
        return np.array(value, np.float64)
    if origin is tuple:
        return tuple(_unpacked(parts[0], one) for one in value)
    if origin is dict:
        return {parts[0](key): _unpacked(parts[1], one) for key, one in value.items()}
    if value not in parts if origin is Literal else not isinstance(value, kind):
        raise ValueError(f"{value!r} is no {kind}")
    if kind is int and abs(value) > sys.maxsize:
        raise ValueError("a number that nothing has")
    return value

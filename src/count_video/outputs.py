"""Files that this program writes: each whole or not at all, and never over a file of somebody else.

What was written into a folder stands in its record, ``.count-video/written``: a line of JSON for
each file, with its name and the digest of the clip that it shows. The line is there before the file
is, so a file without one is not ours: it is not replaced, and nothing that has one is taken for a
clip. Lines are only ever added, in one write each, so that many processes may do so at once.

A file is written beside its place under a name such as ``.0f3a….part.mp4``, flushed to the disk and
renamed. Whoever writes it holds a lock on it; what nobody holds was left by a process that was
killed, and goes when a folder is opened again.
"""

from __future__ import annotations

import errno
import hashlib
import json
import os
import re
import stat
import sys
import uuid
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from count_video.errors import OutputError, UsageError
from count_video.inputs import content_digest, json_value

if sys.platform == "win32":
    import msvcrt

    _UNUSED_BYTE = 2**31 - 2

    def _take(descriptor: int, *, wait: bool = False) -> None:
        os.lseek(descriptor, _UNUSED_BYTE, os.SEEK_SET)  # nobody else may write a locked one
        msvcrt.locking(descriptor, msvcrt.LK_LOCK if wait else msvcrt.LK_NBLCK, 1)
else:
    import fcntl

    def _take(descriptor: int, *, wait: bool = False) -> None:
        fcntl.flock(descriptor, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))


HIDDEN = ".count-video"
LONGEST_NAME_BYTES = 238
"""File systems take 255; ``.phase-circle.png`` is added to it."""
_RECORD = "written"
_MOST_RECORD_BYTES = 100_000_000
"""A longer one is not ours: what stands behind that is not believed."""
_NO_LINK = getattr(os, "O_NOFOLLOW", 0)
_UNFINISHED = re.compile(r"\.[0-9a-f]{12}\.part(\..*)?")
_unfinished: set[Path] = set()
"""Files that this process is writing."""


class OutputFolder:
    """A folder that results go to."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.hidden = folder / HIDDEN
        """Where the folder keeps what only this program reads."""
        self._written: dict[str, str] = {}
        self._read_to = 0

    def written(self) -> Mapping[str, str]:
        """Return what this program wrote here: digests of clips by the names of files."""
        with suppress(OSError):  # nothing yet
            with open(_open_own(self.hidden / _RECORD, os.O_RDONLY), "rb") as record:
                record.seek(self._read_to)
                more = record.read(_MOST_RECORD_BYTES - self._read_to)
            lines, newline, _ = more.rpartition(b"\n")
            self._read_to += len(lines + newline)
            for line in lines.splitlines():
                with suppress(ValueError, LookupError, TypeError):  # torn as the power went
                    entry = json_value(line)
                    self._written[str(entry["name"])] = str(entry["clip"])
        return self._written

    def shows_another_clip(self, name: str, clip: Path) -> bool:
        """Return whether the file of this name shows another clip.

        OSError or UsageError if the clip cannot be read.
        """
        shown = self.written().get(name)
        return bool(shown) and (self.folder / name).exists() and shown != content_digest(clip)

    def check(self, name: str) -> None:
        """Raise UsageError if a file or folder of this name is there that we did not write."""
        place = self.folder / name
        if os.path.lexists(place) and (name not in self.written() or os.path.isdir(place)):
            raise UsageError(
                f"{place}: this was not written by this program; move it away, or give another "
                "folder with -o"
            )

    def claim(self, name: str, clip: str = "") -> None:
        """Put a file on record that is about to be written.

        ``clip`` is the digest of the clip that it shows; empty where it shows none or many. Raises
        as :meth:`check` does, and OSError if the record cannot be written.
        """
        self.check(name)
        if self.written().get(name) != clip:
            line = json.dumps({"name": name, "clip": clip}).encode("ascii")
            flags = os.O_WRONLY | os.O_APPEND | os.O_CREAT
            with open(_open_own(self.hidden / _RECORD, flags), "wb") as record:
                record.write(b"\n" + line + b"\n")

    def write(self, name: str, data: bytes, clip: str = "") -> None:
        """Claim and write a file; raises as :meth:`claim` does."""
        self.claim(name, clip)
        write_whole(self.folder / name, data)

    def write_all(self, files: Iterable[tuple[str, bytes]], clip: str = "") -> None:
        """Write files by their names.

        OutputError if one cannot be written, UsageError if it is not ours.
        """
        for name, data in files:
            with explained(self.folder / name):
                self.write(name, data, clip)


def open_outputs(folder: Path, names: Iterable[str] = ()) -> OutputFolder:
    """Open a folder for results, made if needed, and clear away what killed processes left.

    UsageError if that fails, or if one of the ``names`` to be written is a file of somebody else.
    """
    hidden = folder / HIDDEN
    try:
        hidden.mkdir(parents=True, exist_ok=True)
        if not stat.S_ISDIR(hidden.lstat().st_mode):  # a link leads somewhere else
            raise NotADirectoryError(0, f"{HIDDEN} in it is no folder")
        clear_unfinished(folder)
        clear_unfinished(hidden)
    except OSError as error:
        raise _no_folder(folder, error) from error
    outputs = OutputFolder(folder)
    for name in names:
        outputs.check(name)
    return outputs


def without_own(clips: Sequence[Path]) -> list[Path]:
    """Leave out clips that this program drew, by the record of their folder.

    UsageError if clips are given and all are such ones.
    """
    written = {folder: OutputFolder(folder).written() for folder in {one.parent for one in clips}}
    # A table of ours may be meant as a manifest, which is refused with its own reason.
    others = [
        one for one in clips if one.suffix.lower() == ".csv" or one.name not in written[one.parent]
    ]
    if clips and not others:
        raise UsageError(f"{clips[0]}: this program drew this; give the clip that was filmed")
    return others


def output_name(wanted: str) -> str:
    """Return the name of a clip's results: what is wanted, as far as every system can hold it.

    It needs no escape in a table or a link, and the longest ending of a result still fits.
    """
    name = "".join(sign if sign.isprintable() and sign not in "/\\" else "_" for sign in wanted)
    if name.startswith("."):
        name = f"_{name[1:]}"
    if len(name.encode("utf-8")) > LONGEST_NAME_BYTES:
        mark = f"~{hashlib.sha256(wanted.encode('utf-8', 'surrogatepass')).hexdigest()[:8]}"
        name = name.encode("utf-8")[: LONGEST_NAME_BYTES - len(mark)].decode("utf-8", "ignore")
        name += mark
    return name


def write_whole(target: Path, data: bytes) -> None:
    """Write a file, whole or not at all."""
    with appearing(target) as partial:
        partial.write_bytes(data)


@contextmanager
def appearing(target: Path) -> Iterator[Path]:
    """Yield a place to write to; what is there appears under its name when all went well."""
    partial = target.with_name(f".{uuid.uuid4().hex[:12]}.part{target.suffix}")
    _unfinished.add(partial)
    try:
        with open(partial, "xb") as file:
            with suppress(OSError):  # a file system without locks: then it stays if we are killed
                _take(file.fileno())
            yield partial
            os.fsync(file)
            if sys.platform == "win32":
                file.close()  # which renames no open file
            os.replace(partial, target)
        with suppress(OSError):  # the renaming lasts through a power cut; Windows needs this not
            folder = os.open(target.parent, os.O_RDONLY)
            try:
                os.fsync(folder)
            finally:
                os.close(folder)
    finally:
        partial.unlink(missing_ok=True)
        _unfinished.discard(partial)


def discard_unfinished() -> None:
    """Take away what this process is writing, before it ends at once."""
    for partial in list(_unfinished):
        with suppress(OSError):
            partial.unlink()


def clear_unfinished(folder: Path) -> None:
    """Take away unfinished files that nobody writes to any more."""
    for entry in folder.iterdir():
        if _UNFINISHED.fullmatch(entry.name):
            # Somebody is at work on it, or has just finished.
            with suppress(OSError):
                with open(_open_own(entry, os.O_RDWR), "rb") as file:
                    _take(file.fileno())
                entry.unlink()


@contextmanager
def held(file: Path, *, wait: bool = False) -> Iterator[None]:
    """Hold the lock on a file (made if needed, and left there: only the lock itself counts).

    The system lets go of the lock when the process ends, however it ends; workers do not inherit
    it. UsageError if the file cannot be made; unless it is to ``wait``, also if somebody else holds
    it, or the file system cannot lock.
    """
    folder = file.parent.parent
    try:
        descriptor = _open_own(file, os.O_RDWR | os.O_CREAT)
    except OSError as error:
        raise _no_folder(folder, error) from error
    with os.fdopen(descriptor, "rb"):
        try:
            _take(descriptor, wait=wait)
        except OSError as error:
            why = f"this folder cannot be locked ({error.strerror}); give one on another disk with"
            if isinstance(error, BlockingIOError | PermissionError):
                why = "another run is at work in this folder; wait for its end, or give another "
                why += "folder with"
            if not wait:
                raise UsageError(f"{folder}: {why} -o") from error
        yield


def _no_folder(folder: Path, error: OSError) -> UsageError:
    helps = remedy(error, "give another folder with -o")
    return UsageError(f"{folder}: no folder for results ({error.strerror}); {helps}")


@contextmanager
def explained(target: Path) -> Iterator[None]:
    """Turn an OSError, met while a file is written, into an OutputError of one line."""
    try:
        yield
    except OSError as error:
        reason = error.strerror or "it failed"
        helps = remedy(error, "give another folder")
        raise OutputError(f"cannot write {target}: {reason}; {helps}") from error


def remedy(error: Exception, otherwise: str) -> str:
    """Say what to do where a file cannot be written: ``otherwise``, unless the disk is full."""
    full = getattr(error, "errno", None) == errno.ENOSPC
    return "free space on that disk and start again" if full else otherwise


def _open_own(file: Path, flags: int) -> int:
    """Open a regular file of this program; no link is followed, and no pipe waited for."""
    descriptor = os.open(file, flags | _NO_LINK | getattr(os, "O_NONBLOCK", 0), 0o666)
    if not stat.S_ISREG(os.fstat(descriptor).st_mode):
        os.close(descriptor)
        raise FileExistsError(0, f"{HIDDEN}/{file.name} in it is no regular file")
    return descriptor

"""The command as a process, and the laws that every answer of it obeys."""

from __future__ import annotations

import contextlib
import json
import os
import re
import resource
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from count_video.records import TrialResult
from count_video.reports.exports import json_object

KEYS = frozenset(json_object(TrialResult("", "not_counted", "")))
CONTROL = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u2028\u2029\u202a-\u202e]")
MOST_BYTES = 1 << 30
POLL_S = 0.005
PATIENCE_S = 300.0
"""After so long a run hangs; how fast an answer comes is measured elsewhere."""
PROGRAM = (sys.executable, "-m", "count_video")
ENDINGS = (signal.SIGINT, signal.SIGTERM, getattr(signal, "SIGHUP", signal.SIGTERM))


@dataclass(frozen=True)
class Answer:
    """What came of a run."""

    code: int
    out: str
    err: str
    most_bytes: int
    """Memory held at the most."""


def start(
    *arguments: object,
    environment: Mapping[str, str] | None = None,
    closed: tuple[int, ...] = (),
    limits: Mapping[str, int] | None = None,
    **streams: object,
) -> subprocess.Popen[bytes]:
    """Start the command; ``closed`` are descriptors that it begins without.

    ``limits`` are those of ``resource``, such as RLIMIT_AS, by their names.
    """

    def before() -> None:
        for name, limit in (limits or {}).items():
            resource.setrlimit(getattr(resource, name), (limit, limit))
        for ending in ENDINGS:  # a shell in the background lets all that it starts ignore some
            signal.signal(ending, signal.SIG_DFL)
        for descriptor in closed:
            os.close(descriptor)

    return subprocess.Popen(  # type: ignore[call-overload, no-any-return]
        [*PROGRAM, *(os.fsencode(argument) for argument in arguments)],  # type: ignore[arg-type]
        env=os.environ | (environment or {}),
        preexec_fn=before,  # noqa: PLW1509 - the tests that start it have no threads
        **{"stdin": subprocess.DEVNULL, **streams},
    )


def ask(
    *arguments: object,
    during: Callable[[subprocess.Popen[bytes]], object] | None = None,
    **settings: object,
) -> Answer:
    """Run the command to its end; ``during`` may do harm meanwhile."""
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        streams = {"stdout": out, "stderr": err} | settings
        process = start(*arguments, **streams)  # type: ignore[arg-type]
        if during is not None:
            during(process)
        most_bytes = _ended(process)
        objects_read = [stream.seek(0) or stream.read().decode("utf-8") for stream in (out, err)]
    return Answer(process.returncode, objects_read[0], objects_read[1], most_bytes)


def _ended(process: subprocess.Popen[bytes]) -> int:
    """Wait for the end of a run, which is killed if it hangs; return the memory it held, in bytes.

    The system's own count of it, ru_maxrss, begins with what the tests held when they started the
    run; the high-water mark of a process begins with its program.
    """
    deadline = time.monotonic() + PATIENCE_S
    most_bytes = 0
    while process.poll() is None:
        with contextlib.suppress(OSError):
            status = Path(f"/proc/{process.pid}/status").read_text("utf-8")
            held = re.search(r"^VmHWM:\s+(\d+) kB", status, re.MULTILINE)
            most_bytes = max(most_bytes, 1024 * int(held[1]) if held else 0)
        if time.monotonic() > deadline:
            process.kill()
        time.sleep(POLL_S)
    return most_bytes


def faults_of(answer: Answer, objects: int | None = None) -> list[str]:
    """List the laws that an answer breaks; ``objects`` is how many JSON objects it must hold."""
    lines = answer.err.splitlines()
    broken = {
        f"exit code {answer.code}": answer.code not in (0, 1, 2),
        "traceback": "Traceback" in answer.err + answer.out,
        f"stderr: {answer.err[:200]}": any(not line.startswith("count-video: ") for line in lines),
        "control codes": bool(CONTROL.search(answer.err + answer.out)),
        f"{answer.most_bytes >> 20} MB": answer.most_bytes > MOST_BYTES,
        "not a word": answer.code != 0 and not answer.err and not answer.out,
        "a line without end": any(len(line) > 5000 for line in lines),
    }
    found = [fault for fault, there in broken.items() if there]
    return found if objects is None else [*found, *_faults_of_json(answer, objects)]


def _faults_of_json(answer: Answer, objects: int) -> list[str]:
    try:
        objects_read = [
            json.loads(line, parse_constant=_no_number) for line in answer.out.splitlines()
        ]
    except ValueError as error:
        return [f"no JSON: {error}"]
    if answer.code == 2 and not objects_read:  # the request was wrong: nothing was done
        return []
    refused = sum(one["status"] == "not_counted" for one in objects_read if "status" in one)
    broken = {
        f"{len(objects_read)} objects, not {objects}": len(objects_read) != objects,
        "keys differ": any(set(one) != KEYS for one in objects_read),
        "no reason": any(
            one.get("status") != "counted" and not one.get("reason") for one in objects_read
        ),
        "exit code 0 without a count": answer.code == 0 and refused > 0,
        "not one line a clip": len(answer.err.splitlines()) != refused,
    }
    return [fault for fault, there in broken.items() if there]


def _no_number(name: str) -> None:
    raise ValueError(f"{name} is no JSON")


def unfinished(folder: Path) -> list[str]:
    """List what a run that was ended left half written."""
    return [file.name for file in folder.rglob("*") if ".part" in file.name]

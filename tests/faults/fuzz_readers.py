"""Search for files on which a reader fails: ``python tests/faults/fuzz_readers.py --minutes 20``.

Each case is a sound file, damaged by its seed. It is read in a process of its own kind, so that a
crash, a hang or a hunger for memory is seen as well. What is found is kept in ``corpus/``, where
``test_readers.py`` reads it again for ever. Exit code 1 if anything is found.
"""

from __future__ import annotations

import argparse
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from mutations import mutated
from readers import READERS, refusal

CORPUS = Path(__file__).with_name("corpus")
CASES_A_PROCESS = 200
SECONDS_A_CASE = 20
MOST_BYTES = 1 << 30


def main() -> int:
    """Fuzz for the minutes asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=1.0)
    parser.add_argument("--seed", type=int, default=0, help="first seed (default: 0)")
    parser.add_argument("--worker", nargs=2, help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.worker:
        work(asked.worker[0], asked.seed, Path(asked.worker[1]))
        return 0
    end, seed, found = time.monotonic() + 60 * asked.minutes, asked.seed, 0
    while time.monotonic() < end:
        for name in READERS:
            found += batch(name, seed)
        seed += CASES_A_PROCESS
    cases = (seed - asked.seed) * len(READERS)
    print(
        f"{cases} cases of {len(READERS)} readers, seeds {asked.seed} to {seed - 1}: {found} found"
    )
    return 1 if found else 0


def batch(name: str, seed: int) -> int:
    """Read a batch of cases in a process; keep the case that ends it. Return how many there are."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, __file__, "--seed", str(seed), "--worker", name, folder]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode == 0:
            return 0
        case = Path(folder, READERS[name].file)
        kept = CORPUS / f"{name}-{Path(folder, 'seed').read_text('ascii')}{case.suffix}"
        CORPUS.mkdir(exist_ok=True)
        shutil.copy(case, kept)
    last = (done.stderr.strip().splitlines() or ["without a word"])[-1]
    print(f"found {kept.name} (exit code {done.returncode}): {last}", flush=True)
    return 1


def work(name: str, seed: int, folder: Path) -> None:
    """Read the cases of a batch; whatever is raised ends the process."""
    reader = READERS[name]
    case = folder / reader.file
    reader.sound(case)
    sound = case.read_bytes()
    refusal(reader, case)
    resource.setrlimit(resource.RLIMIT_DATA, (4 * MOST_BYTES, 4 * MOST_BYTES))
    for number in range(seed, seed + CASES_A_PROCESS):
        case.write_bytes(mutated(sound, number))
        Path(folder, "seed").write_text(str(number), "ascii")
        signal.alarm(SECONDS_A_CASE)
        refused = refusal(reader, case)
        signal.alarm(0)
        if "\n" in refused:
            raise ValueError(f"more than one line: {refused!r}")
        held = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
        if held > MOST_BYTES:
            raise MemoryError(f"{held >> 20} MB")


if __name__ == "__main__":
    sys.exit(main())

"""docs/accuracy.md's table of collision times over the shutter: run this file to print it anew.

``python tests/counted/shutter_study.py 10`` renders ten clean, resolved trials three times over,
with the shutter open for next to nothing, for half and for all of the time between two frames, and
sets the collisions found beside the true ones. Times refer to the centre of the exposure: a clip
must not seem to be early or late by how long its shutter was open.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from count_video.motion.seen import seen_collisions
from count_video.records import Floats
from count_video.tracking.observation import observe
from count_video.tracking.pairing import pair_tracks
from count_video.tracking.view import view_of
from count_video.video.reader import open_footage
from synth_video.film import render_clip
from synth_video.suite.scoring import match
from synth_video.suite.suites import conditions_of

SHUTTERS = (0.02, 0.5, 1.0)
"""Open for these parts of the time between two frames."""


@dataclass(frozen=True)
class TimeErrors:
    """How far off the times of some clips' collisions are, found less true, in frames."""

    signed: Floats
    missed: int
    """True collisions without a found one."""

    @property
    def mean(self) -> float:
        """Mean signed error: the bias."""
        return float(self.signed.mean())

    @property
    def mean_sigma(self) -> float:
        """Standard error of the mean."""
        return float(self.signed.std(ddof=1) / np.sqrt(len(self.signed)))


def time_errors(numbers: Sequence[int], shutter: float, folder: Path) -> TimeErrors:
    """Film clean trials of the suite with a shutter; the errors of their bursts' collisions."""
    (clean,) = conditions_of("light", ["clean"])
    errors: list[float] = []
    missed = 0
    for number in numbers:
        scene = clean.scene("ordinary", number)
        scene = replace(scene, camera=replace(scene.camera, shutter=shutter))
        clip = folder / f"{number}.mp4"
        truth = render_clip(scene, clean.seed(number), clip)
        with open_footage(clip) as footage, observe(view_of(footage)) as bodies:
            seen = seen_collisions(pair_tracks(bodies.movers, bodies.frames, bodies.view)[0])
        true = [event.frame for event in truth.events]
        found = [collision.frame for collision in seen.collisions[: seen.burst]]
        pairs = match(true, found)
        errors += [found[mine] - true[theirs] for theirs, mine in pairs]
        missed += len(true) - len(pairs)
    return TimeErrors(np.array(errors), missed)


def table(rows: Sequence[tuple[float, TimeErrors]]) -> str:
    """Write errors by shutter as a Markdown table."""
    lines = [
        "| shutter open | collisions | missed | mean signed error | median error | 95 % |",
        "|---:|---:|---:|---:|---:|---:|",
    ]
    for shutter, errors in rows:
        median, most = np.quantile(np.abs(errors.signed), [0.5, 0.95])
        lines.append(
            f"| {shutter:.0%} | {len(errors.signed)} | {errors.missed} "
            f"| {errors.mean:+.4f} ± {errors.mean_sigma:.4f} | {median:.3f} | {most:.3f} |"
        )
    return "\n".join(lines)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the study and print its table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("clips", type=int, help="trials with each shutter")
    options = parser.parse_args(arguments)
    rows = []
    for shutter in SHUTTERS:
        with tempfile.TemporaryDirectory() as folder:
            rows.append((shutter, time_errors(range(options.clips), shutter, Path(folder))))
    sys.stdout.write(f"{table(rows)}\n")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())

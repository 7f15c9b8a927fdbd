"""Film random trials near 1:100, count them with the whole command, and print the tables.

``python tests/between/filmed_study.py 42 clips/`` renders 42 clips of the plain scene into a folder
(clips that are there already are kept) and compares counts, mass ratios and restitutions with the
truth. It takes some seconds a clip.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np
from synthetic_tracks import random_setup

from count_video.motion.fitted import Between
from count_video.physics.setup import Setup
from count_video.physics.simulator import Motion, simulate
from count_video.pipeline import TrialSettings, work_through
from count_video.records import Estimate, Floats
from synth_video.film import render_clip
from synth_video.scene_file import load_scene
from synth_video.truth import truth_path

RATES = (240.0, 480.0, 960.0)
FEWEST, MOST = 25, 35
SHORTEST_FRAMES = 0.25
CLEAN_SCATTER = 0.003
"""Above this scatter from collision to collision, a contact has no one restitution."""


@dataclass(frozen=True)
class Filmed:
    """What became of one clip."""

    capture_fps: float
    scatter: float
    """Of the restitution, from collision to collision."""
    true_count: int
    count: int | None
    """None if not counted."""
    probability: float
    inferred: int
    errors: Floats
    """Of the mass ratio (relative) and of both restitutions; NaN where nothing was fitted."""
    sigmas: Floats
    """Their stated uncertainties."""


def drawn(seed: int, rate: float) -> tuple[Setup, Motion, float]:
    """Draw a trial of 25 to 35 collisions and the camera's shutter."""
    rng = np.random.default_rng([seed, 77])
    while True:
        setup = random_setup(rng)
        motion = simulate(setup, seed=seed)
        shortest_s = min(b.time_s - a.time_s for a, b in pairwise(motion.burst))
        if FEWEST <= motion.count <= MOST and shortest_s * rate >= SHORTEST_FRAMES:
            return setup, motion, float(rng.uniform(0.1, 0.9))


def filmed(seed: int, folder: Path) -> Filmed:
    """Render a trial, unless its clip is there, and count it."""
    rate = RATES[seed % len(RATES)]
    setup, motion, shutter = drawn(seed, rate)
    clip = folder / f"trial{seed:03d}-{rate:.0f}.mp4"
    if not truth_path(clip).exists():
        scene = load_scene("paper")
        camera = replace(scene.camera, capture_fps=rate, shutter=round(shutter, 3))
        render_clip(replace(scene, setup=setup, camera=camera), seed, clip)
    trial = work_through(clip, TrialSettings(capture_fps=rate))
    errors, sigmas = compared(trial.between, motion)
    result = trial.result
    return Filmed(
        capture_fps=rate,
        scatter=setup.restitution_bodies_sd,
        true_count=motion.count,
        count=result.count,
        probability=result.probability.get(result.count or 0, 0.0),
        inferred=result.between_frames or 0,
        errors=errors,
        sigmas=sigmas,
    )


def compared(fitted: object, motion: Motion) -> tuple[Floats, Floats]:
    """Errors of mass ratio and restitutions against what really happened, and their sigmas."""
    if not isinstance(fitted, Between):
        return np.full(3, np.nan), np.full(3, np.nan)
    ratio = motion.setup.heavy_mass_kg / motion.setup.light_mass_kg
    stated: list[tuple[Estimate, float, float]] = [(fitted.mass_ratio, ratio, ratio)]
    contacts = (("bodies", fitted.restitution_bodies), ("wall", fitted.restitution_wall))
    for kind, estimate in contacts:
        happened = [bounce.restitution for bounce in motion.burst if bounce.kind == kind]
        stated.append((estimate, float(np.mean(happened)), 1.0))
    errors = np.array([(estimate.value - true) / unit for estimate, true, unit in stated])
    return errors, np.array([estimate.sigma / unit for estimate, _, unit in stated])


def count_table(rows: Sequence[Filmed]) -> str:
    """Write how the counts come out, by capture rate, as a Markdown table."""
    lines = [
        "| frames/s | clips | between the frames | exact | not counted | wrong | least claim |",
        "|---:|---:|---:|---:|---:|---:|---:|",
    ]
    for rate in RATES:
        own = [row for row in rows if row.capture_fps == rate]
        if not own:
            continue
        exact = sum(row.count == row.true_count for row in own)
        silent = sum(row.count is None for row in own)
        hidden = sum(row.inferred for row in own) / sum(row.true_count for row in own)
        least = min((row.probability for row in own if row.count is not None), default=np.nan)
        lines.append(
            f"| {rate:.0f} | {len(own)} | {hidden:.0%} | {exact} | {silent} "
            f"| {len(own) - exact - silent} | {least:.2f} |"
        )
    return "\n".join(lines)


def error_table(rows: Sequence[Filmed]) -> str:
    """Write errors, and errors over stated uncertainties, as a Markdown table."""
    lines = [
        "| scatter of the restitution | clips | mass ratio: rms error | largest | over sigma "
        "| restitution: rms error | largest | over sigma |",
        "|---|---:|---:|---:|---:|---:|---:|---:|",
    ]
    groups = (
        (f"up to {CLEAN_SCATTER}", [row for row in rows if row.scatter <= CLEAN_SCATTER]),
        ("0.01", [row for row in rows if row.scatter > CLEAN_SCATTER]),
    )
    for name, group in groups:
        own = [row for row in group if np.isfinite(row.errors).all()]
        if not own:
            continue
        errors, sigmas = np.array([r.errors for r in own]), np.array([r.sigmas for r in own])
        cells = [name, f"{len(own)}"]
        for columns, form in ((slice(0, 1), ".2%"), (slice(1, 3), ".4f")):
            error, over = errors[:, columns], errors[:, columns] / sigmas[:, columns]
            cells += [format(_rms(error), form), format(float(np.abs(error).max()), form)]
            cells.append(f"{_rms(over):.2f}")
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(values**2)))


def main(arguments: Sequence[str] | None = None) -> int:
    """Film, count and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("trials", type=int, help="number of clips")
    parser.add_argument("folder", type=Path, help="where the clips are kept")
    options = parser.parse_args(arguments)
    options.folder.mkdir(parents=True, exist_ok=True)
    rows = []
    for seed in range(options.trials):
        rows.append(filmed(seed, options.folder))
        if rows[-1].count != rows[-1].true_count:
            sys.stderr.write(f"{rows[-1]}\n")
    sys.stdout.write(f"{count_table(rows)}\n\n{error_table(rows)}\n")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())

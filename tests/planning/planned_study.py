"""Plan set-ups, render them, count them with the whole command, and print the tables.

``python tests/planning/planned_study.py 40 clips/`` plans forty set-ups, renders each to a clip in
a folder by ``synth-video --set ...`` (clips that are there already are kept), counts it and
compares count and fitted set-up with the plan. It takes some ten seconds a clip. ``--close 20``
adds twenty whose collisions come closer than a quarter of a frame; their masses are given.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from contextlib import redirect_stdout
from dataclasses import asdict, dataclass
from fractions import Fraction
from io import StringIO
from itertools import pairwise
from pathlib import Path

import numpy as np

from count_video.physics.setup import Setup
from count_video.physics.simulator import simulate
from count_video.pipeline import TrialSettings, work_through
from count_video.planning.comparison import compared
from count_video.planning.request import PlanRequest
from count_video.records import PlanComparison
from count_video.reports.text import NAMES
from synth_video import cli as synth_cli

RATES = (240.0, 480.0, 960.0, 2000.0)
RATIOS = (1.0, 4.0, 16.0, 50.0, 100.0)
SHORTEST_FRAMES = (0.25, 20.0)
"""Ordinary plans: the shortest interval lies between these, ..."""
CLOSE_FRAMES = (0.02, 0.25)
"""... and close ones between these."""
RESOLVED_FRAMES = 2.5
FEWEST_CLOSE = 12
LIGHT_G = 10.5


@dataclass(frozen=True)
class Outcome:
    """What became of one plan."""

    seed: int
    capture_fps: float
    ratio: float
    shortest_frames: float
    planned: int
    counted: int | None
    probability: float
    between_frames: int
    diameter_error_px: float
    """Of the ball's diameter, which is the scale; NaN where there is none."""
    quantities: dict[str, tuple[float, float]]
    """Found less planned, and its stated uncertainty, of each quantity that was found."""
    explained_by: tuple[str, ...]


def drawn(seed: int, *, close: bool) -> PlanRequest:
    """Draw a set-up as a person might plan it, and a camera that may count it."""
    rng = np.random.default_rng([seed, 1717])
    least, most = CLOSE_FRAMES if close else SHORTEST_FRAMES
    while True:
        thread_m = float(rng.uniform(0.6, 1.5))
        request = PlanRequest(
            heavy=LIGHT_G * float(rng.choice(RATIOS)) * float(rng.uniform(1.0, 1.2)),
            light=LIGHT_G,
            heavy_thread_m=thread_m,
            light_thread_m=thread_m + float(rng.normal(0.0, 0.001)),
            gap_m=float(rng.uniform(0.01, 0.06)),
            release_m=float(rng.uniform(0.07, 0.12)),
            restitution=float(rng.uniform(0.95, 1.0)),
            capture_fps=float(rng.choice(RATES)),
        )
        shortest, count = shortest_frames(request)
        if least <= shortest <= most and (not close or count >= FEWEST_CLOSE):
            return request


def shortest_frames(request: PlanRequest) -> tuple[float, int]:
    """Return the shortest interval in frames, and the count."""
    times = [bounce.time_s for bounce in simulate(request.setup()).burst]
    shortest_s = min((b - a for a, b in pairwise(times)), default=float("inf"))
    return shortest_s * (request.capture_fps or 0.0), len(times)


def rendered(seed: int, request: PlanRequest, clip: Path) -> None:
    """Render a planned set-up by the command, unless it is there."""
    if clip.with_suffix(".truth.json").exists():
        return
    setup: Setup = request.setup()
    values = {f"setup.{name}": value for name, value in asdict(setup).items() if name != "mounting"}
    values |= {"setup.heavy_mass_kg": float(request.heavy) / 1e3}
    values |= {"setup.light_mass_kg": float(request.light) / 1e3}
    values |= {"camera.capture_fps": request.capture_fps, "view.width_m": 0.28}
    settings = [word for key, value in values.items() for word in ("--set", f"{key}={value!r}")]
    with redirect_stdout(StringIO()):
        code = synth_cli.main([str(clip), "--scene", "paper", "--seed", str(seed), *settings])
    if code:
        raise SystemExit(f"cannot render {clip}")


def outcome_of(seed: int, folder: Path, *, close: bool) -> Outcome:
    """Plan, render and count one set-up."""
    request = drawn(seed, close=close)
    clip = folder / f"{'close' if close else 'plan'}{seed:03d}.mp4"
    rendered(seed, request, clip)
    given = (Fraction(float(request.heavy)), Fraction(float(request.light))) if close else None
    settings = TrialSettings(capture_fps=request.capture_fps, masses=given)
    result = compared(work_through(clip, settings).result, request)
    truth = json.loads(clip.with_suffix(".truth.json").read_text("utf-8"))
    comparison = result.comparison
    assert comparison is not None
    return Outcome(
        seed=seed,
        capture_fps=request.capture_fps or 0.0,
        ratio=request.mass_ratio,
        shortest_frames=shortest_frames(request)[0],
        planned=comparison.planned_count,
        counted=result.count,
        probability=result.probability.get(result.count or -1, 0.0),
        between_frames=result.between_frames or 0,
        diameter_error_px=(result.ball_diameter_px or float("nan")) - truth["ball_diameter_px"],
        quantities=differences(comparison),
        explained_by=comparison.explained_by,
    )


def differences(comparison: PlanComparison) -> dict[str, tuple[float, float]]:
    """Found less planned and its stated uncertainty, by quantity."""
    return {
        one.name: (one.found.value - one.planned, one.found.sigma)
        for one in comparison.quantities
        if one.found.sigma > 0
    }


def count_table(rows: Sequence[Outcome]) -> str:
    """Write how the counts came out, by the shortest interval, as a Markdown table."""
    lines = [
        "| planned clips, shortest interval | clips | as planned | not counted | wrong |",
        "|---|---:|---:|---:|---:|",
    ]
    groups = (
        ("from 2.5 frames on", RESOLVED_FRAMES, float("inf")),
        ("0.25 to 2.5 frames", SHORTEST_FRAMES[0], RESOLVED_FRAMES),
        ("0.08 to 0.25 frames, masses given", 0.0, SHORTEST_FRAMES[0]),
    )
    for name, least, most in groups:
        own = [row for row in rows if least <= row.shortest_frames < most]
        exact = sum(row.counted == row.planned for row in own)
        silent = sum(row.counted is None for row in own)
        wrong = len(own) - exact - silent
        lines.append(f"| {name} | {len(own)} | {exact} | {silent} | {wrong} |")
    return "\n".join(lines)


def error_table(rows: Sequence[Outcome]) -> str:
    """Write how near the fitted set-ups come to the planned ones as a Markdown table."""
    lines = [
        "| found less planned | clips | median | rms over stated | within two of it |",
        "|---|---:|---:|---:|---:|",
    ]
    for name, (words, unit, _) in NAMES.items():
        pairs = np.array([row.quantities[name] for row in rows if name in row.quantities])
        if not pairs.size:
            continue
        errors, sigmas = pairs.T
        over = errors / sigmas
        median = f"{np.median(np.abs(errors)):.2g} {unit}".rstrip()
        lines.append(
            f"| {words} | {len(pairs)} | {median} "
            f"| {np.sqrt(np.mean(over**2)):.2f} | {np.mean(np.abs(over) <= 2):.0%} |"
        )
    return "\n".join(lines)


def rows_of(trials: int, folder: Path, *, close: bool) -> list[Outcome]:
    """Work through all plans; what is in the folder's list already is kept."""
    listed = folder / f"{'close' if close else 'plan'}.jsonl"
    lines = listed.read_text("utf-8").splitlines() if listed.exists() else []
    rows = [Outcome(**json.loads(line)) for line in lines]
    for seed in range(len(rows), trials):
        rows.append(outcome_of(seed, folder, close=close))
        with listed.open("a", encoding="utf-8") as file:
            file.write(json.dumps(asdict(rows[-1])) + "\n")
        sys.stderr.write(f"{rows[-1]}\n")
    return rows[:trials]


def main(arguments: Sequence[str] | None = None) -> int:
    """Plan, render, count and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("trials", type=int, help="number of ordinary plans")
    parser.add_argument("folder", type=Path, help="where the clips are kept")
    parser.add_argument("--close", type=int, default=0, help="number of close plans (default: 0)")
    options = parser.parse_args(arguments)
    options.folder.mkdir(parents=True, exist_ok=True)
    rows = rows_of(options.trials, options.folder, close=False)
    rows += rows_of(options.close, options.folder, close=True)
    scale_px = np.sqrt(np.nanmean([row.diameter_error_px**2 for row in rows]))
    sys.stdout.write(f"{count_table(rows)}\n\n{error_table(rows)}\n\n")
    sys.stdout.write(f"The ball's diameter is off by {scale_px:.2f} px (rms).\n")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())

"""Plan set-ups, render them, count them with the whole command, and write the README's tables.

``python tests/planning/study.py 20 clips/`` plans twenty set-ups, renders each to a clip in a
folder by ``synth-video --set ...`` (clips that are there already are kept), counts it and compares
count and fitted set-up with what was planned. It takes some ten seconds a clip. With ``--close``
the collisions come closer than a quarter of a frame.
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
from count_video.records import Estimate, FittedSetup, TrialResult
from count_video.trial import TrialSettings, count_clip
from synth_video import cli as synth_cli

RATES = (240.0, 480.0, 960.0, 2000.0)
RATIOS = (1.0, 4.0, 16.0, 50.0, 100.0)
SHORTEST_FRAMES = (0.25, 20.0)
"""Ordinary plans: the shortest interval lies between these, ..."""
CLOSE_FRAMES = (0.02, 0.25)
"""... and close ones between these."""
FEWEST_CLOSE = 12
LIGHT_KG = 0.0105
QUANTITIES = ("gap", "release", "heavy period", "ball period", "mass ratio", "restitution")


@dataclass(frozen=True)
class Compared:
    """What became of one plan."""

    seed: int
    capture_fps: float
    ratio: float
    gap_m: float
    release_m: float
    shortest_frames: float
    planned: int
    counted: int | None
    probability: float
    between_frames: int
    diameter_error_px: float
    """Of the ball's diameter, which is the scale; NaN where there is none."""
    errors: dict[str, tuple[float, float]]
    """Of each quantity that was fitted: found less planned, and its stated uncertainty; lengths in
    mm by the true scale, periods in ms, the mass ratio relative."""


def drawn(seed: int, *, close: bool) -> tuple[Setup, float]:
    """Draw a set-up as a person might plan it, and a camera that may count it."""
    rng = np.random.default_rng([seed, 1717])
    least, most = CLOSE_FRAMES if close else SHORTEST_FRAMES
    while True:
        thread_m = float(rng.uniform(0.6, 1.5))
        setup = Setup(
            heavy_mass_kg=LIGHT_KG * float(rng.choice(RATIOS)) * float(rng.uniform(1.0, 1.2)),
            light_mass_kg=LIGHT_KG,
            heavy_thread_m=thread_m,
            light_thread_m=thread_m + float(rng.normal(0.0, 0.001)),
            wall_gap_m=float(rng.uniform(0.01, 0.06)),
            release_m=float(rng.uniform(0.07, 0.12)),
            restitution_bodies=float(rng.uniform(0.95, 1.0)),
            restitution_wall=float(rng.uniform(0.95, 1.0)),
        )
        rate = float(rng.choice(RATES))
        motion = simulate(setup)
        shortest = rate * shortest_s([bounce.time_s for bounce in motion.burst])
        if least <= shortest <= most and (not close or motion.count >= FEWEST_CLOSE):
            return setup, rate


def shortest_s(times_s: Sequence[float]) -> float:
    return min((b - a for a, b in pairwise(times_s)), default=float("inf"))


def rendered(seed: int, setup: Setup, rate: float, clip: Path) -> None:
    """Render a planned set-up by the command, unless it is there."""
    if clip.with_suffix(".truth.json").exists():
        return
    values = {f"setup.{name}": value for name, value in asdict(setup).items() if name != "mounting"}
    values |= {"camera.capture_fps": rate, "view.width_m": 0.28}
    settings = [word for key, value in values.items() for word in ("--set", f"{key}={value!r}")]
    with redirect_stdout(StringIO()):
        code = synth_cli.main([str(clip), "--scene", "paper", "--seed", str(seed), *settings])
    if code:
        raise SystemExit(f"cannot render {clip}")


def compared(seed: int, folder: Path, *, close: bool) -> Compared:
    """Plan, render and count one set-up."""
    setup, rate = drawn(seed, close=close)
    motion = simulate(setup)
    clip = folder / f"{'close' if close else 'plan'}{seed:03d}.mp4"
    rendered(seed, setup, rate, clip)
    masses = Fraction(setup.heavy_mass_kg), Fraction(setup.light_mass_kg)
    given = masses if close else None  # as a plan advises where the collisions are so close
    result = count_clip(clip, TrialSettings(capture_fps=rate, masses=given))
    truth = json.loads(clip.with_suffix(".truth.json").read_text("utf-8"))
    px_per_m = float(truth["px_per_m"])
    true_px = setup.ball_diameter_m * px_per_m
    return Compared(
        seed=seed,
        capture_fps=rate,
        ratio=float(masses[0] / masses[1]),
        gap_m=setup.wall_gap_m,
        release_m=setup.release_m,
        shortest_frames=rate * shortest_s([bounce.time_s for bounce in motion.burst]),
        planned=motion.count,
        counted=result.count,
        probability=result.probability.get(result.count or -1, 0.0),
        between_frames=result.between_frames or 0,
        diameter_error_px=(result.ball_diameter_px or float("nan")) - true_px,
        errors={}
        if result.setup is None
        else errors_of(result, result.setup, setup, 1e3 / px_per_m),
    )


def errors_of(
    result: TrialResult, fitted: FittedSetup, setup: Setup, mm_per_px: float
) -> dict[str, tuple[float, float]]:
    """Found less planned and stated uncertainty, by quantity; lengths in mm by the true scale."""
    rate = result.capture_fps or float("nan")
    natural = [
        np.sqrt(setup.gravity_m_s2 / m) for m in (setup.heavy_thread_m, setup.light_thread_m)
    ]
    told = {
        "gap": (fitted.gap_px, mm_per_px, 1e3 * setup.wall_gap_m),
        "release": (fitted.release_px, mm_per_px, 1e3 * setup.release_m),
        "heavy period": (fitted.heavy_period_frames, 1e3 / rate, 2e3 * np.pi / natural[0]),
        "ball period": (fitted.ball_period_frames, 1e3 / rate, 2e3 * np.pi / natural[1]),
    }
    if result.mass_ratio is not None and result.mass_ratio_sigma:
        ratio = setup.heavy_mass_kg / setup.light_mass_kg
        estimate = Estimate(result.mass_ratio, result.mass_ratio_sigma)
        told["mass ratio"] = (estimate, 1.0 / ratio, 1.0)
    for name, estimate, true in (
        ("restitution, bodies", result.restitution_bodies, setup.restitution_bodies),
        ("restitution, wall", result.restitution_wall, setup.restitution_wall),
    ):
        if estimate is not None:
            told[name] = (estimate, 1.0, true)
    return {
        name: (estimate.value * unit - true, estimate.sigma * unit)
        for name, (estimate, unit, true) in told.items()
    }


def rows_of(trials: int, folder: Path, *, close: bool) -> list[Compared]:
    """Work through all plans; what is in the folder's list already is kept."""
    listed = folder / f"{'close' if close else 'plan'}.jsonl"
    lines = listed.read_text("utf-8").splitlines() if listed.exists() else []
    rows = [Compared(**json.loads(line)) for line in lines]
    for seed in range(len(rows), trials):
        rows.append(compared(seed, folder, close=close))
        with listed.open("a", encoding="utf-8") as file:
            file.write(json.dumps(asdict(rows[-1])) + "\n")
        sys.stderr.write(f"{rows[-1]}\n")
    return rows[:trials]


def main(arguments: Sequence[str] | None = None) -> int:
    """Plan, render, count and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("trials", type=int, help="number of plans")
    parser.add_argument("folder", type=Path, help="where the clips are kept")
    parser.add_argument("--close", action="store_true", help="closer than a quarter of a frame")
    options = parser.parse_args(arguments)
    options.folder.mkdir(parents=True, exist_ok=True)
    rows_of(options.trials, options.folder, close=options.close)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())

"""Film the trials of a campaign, each with a camera of its own, and write its manifest."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from statistics import fmean, pstdev

import numpy as np

from count_video.errors import UsageError
from count_video.outputs import clear_unfinished
from count_video.parallel import Processes
from count_video.physics.simulator import Motion, simulate
from synth_video.campaign.seed_search import Target
from synth_video.film import render_clip
from synth_video.scene import Scene
from synth_video.scene_file import load_scene
from synth_video.truth import write_text

SCENE = "campaign"
PHONE_RATE = 240.0
PHONE_SHARE = 0.2
"""Share of the trials that a phone films; at its rate collisions fall between the frames."""
HIGH_SPEED_RATES = (1000.0, 1500.0, 2000.0, 3000.0, 4000.0, 6000.0, 8000.0)
APART_FRAMES = 3.0
"""A high-speed camera is set to its lowest rate at which collisions lie so far apart."""
LEAD_S, TAIL_S = 0.015, 0.06
"""Real time that a clip shows before the first collision and after the last of the burst."""
_CAMERA = 1_000_003
"""Stream of chance for the cameras, apart from that of the hands."""


@dataclass(frozen=True)
class Take:
    """One trial, ready to be filmed."""

    name: str
    scene: Scene
    seed: int
    count: int
    """True count of the simulated trial."""


def takes_of(target: Target, seed: int, overrides: Iterable[str] = ()) -> list[Take]:
    """Set up every trial of a campaign and the camera that films it.

    Parameters
    ----------
    overrides
        Settings of the scene, ``section.key=value``, for all trials.
    """
    scene = load_scene(SCENE, overrides)
    return [_take(target, seed, trial, scene) for trial in range(target.trials)]


def film(takes: Sequence[Take], folder: Path, workers: int) -> Iterator[Take]:
    """Render the clips in several processes; yield each when it and those before are there.

    Whoever leaves the loop early ends the processes; clips that are complete stay.

    Raises
    ------
    UsageError
        A clip cannot be written.
    """
    processes = Processes(workers)
    at_once = True
    try:
        running = [processes.submit(_render, (take, folder)) for take in takes]
        for take, rendered in zip(takes, running, strict=True):
            rendered.result()
            yield take
        at_once = False
    finally:
        processes.close(at_once=at_once)
        with suppress(OSError):
            clear_unfinished(folder)


def write_lists(takes: Sequence[Take], seed: int, folder: Path) -> None:
    """Write ``manifest.csv`` for the tool and ``campaign.truth.json`` for whoever checks it.

    The folder is made if needed.

    Raises
    ------
    UsageError
        They cannot be written.
    """
    counts = [take.count for take in takes]
    truth = {
        "seed": seed,
        "trials": len(takes),
        "maximum": max(counts),
        "minimum": min(counts),
        "mean": fmean(counts),
        "sd_population": pstdev(counts),
        "counts": {take.name: take.count for take in takes},
        "capture_fps": {take.name: take.scene.camera.capture_fps for take in takes},
    }
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UsageError(f"cannot make {folder}: {error.strerror}; check the path") from error
    write_text(json.dumps(truth, indent=1) + "\n", folder / "campaign.truth.json")
    write_text(_manifest(takes), folder / "manifest.csv")


def _take(target: Target, seed: int, trial: int, scene: Scene) -> Take:
    setup = target.hands.setup(seed, trial)
    motion = simulate(setup, seed=trial)
    rate = _rate(motion, np.random.default_rng([seed, trial, _CAMERA]))
    clip = replace(
        scene.clip, lead_frames=round(LEAD_S * rate) + 4, tail_frames=round(TAIL_S * rate) + 4
    )
    scene = replace(scene, setup=setup, clip=clip, camera=replace(scene.camera, capture_fps=rate))
    digits = len(str(target.trials))
    return Take(f"trial{trial + 1:0{digits}}", scene, trial, motion.count)


def _rate(motion: Motion, rng: np.random.Generator) -> float:
    """Choose the camera, then the rate that whoever films would set on it."""
    if rng.random() < PHONE_SHARE:
        return PHONE_RATE
    shortest_s = min((b.time_s - a.time_s for a, b in pairwise(motion.burst)), default=np.inf)
    enough = [rate for rate in HIGH_SPEED_RATES if rate * shortest_s >= APART_FRAMES]
    return enough[0] if enough else HIGH_SPEED_RATES[-1]


def _render(wanted: tuple[Take, Path]) -> None:
    take, folder = wanted
    render_clip(take.scene, take.seed, folder / f"{take.name}.mp4")


def _manifest(takes: Sequence[Take]) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["clip", "capture_fps", "masses"])
    for take in takes:
        setup = take.scene.setup
        masses = f"{setup.heavy_mass_kg:g} {setup.light_mass_kg:g}"
        writer.writerow([f"{take.name}.mp4", f"{take.scene.camera.capture_fps:g}", masses])
    return text.getvalue()

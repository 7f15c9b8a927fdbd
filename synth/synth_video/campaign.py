"""Campaigns of many synthetic trials with known truth: drawn, searched for, and filmed."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import closing, suppress
from dataclasses import dataclass, field, replace
from itertools import count, pairwise
from pathlib import Path
from statistics import fmean, pstdev

import numpy as np

from count_video.errors import UsageError
from count_video.outputs import clear_unfinished
from count_video.parallel import as_done
from count_video.physics.setup import Setup
from count_video.physics.simulator import Motion, simulate, simulate_many
from synth_video.film import render_clip
from synth_video.scene import Scene
from synth_video.scene_file import load_scene
from synth_video.truth import write_text

# ---- hands ---------------------------------------------------------------------------------------
# How an experimenter's hands scatter from trial to trial, as distributions with seeds.


@dataclass(frozen=True)
class Hands:
    """What is set by hand before each trial; normal unless said otherwise, in SI units."""

    gap_least_m: float = 0.013
    """No wall gap (ball to wall, at rest) is smaller than this."""
    gap_scale_m: float = 0.014
    """Above the least the gap is exponential with this mean: most are close, now and then one is
    wide. Lossless bodies of 1:100 collide 31 times up to a gap of 3 cm and 28 times at 6."""
    alignment_m: float = 0.0003
    """Standard deviation of the gap between the bodies at rest about 0."""
    release_m: float = 0.09
    release_sd_m: float = 0.002
    thread_m: float = 1.0
    thread_sd_m: float = 0.003
    """Of each body's thread on its own."""
    loss_sd: float = 0.004
    """Restitution of each contact is 1 less the size of a normal number of this deviation."""

    def setup(self, seed: int, trial: int) -> Setup:
        """Draw what is on the table in one trial; each trial has a stream of its own."""
        rng = np.random.default_rng([seed, trial])
        return Setup(
            wall_gap_m=self.gap_least_m + float(rng.exponential(self.gap_scale_m)),
            bodies_gap_m=float(rng.normal(0.0, self.alignment_m)),
            release_m=float(rng.normal(self.release_m, self.release_sd_m)),
            heavy_thread_m=float(rng.normal(self.thread_m, self.thread_sd_m)),
            light_thread_m=float(rng.normal(self.thread_m, self.thread_sd_m)),
            restitution_bodies=1.0 - abs(float(rng.normal(0.0, self.loss_sd))),
            restitution_wall=1.0 - abs(float(rng.normal(0.0, self.loss_sd))),
        )


# ---- search --------------------------------------------------------------------------------------
# Campaigns whose true counts have a published mean and spread: found, not made.
#
# The physics of a campaign hangs on one seed. ``search`` goes through the seeds from 0 on and
# simulates all trials of each until the counts have the figures of the target.


@dataclass(frozen=True)
class Target:
    """A published table, and the hands that are to have made it."""

    trials: int
    maximum: int
    minimum: int
    mean: str
    """As printed, with its decimals."""
    sd_population: str
    """As printed, with its decimals; divided by n."""
    seed: int
    """The first seed that ``search`` finds."""
    hands: Hands = field(default_factory=Hands)

    def met_by(self, counts: Sequence[int]) -> bool:
        """Return whether counts have the figures of the table, as far as they are printed."""
        return (
            len(counts) == self.trials
            and (max(counts), min(counts)) == (self.maximum, self.minimum)
            and _printed(fmean(counts), self.mean) == self.mean
            and _printed(pstdev(counts), self.sd_population) == self.sd_population
        )


CAMPAIGNS: Mapping[str, Target] = {
    "paper-30": Target(
        trials=30, maximum=31, minimum=28, mean="30.57", sd_population="0.80", seed=211
    ),
}
"""Campaigns by name; ``paper-30`` is the paper's result, over 30 trials."""


def target_named(name: str) -> Target:
    """Return a campaign by its name.

    Raises
    ------
    UsageError
        There is no such campaign.
    """
    if name not in CAMPAIGNS:
        raise UsageError(f"no campaign {name!r}; there are: {', '.join(CAMPAIGNS)}")
    return CAMPAIGNS[name]


def true_counts(target: Target, seed: int) -> list[int]:
    """Simulate a campaign; return the count of each trial."""
    trials = range(target.trials)
    setups = [target.hands.setup(seed, trial) for trial in trials]
    counts: list[int] = simulate_many(setups, seeds=trials).count.tolist()
    return counts


def search(target: Target, first: int = 0) -> int:
    """Return the first seed, from ``first`` on, whose counts meet the target."""
    return next(seed for seed in count(first) if target.met_by(true_counts(target, seed)))


def _printed(value: float, like: str) -> str:
    return f"{value:.{len(like.partition('.')[2])}f}"


# ---- filming -------------------------------------------------------------------------------------
# Film the trials of a campaign, each with a camera of its own, and write its manifest.

SCENE = "campaign"
PHONE_RATE = 240.0
PHONE_SHARE = 0.2
"""Share of the trials that a phone films; at its rate collisions fall between the frames."""
HIGH_SPEED_RATES = (1000.0, 1500.0, 2000.0, 3000.0, 4000.0, 6000.0, 8000.0)
APART_FRAMES = 3.0
"""A high-speed camera is set to its lowest rate at which collisions lie so far apart."""
LEAD_S, TAIL_S = 0.015, 0.12
"""Real time that a clip shows before the first collision and after the last of the burst: until the
motion shows that none follows, even if air slows the ball."""
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
    rendered: set[str] = set()
    try:
        with closing(as_done(_render, [(take, folder) for take in takes], workers)) as done:
            for take in takes:
                while take.name not in rendered:
                    (one, _), future = next(done)
                    future.result()
                    rendered.add(one.name)
                yield take
    finally:
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

"""Is a claimed probability true? Hard random trials, and how often what is claimed is right.

``python tests/between/reliability.py 600`` draws trials, films them without pictures (tracks as a
tracker gives them), counts them as the command does and prints the tables of docs/accuracy.md. It
takes about a second a trial; ``--processes`` shares the work, ``--list`` names what is wrong.

A trial has up to 60 collisions, is filmed at 60 to 960 frames per second with noise of 0.03 to
0.5 px, and its restitution scatters by up to 2 %. Of four clips one is whole, one begins too late,
one ends too early (each anywhere in the burst), and one lacks frames, with a trace in the time
stamps or without. The true count is that of the whole trial whatever the clip shows.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from multiprocessing import Pool
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from unittest.mock import patch

import numpy as np
from synthetic_tracks import FilmedTrial, Filming, film, setup_of

from count_video import pipeline
from count_video.errors import TrackingError
from count_video.physics.setup import Setup
from count_video.physics.simulator import simulate
from count_video.records import BodyTrack, Floats, FootageInfo, FootageReport, Track, TrialResult

RATES = (60.0, 120.0, 240.0, 480.0, 960.0)
NOISE_PX = (0.03, 0.5)
MASS_RATIOS = (1.0, 400.0)
SCATTER_AT_MOST = 0.02
COUNTS = (2, 60)
CLIPS = ("whole", "begins late", "ends early", "lacks frames")
MISSED_AT_MOST = 12
BINS = (0.0, 0.5, 0.95, 1.0001)
DETAILED_BINS = (0.0, 0.5, 0.65, 0.8, 0.95, 0.99, 1.0001)
SIGMAS_AT_MOST = 3.0


@dataclass(frozen=True)
class HardTrial:
    """A clip's track with the truth."""

    seed: int
    capture_fps: float
    clip: str
    """What was done to the clip, one of ``CLIPS``."""
    track: Track
    count: int
    event_frames: Floats
    """Frame coordinates of the burst, as far as the clip's frames show them."""
    mass_ratio: float


@dataclass(frozen=True)
class Outcome:
    """What became of one trial."""

    trial: HardTrial
    result: TrialResult

    @property
    def right(self) -> bool:
        """Whether the count is the true one."""
        return self.result.count == self.trial.count

    @property
    def claimed(self) -> float:
        """Probability that was claimed for the count."""
        return self.result.probability.get(self.result.count or 0, 0.0)


def hard_trial(seed: int) -> HardTrial:
    """Draw a trial and its clip."""
    rng = np.random.default_rng([seed, 14])
    rate, clip = float(rng.choice(RATES)), CLIPS[seed % len(CLIPS)]
    while True:
        setup = _setup(rng)
        if COUNTS[0] <= simulate(setup, seed=seed).count <= COUNTS[1]:
            break
    noise = float(np.exp(rng.uniform(*np.log(NOISE_PX))))
    filming = Filming(rate, float(rng.uniform(0.1, 0.9)), noise, float(rng.random()))
    filmed = film(setup, filming, seed)
    track, events = _cut(filmed, clip, rng)
    ratio = setup.heavy_mass_kg / setup.light_mass_kg
    return HardTrial(seed, rate, clip, track, filmed.count, events, ratio)


def _setup(rng: np.random.Generator) -> Setup:
    scatter = float(rng.uniform(0.0, SCATTER_AT_MOST))
    low, high = np.log(MASS_RATIOS)
    ratio = float(np.exp(rng.uniform(low, high)))
    return setup_of(rng, scatter, ratio, least_restitution=0.9)


def _cut(filmed: FilmedTrial, clip: str, rng: np.random.Generator) -> tuple[Track, Floats]:
    """Take frames away; the track, and the events by the frames that are left."""
    track, events = filmed.track, filmed.event_frames
    first, last = float(events[0]), float(events[-1])
    keep = np.ones(len(track.frame), dtype=bool)
    if clip == "begins late":
        keep = track.frame >= rng.uniform(first - 10.0, (first + last) / 2)
    if clip == "ends early":
        keep = track.frame <= rng.uniform(first, last + 20.0)
    if clip != "lacks frames":
        return _kept(track, keep), events
    missed = int(rng.integers(1, MISSED_AT_MOST + 1))
    at = float(np.ceil(rng.uniform(first - 5.0, last + 5.0)))
    keep = (track.frame < at) | (track.frame >= at + missed)
    shorter = _kept(track, keep)
    if rng.random() < 0.5:
        return shorter, events
    # Without a trace: what comes later is dated too early, what is missing lies between two frames.
    frame = np.where(shorter.frame >= at, shorter.frame - missed, shorter.frame)
    later = np.where(events > at + missed, events - missed, np.minimum(events, at))
    return replace(shorter, frame=frame), later


def _kept(track: Track, keep: np.ndarray[Any, np.dtype[np.bool_]]) -> Track:
    def part(body: BodyTrack) -> BodyTrack:
        return replace(body, position_px=body.position_px[keep], sigma_px=body.sigma_px[keep])

    assert track.heavy is not None
    return replace(track, frame=track.frame[keep], ball=part(track.ball), heavy=part(track.heavy))


def counted(trial: HardTrial, *, ball_alone: bool = False) -> Outcome:
    """Count a trial as the command would, with tracks in the place of pictures.

    With ``ball_alone`` the heavy body is not seen, nor is it known on which side the wall is.
    """
    frames = len(trial.track.frame)
    info = FootageInfo(
        *(Path("trial.mp4"), 640, 240, 0),
        *(frames, 30.0, trial.capture_fps, "option"),
    )
    report = FootageReport(frames, frames, ())
    footage = SimpleNamespace(info=info, report=lambda: report)
    view = SimpleNamespace(footage=footage)
    seen = SimpleNamespace(view=view, movers=None, frames=None, whole=True)

    def singles(*_: object) -> list[Track]:
        if not ball_alone:
            raise TrackingError("nothing moves so")
        return [ball]

    ball = replace(trial.track, heavy=None, wall_side="left")
    replaced = {
        "open_footage": lambda *_, **__: nullcontext(footage),
        "observe": lambda *_, **__: nullcontext(seen),
        "stands_beyond": lambda *_: (True, True),
        "moves_beside": lambda *_: True,
        "pair_tracks": lambda *_: [] if ball_alone else [trial.track],
        "single_tracks": singles,
    }
    with patch.multiple(pipeline, **replaced):
        result = pipeline.work_through(Path("trial.mp4"), pipeline.TrialSettings()).result
    return Outcome(trial, result)


def reliability_table(outcomes: Sequence[Outcome], bins: Sequence[float] = DETAILED_BINS) -> str:
    """Write how often claims are right as a Markdown table."""
    lines = ["| claimed | trials | mean claim | right | wrong |", "|---|---:|---:|---:|---:|"]
    for low, high in pairwise(bins):
        inside = claims(outcomes, low, high)
        if inside:
            right, mean = sum(o.right for o in inside), np.mean([o.claimed for o in inside])
            lines.append(
                f"| {low:.2f} to {min(high, 1.0):.2f} | {len(inside)} | {mean:.3f} "
                f"| {right / len(inside):.3f} | {len(inside) - right} |"
            )
    return "\n".join(lines)


def claims(outcomes: Sequence[Outcome], low: float, high: float) -> list[Outcome]:
    """Outcomes with a count whose claimed probability lies in a bin."""
    return [o for o in outcomes if o.result.count is not None and low <= o.claimed < high]


def calibration_error(outcomes: Sequence[Outcome], bins: Sequence[float]) -> float:
    """Mean over the claims of how far a bin's mean claim is from its share of right ones."""
    inside = [claims(outcomes, low, high) for low, high in pairwise(bins)]
    apart = [abs(sum(o.claimed - o.right for o in some)) for some in inside]
    return sum(apart) / max(1, sum(map(len, inside)))


def clips_table(outcomes: Sequence[Outcome]) -> str:
    """Write what became of each kind of clip as a Markdown table."""
    lines = ["| clip | trials | exact | refused | wrong |", "|---|---:|---:|---:|---:|"]
    for clip in (*CLIPS, "all"):
        some = [o for o in outcomes if clip in (o.trial.clip, "all")]
        refused = sum(o.result.count is None for o in some)
        right = sum(o.right for o in some)
        lines.append(
            f"| {clip} | {len(some)} | {right} | {refused} | {len(some) - right - refused} |"
        )
    return "\n".join(lines)


def standardised_errors(outcomes: Sequence[Outcome]) -> dict[str, Floats]:
    """Errors of times over their uncertainties, of right counts, by how the collision is known."""
    found: dict[str, list[float]] = {"seen": [], "between the frames": []}
    for o in outcomes:
        if o.right:
            for one, true in zip(o.result.collisions, o.trial.event_frames, strict=False):
                known = "seen" if one.seen else "between the frames"
                found[known].append((one.frame - float(true)) / one.frame_sigma)
    return {name: np.array(values) for name, values in found.items()}


def errors_table(outcomes: Sequence[Outcome]) -> str:
    """Write how large errors of times are over their stated uncertainties as a Markdown table."""
    lines = [
        f"| collisions | number | RMS | beyond {SIGMAS_AT_MOST:.0f} |",
        "|---|---:|---:|---:|",
    ]
    for name, values in standardised_errors(outcomes).items():
        if len(values):
            far = np.mean(np.abs(values) > SIGMAS_AT_MOST)
            rms = float(np.sqrt(np.mean(values**2)))
            lines.append(f"| {name} | {len(values)} | {rms:.2f} | {far:.1%} |")
    return "\n".join(lines)


def stated(outcome: Outcome) -> str:
    """One outcome in a line."""
    trial, result = outcome.trial, outcome.result
    return (
        f"{trial.seed} {trial.capture_fps:.0f}/s {trial.clip}: true {trial.count}, "
        f"counted {result.count} ({outcome.claimed:.2f}), {result.reason}"
    )


def report(outcomes: Sequence[Outcome]) -> str:
    """Write all tables, and the calibration errors below them."""
    within = partial(calibration_error, outcomes)
    tables = (clips_table(outcomes), reliability_table(outcomes), errors_table(outcomes))
    errors = (
        f"Expected calibration error {within(DETAILED_BINS):.3f}, of claims from 0.5 to 0.95 "
        f"{within(BINS[1:3]):.3f}."
    )
    return "\n\n".join((*tables, errors))


def main(arguments: Sequence[str]) -> int:
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("trials", type=int)
    parser.add_argument("--first-seed", type=int, default=0)
    parser.add_argument("--processes", type=int, default=1)
    parser.add_argument("--ball-alone", action="store_true", help="the heavy body is not seen")
    parser.add_argument("--list", action="store_true", help="name what is wrong or refused")
    options = parser.parse_args(arguments)
    seeds = range(options.first_seed, options.first_seed + options.trials)
    with Pool(options.processes) as pool:
        outcomes = list(pool.imap(partial(_outcome, options.ball_alone), seeds))
    listed = [stated(o) for o in outcomes if not o.right] if options.list else []
    sys.stdout.write("\n".join((*listed, "", report(outcomes), "")))
    return 0


def _outcome(ball_alone: bool, seed: int) -> Outcome:
    return counted(hard_trial(seed), ball_alone=ball_alone)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

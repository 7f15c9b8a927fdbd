"""Count random trials between the frames and write the tables of docs/accuracy.md.

``python tests/between/study.py 60`` films 60 random trials near 1:100 at each of five rates (no
pictures: tracks as a good tracker gives them), counts them and prints the tables. It takes about
a second a trial; ``--first-seed`` draws others. With ``--long`` the trials are near 1:10 000, each
counted with its masses known and without; they take ten seconds each.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from synthetic_tracks import FilmedTrial, random_long_trial, random_trial

from count_video.explanations import PROBABILITY_AT_LEAST, leaves_doubt
from count_video.motion.fitted import Between, fit_burst
from count_video.motion.parameters import Knowledge
from count_video.motion.priors import MODEL_WRONG
from count_video.motion.seen import SeenCollisions, seen_collisions

RATES = (960.0, 480.0, 240.0, 120.0, 60.0)
LONG_RATES = (1000.0, 4000.0)
BINS = (0.0, 0.5, 0.8, 0.95, 1.0001)


@dataclass(frozen=True)
class Outcome:
    """What became of one trial."""

    capture_fps: float
    seed: int
    true_count: int
    count: int | None
    """None if it was not counted."""
    probability: float
    """That was claimed for the count."""
    inferred: int
    """Collisions between the frames."""
    mass_ratio_error: float
    """Relative; NaN where nothing was fitted."""
    restitution_error: float
    """The larger of both contacts; NaN where nothing was fitted."""
    perfect_scatter: bool
    """Whether the restitution was the same at all collisions."""

    @property
    def right(self) -> bool:
        """Whether the count is the true one."""
        return self.count == self.true_count


def outcome_of(trial: FilmedTrial, seed: int) -> Outcome:
    """Count one trial as the command would."""
    found = seen_collisions(trial.track)
    fitted = None
    if leaves_doubt(found):
        fitted = fit_burst(trial.track, found, Knowledge(trial.filming.capture_fps))
    count, probability, inferred = _claimed(found, fitted)
    ratio_error, restitution_error = _errors(trial, fitted)
    return Outcome(
        capture_fps=trial.filming.capture_fps,
        seed=seed,
        true_count=trial.count,
        count=count,
        probability=probability,
        inferred=inferred,
        mass_ratio_error=ratio_error,
        restitution_error=restitution_error,
        perfect_scatter=trial.motion.setup.restitution_bodies_sd == 0,
    )


def _claimed(found: SeenCollisions, fitted: object) -> tuple[int | None, float, int]:
    if isinstance(fitted, Between):
        chance = fitted.probability[fitted.count]
        inferred = sum(not collision.seen for collision in fitted.collisions)
        return (fitted.count if chance >= 0.5 else None), chance, inferred
    if fitted is None and not found.doubts and not found.shortcomings:
        return found.burst, 1 - MODEL_WRONG, 0
    return None, 0.0, 0


def _errors(trial: FilmedTrial, fitted: object) -> tuple[float, float]:
    if not isinstance(fitted, Between):
        return float("nan"), float("nan")
    setup = trial.motion.setup
    ratio = fitted.mass_ratio.value / (setup.heavy_mass_kg / setup.light_mass_kg) - 1
    bodies = fitted.restitution_bodies.value - setup.restitution_bodies
    wall = fitted.restitution_wall.value - setup.restitution_wall
    return ratio, max(abs(bodies), abs(wall))


def long_table(first_seed: int, trials: int) -> str:
    """Count trials near 1:10 000 and write how they come out as a Markdown table."""
    lines = ["| frames/s | masses | exact | not counted | wrong | true count's probability |"]
    lines += ["|---:|---|---:|---:|---:|---:|"]
    for rate in LONG_RATES:
        drawn = [random_long_trial(seed, rate) for seed in range(first_seed, first_seed + trials)]
        for masses in (True, False):
            lines.append(_long_row(rate, masses, drawn))
    return "\n".join(lines)


def _long_row(rate: float, masses: bool, drawn: Sequence[FilmedTrial]) -> str:
    exact = silent = 0
    chances = []
    for trial in drawn:
        ratio = trial.motion.setup.heavy_mass_kg / trial.motion.setup.light_mass_kg
        found = seen_collisions(trial.track)
        fitted = fit_burst(trial.track, found, Knowledge(rate, ratio if masses else None))
        sure = isinstance(fitted, Between)
        sure = sure and fitted.probability[fitted.count] >= PROBABILITY_AT_LEAST
        silent += not sure
        exact += sure and fitted.count == trial.count
        chances.append(fitted.probability.get(trial.count, 0.0) if sure else np.nan)
    wrong = len(drawn) - exact - silent
    usual = f"{np.nanmedian(chances):.2f}" if np.isfinite(chances).any() else "-"
    given_or_not = "given" if masses else "not given"
    return f"| {rate:.0f} | {given_or_not} | {exact} | {silent} | {wrong} | {usual} |"


def accuracy_table(outcomes: Sequence[Outcome]) -> str:
    """Write accuracy by capture rate as a Markdown table."""
    lines = [
        "| frames/s | trials | between the frames | exact | not counted | wrong "
        "| mass ratio, median error | restitution, median error |",
        "|---:|---:|---:|---:|---:|---:|---:|---:|",
    ]
    for rate in RATES:
        rows = [o for o in outcomes if o.capture_fps == rate]
        if not rows:
            continue
        right = sum(o.right for o in rows)
        silent = sum(o.count is None for o in rows)
        hidden = sum(o.inferred for o in rows) / sum(o.true_count for o in rows)
        ratio = np.nanmedian([abs(o.mass_ratio_error) for o in rows])
        same = [o.restitution_error for o in rows if o.perfect_scatter]
        restitution = f"{np.nanmedian(same):.4f}" if np.isfinite(same).any() else "-"
        lines.append(
            f"| {rate:.0f} | {len(rows)} | {hidden:.0%} | {right / len(rows):.1%} | {silent} "
            f"| {len(rows) - right - silent} | {ratio:.2%} | {restitution} |"
        )
    return "\n".join(lines)


def reliability_table(outcomes: Sequence[Outcome]) -> str:
    """Write claimed against true shares, and the expected calibration error."""
    lines = ["| claimed | trials | mean claim | right |", "|---|---:|---:|---:|"]
    counted = [o for o in outcomes if o.count is not None]
    error = 0.0
    for low, high in pairwise(BINS):
        rows = [o for o in counted if low <= o.probability < high]
        if not rows:
            continue
        claim = float(np.mean([o.probability for o in rows]))
        right = float(np.mean([o.right for o in rows]))
        error += len(rows) / len(counted) * abs(claim - right)
        lines.append(
            f"| {low:.2f} to {min(high, 1):.2f} | {len(rows)} | {claim:.3f} | {right:.3f} |"
        )
    sure_and_wrong = sum(o.probability > 0.95 and not o.right for o in counted)
    lines += ["", f"Expected calibration error {error:.3f}; wrong with a claim above 0.95: "]
    lines[-1] += f"{sure_and_wrong} of {len(outcomes)}."
    return "\n".join(lines)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the study and print its tables."""
    parser = argparse.ArgumentParser(description=__doc__, add_help=True)
    parser.add_argument("trials", type=int, help="trials at each rate")
    parser.add_argument("--first-seed", type=int, default=1000)
    parser.add_argument("--long", action="store_true", help="count trials near 1:10 000")
    options = parser.parse_args(arguments)
    if options.long:
        sys.stdout.write(f"{long_table(options.first_seed, options.trials)}\n")
        return 0
    outcomes = []
    sys.stderr.flush()
    for seed in range(options.first_seed, options.first_seed + options.trials):
        for rate in RATES:
            outcomes.append(outcome_of(random_trial(seed, rate), seed))
            if not outcomes[-1].right:
                sys.stderr.write(f"{outcomes[-1]}\n")
    sys.stdout.write(f"{accuracy_table(outcomes)}\n\n{reliability_table(outcomes)}\n")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())

"""Are stated uncertainties true? docs/accuracy.md's figures, on clips with their truth.

``python tests/tracking/uncertainties.py suite/clean-*.mp4`` counts clips that ``synth-video suite``
has rendered, as the command would, and prints for each condition how many bodies there were, how
many have normalised errors (errors about their mean, over the stated uncertainties, in frames whose
exposure holds no collision) with an RMS between 0.8 and 1.3, and between 0.7 and 1.5, and the
median and the extremes of the RMS; ``--bodies`` prints a line for every body. Conditions are set
by the names of the clips. ``together`` is the RMS of the normalised errors of all bodies of a
condition, each frame once. It takes a second or two a clip.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from count_video.errors import CountVideoError
from count_video.pipeline import work_through
from count_video.records import BodyTrack, Floats, Track
from count_video.settings import TrialSettings

TRUTHFUL = (0.8, 1.3)
NEARLY = (0.7, 1.5)
HALF_EXPOSURE = 0.5


@dataclass(frozen=True)
class Body:
    """One body of one clip."""

    name: str
    error_px: float
    """RMS of the errors about their mean."""
    stated_px: float
    """RMS of the stated uncertainties."""
    normalised: float
    """RMS of the errors over their stated uncertainties."""
    frames: int
    """So many places."""


def bodies_of(clip: Path) -> list[Body]:
    """Track a clip and compare both bodies with its truth; none where it cannot be tracked."""
    truth = json.loads(clip.with_suffix(".truth.json").read_text())
    try:
        track = work_through(clip, TrialSettings()).track
    except CountVideoError:
        return []
    if track is None or track.heavy is None:
        return []
    clear = _clear(truth, track)
    shown = [truth["frames"][frame] for frame in track.frame.astype(int)]
    ball_px = np.array([(frame["ball_near_px"] + frame["ball_far_px"]) / 2 for frame in shown])
    heavy_px = np.array([frame["cylinder_px"] for frame in shown])
    return [
        _body(f"{clip.stem} {name}", body, true_px, clear)
        for name, body, true_px in (
            ("ball", track.ball, ball_px),
            ("heavy", track.heavy, heavy_px),
        )
    ]


def _clear(truth: Mapping[str, list[Mapping[str, float]]], track: Track) -> np.ndarray:
    """Frames whose exposure holds no collision: the others show a blend of two flights."""
    events = [event["frame"] for event in (*truth["events"], *truth["events_after_burst"])]
    apart = np.abs(track.frame[:, None] - np.array(events or [-np.inf])).min(axis=1)
    return np.asarray(apart > HALF_EXPOSURE)


def _body(name: str, body: BodyTrack, true_px: Floats, clear: np.ndarray) -> Body:
    seen = clear & np.isfinite(body.position_px)
    error, sigma = (body.position_px - true_px)[seen], body.sigma_px[seen]
    error = error - error.mean()
    return Body(name, _rms(error), _rms(sigma), _rms(error / sigma), len(error))


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(values**2)))


def table(conditions: Mapping[str, Sequence[Body]]) -> str:
    """Write how true the uncertainties are as a Markdown table."""
    lines = [
        f"| condition | bodies | {TRUTHFUL[0]} to {TRUTHFUL[1]} | {NEARLY[0]} to {NEARLY[1]} "
        "| median | least | largest | together |",
        "|---|---:|---:|---:|---:|---:|---:|---:|",
    ]
    for name, bodies in conditions.items():
        ratios = np.array([body.normalised for body in bodies])
        within = [np.sum((ratios >= low) & (ratios <= high)) for low, high in (TRUTHFUL, NEARLY)]
        together = np.sqrt(np.average(ratios**2, weights=[body.frames for body in bodies]))
        values = (np.median(ratios), ratios.min(), ratios.max(), together)
        cells = [f"{value:.2f}" for value in values]
        lines.append(f"| {' | '.join([name, str(len(bodies)), *map(str, within), *cells])} |")
    return "\n".join(lines)


def main(arguments: Sequence[str] | None = None) -> int:
    """Track the clips and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("clips", nargs="+", type=Path, help="clips with a truth beside each")
    parser.add_argument("--bodies", action="store_true", help="print a line for every body")
    options = parser.parse_args(arguments)
    conditions = defaultdict(list)
    for clip in options.clips:
        found = bodies_of(clip)
        conditions[clip.stem.split("-")[0]] += found
        for body in found if options.bodies else ():
            sys.stdout.write(
                f"{body.name}: error {body.error_px:.4f} px, stated {body.stated_px:.4f} px, "
                f"normalised {body.normalised:.2f}\n"
            )
    sys.stdout.write(f"{table({name: found for name, found in conditions.items() if found})}\n")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())

"""How near the tracker comes to what noisy pictures can show: its table and picture.

``python tests/tracking/noise_sweep.py docs/pictures/noise-sweep.png`` renders clips with white
noise of 0.5 to 12 grey levels and nothing else that disturbs (an even backdrop, no file
compression), tracks them as the command would, prints the errors beside the bound of
``pixel_bound`` as a Markdown table, and draws them. It takes a minute or two; without a path
nothing is drawn.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from pixel_bound import bounds_px

from count_video.pipeline import work_through
from count_video.records import BodyTrack, Floats, Track
from count_video.reports import drawing
from count_video.reports.drawing import picture_bytes, styled
from count_video.settings import TrialSettings
from synth_video.film import render_clip
from synth_video.scene import Scene
from synth_video.scene_file import load_scene
from synth_video.truth import Truth

NOISES = (0.5, 0.7, 1.0, 1.4, 2.0, 2.8, 4.0, 5.6, 8.0, 12.0)
"""Standard deviations of the sensor's noise in grey levels."""
SEEDS = (1, 2, 3)
NOTHING_ELSE = (
    "background.kind=cloth",
    "background.texture=0",
    "camera.vignette=0",
    "camera.shot_noise=0",
    "cylinder.glint=0",
    "light.shadow=0",
    "encoding.crf=0",
)
"""The backdrop is even, no light moves over the bodies, and the file keeps every pixel."""
LUMA_STEP = 255 / 219
"""Files keep brightness in 219 steps."""
ROUNDED = (1 + LUMA_STEP**2) / 12
"""Variance that rounding adds, in the sensor and in the file."""
NAMES = ("ball", "heavy body")


@dataclass(frozen=True)
class Point:
    """Errors of one body at one noise."""

    noise: float
    trials: int
    """So many were followed; in the others noise hides a body."""
    bound_px: float
    rms_px: float
    """Of the places about their mean error."""
    normalised: float
    """RMS of the errors over their stated uncertainties."""

    @property
    def ratio(self) -> float:
        """Error over bound."""
        return self.rms_px / self.bound_px


def quiet_scene(noise: float, *settings: str) -> Scene:
    """The suite's scene with so much noise and nothing else that disturbs."""
    return load_scene("suite", [f"camera.read_noise={noise}", *NOTHING_ELSE, *settings])


def points(scene: Scene, seeds: Sequence[int], folder: Path) -> tuple[Point, Point]:
    """Film and track trials of a scene; the points of ball and heavy body."""
    every = [_errors(scene, seed, folder / f"{seed}.mp4") for seed in seeds]
    found = [one for one in every if one is not None]
    noise = scene.camera.read_noise
    bounds = bounds_px(scene, seeds[0])
    ball, heavy = (
        Point(
            noise,
            len(found),
            bounds[body] * float(np.sqrt(noise**2 + ROUNDED)),
            _rms(np.concatenate([errors[body] for errors, _ in found])),
            _rms(np.concatenate([errors[body] / sigmas[body] for errors, sigmas in found])),
        )
        for body in (0, 1)
    )
    return ball, heavy


def _errors(scene: Scene, seed: int, clip: Path) -> tuple[list[Floats], list[Floats]] | None:
    """Errors of both bodies about their mean, and their stated uncertainties; None if not found."""
    truth = render_clip(scene, seed, clip)
    track = work_through(clip, TrialSettings()).track
    if track is None or track.heavy is None:
        return None
    clear = _clear(truth, track)
    errors, sigmas = [], []
    ball_px = (truth.ball_near.x_px + truth.ball_far.x_px) / 2
    for body, true_px in ((track.ball, ball_px), (track.heavy, truth.cylinder.x_px)):
        error = _error(body, true_px, track)[clear]
        errors.append(error - error.mean())
        sigmas.append(body.sigma_px[clear])
    return errors, sigmas


def _error(body: BodyTrack, true_px: Floats, track: Track) -> Floats:
    return body.position_px - true_px[track.frame.astype(int)]


def _clear(truth: Truth, track: Track) -> np.ndarray:
    """Frames whose exposure holds no collision: the others show a blend of two flights."""
    events = np.array([event.frame for event in (*truth.events, *truth.events_after_burst)])
    return np.asarray(np.abs(track.frame[:, None] - events).min(axis=1) > 0.5)


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(values**2)))


def table(rows: Sequence[tuple[Point, Point]]) -> str:
    """Write the sweep as a Markdown table."""
    lines = [
        "| noise, grey levels | trials | ball: bound, px | error, px | ratio "
        "| heavy body: bound, px | error, px | ratio |",
        "|---:|---:|---:|---:|---:|---:|---:|---:|",
    ]
    for row in rows:
        cells = [f"{row[0].noise:g}", str(row[0].trials)]
        for point in row:
            cells += [f"{point.bound_px:.4f}", f"{point.rms_px:.4f}", f"{point.ratio:.2f}"]
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def figure_of(rows: Sequence[tuple[Point, Point]]) -> Figure:
    """Draw errors and bounds over the noise."""
    noise = [row[0].noise for row in rows]
    with styled():
        figure = Figure(figsize=(9, 4.2), layout="constrained")
        panels = figure.subplots(1, 2, sharex=True, sharey=True)
        for body, (panel, colour) in enumerate(
            zip(panels, (drawing.BALL, drawing.HEAVY), strict=True)
        ):
            bound = np.array([row[body].bound_px for row in rows])
            panel.fill_between(noise, bound, 2 * bound, color=drawing.GREY, alpha=0.2, lw=0)
            panel.plot(noise, bound, color="black", label="bound of Cramér and Rao")
            panel.plot(noise, 2 * bound, color=drawing.GREY, ls="--", label="twice the bound")
            errors = [row[body].rms_px for row in rows]
            panel.plot(noise, errors, "o", color=colour, mec="black", label="count-video")
            panel.set(xscale="log", yscale="log", title=NAMES[body], xlabel="noise, grey levels")
            panel.set_xticks([0.5, 1, 2, 4, 8], ["0.5", "1", "2", "4", "8"])
            panel.minorticks_off()
            panel.set_yticks([0.001, 0.003, 0.01, 0.03], ["0.001", "0.003", "0.01", "0.03"])
            panel.grid(alpha=0.3)
        panels[0].set_ylabel("error of a place, px (RMS)")
        panels[0].legend(loc="upper left")
    return figure


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the sweep, print its table and draw its picture."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("picture", nargs="?", type=Path, help="PNG file to draw")
    options = parser.parse_args(arguments)
    rows = []
    for noise in NOISES:
        with tempfile.TemporaryDirectory() as folder:
            rows.append(points(quiet_scene(noise), SEEDS, Path(folder)))
    sys.stdout.write(f"{table(rows)}\n")
    if options.picture is not None:
        options.picture.write_bytes(picture_bytes(figure_of(rows), "png"))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())

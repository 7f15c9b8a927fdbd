"""Count a folder of trials and set their table beside the paper's, which has thirty trials.

python examples/thirty_trials.py FOLDER

``synth-video campaign paper-30 trials/`` renders thirty trials that have the paper's figures.
"""

from __future__ import annotations

import statistics
import sys

import count_video

PAPER = {
    "Number of trials": "30",
    "Maximum value": "31",
    "Minimum value": "28",
    "Mean value": "30.57",
    "Standard deviation": "0.80",
}
"""Nagao, Sakano, Shinohara, Matsuda and Takami, Estimation of pi via experiment."""


def main(folder: str) -> None:
    """Print the two tables side by side, and the clips that were not counted."""
    counts = []
    for result in count_video.count_all(folder):
        if result.count is None:
            print(f"{result.clip}: not counted: {'; '.join(result.reasons)}", file=sys.stderr)
        else:
            print(f"{result.clip}: counted {result.count}", file=sys.stderr)
            counts.append(result.count)
    if not counts:
        raise SystemExit(f"{folder}: no clip was counted")
    found = {
        "Number of trials": str(len(counts)),
        "Maximum value": str(max(counts)),
        "Minimum value": str(min(counts)),
        "Mean value": f"{statistics.mean(counts):.2f}",
        "Standard deviation": f"{statistics.pstdev(counts):.2f}",
    }
    print(f"{'':25}{'here':>8}{'paper':>8}")
    for name, value in found.items():
        print(f"{name:25}{value:>8}{PAPER[name]:>8}")


if __name__ == "__main__":  # the processes that count import this file
    if len(sys.argv) != 2:
        raise SystemExit(__doc__)
    try:
        main(sys.argv[1])
    except count_video.CountVideoError as error:
        raise SystemExit(str(error)) from error

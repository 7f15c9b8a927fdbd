"""The conditions by name, the suites that are made of them, and the rendering of their clips."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing, suppress
from dataclasses import asdict, dataclass
from pathlib import Path

from count_video.errors import UsageError
from count_video.outputs import clear_unfinished
from count_video.parallel import as_done
from synth_video.film import render_clip
from synth_video.scene import Scene
from synth_video.suite.camera_conditions import FILE, LIGHT, PART, RATE, STAND
from synth_video.suite.condition import STRENGTHS, Condition, Strength
from synth_video.suite.scene_conditions import BODIES, EXPERIMENTS, THINGS
from synth_video.truth import truth_path

SUITES: Mapping[str, tuple[Condition, ...]] = {
    "light": LIGHT,
    "stand": STAND,
    "file": FILE,
    "rate": RATE,
    "part": PART,
    "things": THINGS,
    "bodies": BODIES,
    "experiments": EXPERIMENTS,
    "all": (*LIGHT, *STAND, *FILE, *RATE, *PART, *THINGS, *BODIES, *EXPERIMENTS),
}
"""Suites by name; ``all`` is what the table of accuracy is made of."""


def conditions_of(suite: str, wanted: Sequence[str] = ()) -> tuple[Condition, ...]:
    """Return the conditions of a suite, or those of them that are wanted.

    Raises
    ------
    UsageError
        There is no such suite, or no such condition in it.
    """
    if suite not in SUITES:
        raise UsageError(f"no suite {suite!r}; there are: {', '.join(SUITES)}")
    known = {condition.name: condition for condition in SUITES[suite]}
    for name in wanted:
        if name not in known:
            raise UsageError(f"no condition {name!r} in {suite}; there are: {', '.join(known)}")
    return tuple(known[name] for name in wanted or known)


# ---- rendering -----------------------------------------------------------------------------------
# Render the clips of a suite; what is there already as it should be is not rendered again.


@dataclass(frozen=True)
class Take:
    """One clip of a suite."""

    condition: Condition
    strength: Strength
    number: int

    @property
    def seed(self) -> int:
        """Seed of its trial."""
        return self.condition.seed(self.number)

    @property
    def scene(self) -> Scene:
        """What is filmed."""
        return self.condition.scene(self.strength, self.number)

    @property
    def name(self) -> str:
        """File name of the clip."""
        return f"{self.condition.name}-{self.strength}-{self.number:03}{self.condition.suffix}"


@dataclass(frozen=True)
class Label:
    """What a clip's name says of it."""

    condition: str
    strength: str
    """Empty for a clip that is of no suite."""


def label_of(clip: str) -> Label:
    """Read the label off the name of a clip, without its suffix; any other name is a condition."""
    condition, _, rest = clip.partition("-")
    strength, _, number = rest.partition("-")
    if strength in STRENGTHS and number.isdecimal():
        return Label(condition, strength)
    return Label(clip, "")


def takes_of(
    conditions: Sequence[Condition], strengths: Sequence[Strength], numbers: Sequence[int]
) -> list[Take]:
    """All clips of a suite, condition by condition."""
    return [Take(c, s, n) for c in conditions for s in strengths for n in numbers]


def film(takes: Sequence[Take], folder: Path, workers: int) -> Iterator[tuple[Take, bool]]:
    """Render the clips that are missing; yield each take, and whether it was rendered now.

    The folder is made if needed. Whoever leaves the loop early ends the processes; clips that are
    complete stay.

    Raises
    ------
    UsageError
        A clip or the folder cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UsageError(f"cannot make {folder}: {error.strerror}; check the path") from error
    missing = [take for take in takes if not _is_there(take, folder / take.name)]
    for take in takes:
        if take not in missing:
            yield take, False
    try:
        with closing(as_done(_render, [(take, folder) for take in missing], workers)) as done:
            for (take, _), future in done:
                future.result()
                yield take, True
    finally:
        with suppress(OSError):
            clear_unfinished(folder)


def _is_there(take: Take, clip: Path) -> bool:
    """Return whether a clip is complete (its truth is written after it) and of the same scene."""
    try:
        truth = json.loads(truth_path(clip).read_text("utf-8"))
    except (OSError, ValueError):
        return False
    # What JSON makes of a scene, tuples into lists, is compared.
    wanted = json.loads(json.dumps(asdict(take.scene)))
    return clip.exists() and (truth["scene"], truth["seed"]) == (wanted, take.seed)


def _render(wanted: tuple[Take, Path]) -> None:
    take, folder = wanted
    render_clip(take.scene, take.seed, folder / take.name)

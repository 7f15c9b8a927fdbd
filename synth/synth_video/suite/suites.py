"""The conditions by name, and the suites that are made of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from count_video.errors import UsageError
from synth_video.suite.body_conditions import BODIES
from synth_video.suite.camera_conditions import FILE, LIGHT, STAND
from synth_video.suite.clip_conditions import PART, RATE
from synth_video.suite.condition import Condition
from synth_video.suite.experiment_conditions import EXPERIMENTS
from synth_video.suite.thing_conditions import THINGS

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

"""Pairs of moving patches that may be the two bodies, and the one that is found all over a clip."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from count_video.records import Frame
from count_video.tracking.looks.learning import Body
from count_video.tracking.pairs.bodies import (
    Bodies,
    NotFound,
    differ,
    features_transposed,
    learn_pair,
    transposed,
)
from count_video.tracking.pairs.features import moving_features
from count_video.tracking.pairs.seeds import (
    PatchPair,
    motion_direction_deg,
    pairs_across_runs,
    patches,
    rank_pairs,
)

CANDIDATES = 6
"""So many pairs of patches are tried, best first."""
SEEN_EACH_RUN = 1.5
"""A pair seen so many times a run, half as often as a run is looked at, needs no rival."""


@dataclass(frozen=True)
class Look:
    """How bodies are looked for: each way finds some that the others do not."""

    faint: bool = False
    """Bodies that hardly stand out as well."""
    close: bool = False
    """In enlarged pictures: bodies of a few px."""
    wide: bool = False
    """Learning more of a long body than what lies next to its neighbour."""


@dataclass(frozen=True)
class Candidates:
    """Pairs of moving patches that may be the two bodies, as one way of looking shows them.

    Both bodies of a pair are learnt when they are asked for first.
    """

    runs: Sequence[Sequence[Frame]]
    """Turned so that the bodies move along the rows."""
    look: Look
    direction_deg: float
    upright: bool
    pairs: Sequence[PatchPair]
    """The likeliest first."""
    _learnt: dict[int, tuple[Body, Body] | None] = field(default_factory=dict)

    def learnt(self, place: int) -> tuple[Body, Body] | None:
        """Both bodies of a pair; None where they cannot be found again."""
        if place not in self._learnt:
            self._learnt[place] = learn_pair(
                self.runs, self.pairs[place], self.direction_deg, wide=self.look.wide
            )
        return self._learnt[place]


def candidates(runs: Sequence[Sequence[Frame]], look: Look) -> Candidates | NotFound:
    """Find what moves along one line in runs of consecutive frames, in pairs."""
    features = [moving_features(run, faint=look.faint, close=look.close) for run in runs]
    direction = motion_direction_deg(features)
    if direction is None:
        return NotFound("nothing moves along a line in this clip")
    upright = abs(direction) > 45.0
    if upright:
        runs = [[transposed(frame) for frame in run] for run in runs]
        features = [features_transposed(run) for run in features]
        direction = (90.0 - direction + 90.0) % 180.0 - 90.0
    width = runs[0][0].luma.shape[1]
    groups = [patches(run, direction, width) for run in features]
    if not any(groups):
        return NotFound("no body moves steadily along a line in this clip")
    pairs = rank_pairs(groups)[:CANDIDATES] + pairs_across_runs(groups)[:CANDIDATES]
    return Candidates(runs, look, direction, upright, pairs)


def best_bodies(found: Candidates, tried: Sequence[Bodies] = ()) -> Bodies | NotFound:
    """Choose the pair that is found again all over the clip, by its bodies' learnt appearance.

    ``tried`` came to nothing: others are found if there are any, else the same ones from other
    patches.
    """
    best, merit = None, (False, 0)
    for place, pair in enumerate(found.pairs):
        known = any(pair == bodies.seen_as for bodies in tried)
        learnt = None if known else found.learnt(place)
        if learnt is None:
            continue
        worth = differ(learnt, tried), min(len(body.sightings) for body in learnt)
        if worth > merit:
            best, merit = Bodies(*learnt, found.direction_deg, found.upright, pair), worth
        if merit >= (True, SEEN_EACH_RUN * len(found.runs)):
            break
    if best is not None:
        return best
    return NotFound(
        "only one body, or no two that move on their own along one line, can be followed"
    )

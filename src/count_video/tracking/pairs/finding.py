"""Look for the two bodies in one way after the other, and for others where these will not do."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product

from count_video.records import Frame
from count_video.tracking.pairs.bodies import Bodies, NotFound, differ
from count_video.tracking.pairs.candidates import Candidates, Look, best_bodies, candidates
from count_video.tracking.pairs.features import FRAMES_AT_LEAST

LOOKS = (Look(), Look(faint=True))
"""Ways of looking for bodies: first by what stands out, then by what is faint."""
CLOSE_LOOKS = (Look(close=True), Look(wide=True), Look(faint=True, wide=True))
"""Ways that take long, where these show no two bodies."""


class Finder:
    """Finds the bodies of a clip; what was learnt on the way is not learnt again."""

    def __init__(self, runs: Sequence[Sequence[Frame]], *, closely: bool = False) -> None:
        """Look into these runs of consecutive frames, in which the camera stands still.

        ``closely`` takes the ways that take long, instead of the others.
        """
        self._looks = CLOSE_LOOKS if closely else LOOKS
        # A ball that bounces to and fro moves evenly in short runs only.
        self._pieces = (list(runs), [half for run in runs for half in halves(run)])
        self._seen: dict[tuple[Look, int], Candidates | NotFound] = {}

    def find(self, tried: Sequence[Bodies] = ()) -> Bodies | NotFound:
        """Find the likeliest two bodies.

        Others than those tried come before the same ones seen in another way.
        """
        again: Bodies | None = None
        missing = NotFound("")
        for bodies in self._ways(tried):
            if isinstance(bodies, NotFound):
                missing = bodies
            elif differ((bodies.left, bodies.right), tried):
                return bodies
            else:
                again = again or bodies
        return again or missing

    def _ways(self, tried: Sequence[Bodies]) -> Iterator[Bodies | NotFound]:
        for look, place in product(self._looks, range(len(self._pieces))):
            if (look, place) not in self._seen:
                self._seen[look, place] = candidates(self._pieces[place], look)
            found = self._seen[look, place]
            yield found if isinstance(found, NotFound) else best_bodies(found, tried)


def halves(run: Sequence[Frame]) -> list[Sequence[Frame]]:
    """Cut a run in two; halves of a short one share frames, so that each still shows a motion."""
    if len(run) <= FRAMES_AT_LEAST:
        return [run]
    middle = len(run) // 2
    return [run[: max(middle, FRAMES_AT_LEAST)], run[min(middle, len(run) - FRAMES_AT_LEAST) :]]

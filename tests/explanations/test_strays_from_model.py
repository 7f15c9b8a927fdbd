"""What a fitted model that does not describe the track says of a count."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest
from explained import bouncing, collision

from count_video.explanations import Explanation, by_fit
from count_video.motion.fitted import Between
from count_video.motion.posterior import doubted
from count_video.motion.priors import MODEL_WRONG, STRAYING_WRONG
from count_video.reasons import Cause, Reason

COUNT = 14
STRAYS = Reason(Cause.MODEL_STRAYS, (0.5, 0.3))


def shown(count: int = COUNT) -> Explanation:
    return replace(bouncing(count), scene="wall", probability=doubted({count: 1.0}))


@pytest.mark.parametrize("reason", [STRAYS, Reason(Cause.MODEL_DIFFERS)])
def test_a_count_whose_motion_no_model_describes_is_in_doubt(reason: Reason) -> None:
    stated = by_fit(shown(), reason, masses_known=False)

    assert (stated.counts, stated.count, stated.doubts) == (True, COUNT, (reason,))
    assert stated.probability[COUNT] == pytest.approx((1 - MODEL_WRONG) * (1 - STRAYING_WRONG))
    assert sum(stated.probability.values()) == pytest.approx(1.0)


def test_what_was_in_doubt_is_refused_if_no_model_describes_it() -> None:
    unsure = replace(shown(), against=(Reason(Cause.UNRESOLVED, (1.0, 2.5)),))

    stated = by_fit(unsure, STRAYS, masses_known=False)

    assert not stated.counts
    assert stated.against == (*unsure.against, STRAYS)


@pytest.mark.parametrize(("confirmed", "counts"), [(2, False), (3, True), (5, True)])
def test_a_fit_with_fewer_collisions_has_a_place_for_most_that_the_frames_show(
    confirmed: int, counts: bool
) -> None:
    found: Any = SimpleNamespace(shown=5)
    unsure = replace(shown(8), against=(Reason(Cause.UNRESOLVED, (1.0, 2.5)),), found=found)
    burst = [replace(collision(n, "wall"), seen=n <= confirmed) for n in range(1, 8)]
    unknown: Any = None
    fit = Between(
        count=7,
        probability=doubted({7: 1.0}),
        collisions=tuple(burst),
        mass_ratio=unknown,
        ratio_by_places=unknown,
        restitution_bodies=unknown,
        restitution_wall=unknown,
        energy_kept=(),
        ending=unknown,
        setup=unknown,
        misfit_px=0.1,
        following={0: 1.0},
    )

    stated = by_fit(unsure, fit, masses_known=False)

    assert stated.counts is counts
    assert stated.count == (7 if counts else 8)


def test_a_model_that_could_not_be_tried_says_nothing() -> None:
    for cause in (Cause.MODEL_LACKS_FRAMES, Cause.MODEL_FITS_NOTHING):
        one = shown()
        assert by_fit(one, Reason(cause), masses_known=False) is one

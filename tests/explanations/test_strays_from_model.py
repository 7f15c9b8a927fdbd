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
from count_video.motion.priors import MODEL_WRONG, UNEXPLAINED_WRONG
from count_video.reasons import Cause, Reason
from count_video.records import CollisionKind, Estimate

COUNT = 14
STRAYS = Reason(Cause.MODEL_STRAYS, (0.5, 0.3))


def shown(count: int = COUNT) -> Explanation:
    return replace(bouncing(count), scene="wall", probability=doubted({count: 1.0}))


@pytest.mark.parametrize("reason", [STRAYS, Reason(Cause.MODEL_FITS_NOTHING)])
def test_a_count_whose_motion_no_model_describes_is_in_doubt(reason: Reason) -> None:
    stated = by_fit(shown(), reason, masses_known=False)

    assert (stated.counts, stated.count, stated.doubts) == (True, COUNT, (reason,))
    assert stated.probability[COUNT] == pytest.approx((1 - MODEL_WRONG) * (1 - UNEXPLAINED_WRONG))
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
    fit = fitted(7, confirmed)

    stated = by_fit(unsure, fit, masses_known=False)

    assert stated.counts is counts
    assert stated.count == (7 if counts else 8)


def test_a_model_that_could_not_be_tried_says_nothing() -> None:
    one = shown()
    assert by_fit(one, Reason(Cause.MODEL_LACKS_FRAMES), masses_known=False) is one


@pytest.mark.parametrize(
    ("apart", "by_fit_px", "confirmed", "sure"),
    [
        (False, 0.0, 4, True),
        (True, 9.0, COUNT, True),
        (True, 9.0, 4, False),
        (True, 9.0, COUNT - 1, False),
        (True, 0.0, 4, True),  # contacts by themselves, of which some were missed, misled
    ],
)
def test_inferred_collisions_are_less_sure_where_outlines_do_not_meet(
    apart: bool, by_fit_px: float, confirmed: int, sure: bool
) -> None:
    seen = replace(shown(), notes=(Reason(Cause.OUTLINES_APART, (8.0,)),) if apart else ())
    fit = replace(fitted(COUNT, confirmed), outlines_apart_px=by_fit_px)

    stated = by_fit(seen, fit, masses_known=False)

    wrong = 0.0 if sure else UNEXPLAINED_WRONG
    assert stated.counts
    assert stated.probability[COUNT] == pytest.approx((1 - MODEL_WRONG) * (1 - wrong))
    assert sum(stated.probability.values()) == pytest.approx(1.0)
    assert min(stated.probability) >= 0
    assert any(doubt.cause is Cause.OUTLINES_LEAVE_OPEN for doubt in stated.doubts) != sure
    apart_px = [note.figures for note in stated.notes if note.cause is Cause.OUTLINES_APART]
    assert apart_px == ([(by_fit_px,)] if apart and by_fit_px else [])


PERIOD_FRAMES = 40.0


@pytest.mark.parametrize(
    ("kind", "later", "another"),
    [("wall", 0.4, False), ("wall", 9.0, False), ("wall", 20.0, True), ("bodies", 0.4, True)],
)
def test_what_follows_the_burst_is_not_its_last_collision_again(
    kind: CollisionKind, later: float, another: bool
) -> None:
    """The fit places its last one between the two that seemed to follow, of which one is it."""
    seen = shown(COUNT + 2)
    fit = fitted(COUNT, COUNT)
    last = replace(fit.collisions[-1], frame=seen.collisions[-2].frame + 1.0)
    fit = replace(fit, collisions=(*fit.collisions[:-1], last))
    follows = replace(seen.collisions[-1], kind=kind, frame=last.frame + later)
    seen = replace(seen, count=COUNT, collisions=(*seen.collisions[:-1], follows))

    stated = by_fit(seen, fit, masses_known=False)

    assert len(stated.collisions) == COUNT + another
    assert stated.collisions[-1].frame == (follows if another else last).frame


def fitted(count: int, confirmed: int) -> Between:
    """A fit of so many collisions, of which the frames show the first ones."""
    burst = [replace(collision(n, "wall"), seen=n <= confirmed) for n in range(1, count + 1)]
    unknown: Any = None
    setup: Any = SimpleNamespace(ball_period_frames=Estimate(PERIOD_FRAMES, 0.1))
    return Between(
        count=count,
        probability=doubted({count: 1.0}),
        collisions=tuple(burst),
        mass_ratio=unknown,
        restitution_bodies=unknown,
        restitution_wall=unknown,
        energy_kept=(),
        ending=unknown,
        setup=setup,
        misfit_px=0.1,
        outlines_apart_px=0.0,
        following={0: 1.0},
    )

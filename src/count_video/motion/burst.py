"""The burst that counts: where it begins, where it ends, and whether the clip shows all of it.

It begins with the first contact of the heavy body with the ball at rest. It ends when the heavy
body, driven back, turns round again. A clip supports a count if it shows the ball at rest before,
and either that turn or, at its end, bodies that part and no wall that the ball could reach before.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from count_video.motion.foresight import last_seen, parted_until_turn
from count_video.motion.gaps import Gaps
from count_video.motion.onesided import (
    HALF_EXPOSURE,
    WINDOW_FRAMES,
    WINDOW_PICTURES,
    fit_side,
    side_of,
)
from count_video.motion.swing import Swing
from count_video.motion.turning import first_turn
from count_video.records import Collision, Floats
from count_video.signals import low_points, sigma_of

FRAMES_TO_JUDGE = 4
"""Fewer frames before the first or after the last collision do not tell how the bodies move."""
AT_REST_SHARE = 0.3
"""A ball slower than this share of the approach speed is at rest before the first collision; in
the midst of a burst it is never slower than the heavy body itself."""
CLOSING_SIGMAS = 4.0
HIDDEN_FRAMES = 4.0
"""A cylinder not seen for so long at the clip's end has left the picture."""
TURN_SIGMAS = 12.0
"""The heavy body has turned round when it came back by so many standard deviations."""
TURN_AT_LEAST_PX = 1.0


GRAZING_SIGMAS = 6.0
GRAZING_FRAMES = 5
"""A ball that stood so near to the wall in so many frames may have struck it."""


@dataclass(frozen=True)
class Rival:
    """Another count, where a collision falls together with the heavy body's turn."""

    count: int
    probability: float
    """Of that count, against the one told; at most 0.5."""
    reason: str
    """What leaves it open, in words for the user."""


@dataclass(frozen=True)
class Burst:
    """Extent of the first burst."""

    count: int
    """How many of the collisions belong to it."""
    rival: Rival | None
    """How many may belong to it just as well; None where that is clear."""
    end_frame: float
    """Where the heavy body turns round again; inf if the clip ends before."""
    shortcomings: tuple[str, ...]
    """Why the clip does not support a count, in words for the user; empty if it does."""


def find_burst(collisions: Sequence[Collision], gaps: Gaps, swing: Swing | None) -> Burst:
    """Find the first burst among collisions in order of time.

    ``swing`` is the heavy body's path through all of them, as far as it is known.
    """
    turning = first_turn(collisions, gaps, swing)
    end = min(turn_round(gaps, collisions), turning.before)
    inside = [c for c in collisions if c.frame <= end and c.frame < turning.before]
    count, rival = len(inside), None
    if np.isfinite(turning.open_before) and turning.open_before <= end:
        surely = sum(c.frame < turning.open_before for c in inside)
        turned = turning.chance < 0.5
        count, other = (surely, count) if turned else (count, surely)
        end = turning.open_before if turned else end
        rival = Rival(other, min(turning.chance, 1 - turning.chance), _open(turning.open_before))
    inside = inside[:count]
    shortcomings = [
        _beginning(inside, gaps),
        _ending(inside, gaps, end, swing),
        _grazing(inside, gaps, end),
    ]
    return Burst(count, rival, end, tuple(s for s in shortcomings if s))


def _open(frame: float) -> str:
    return (
        f"the cylinder turns round at frame {frame:.0f}, just when the ball strikes it: whether "
        "that collision still belongs to the burst is not certain"
    )


def turn_round(gaps: Gaps, collisions: Sequence[Collision]) -> float:
    """Frame at which the heavy body, driven back, turns toward the wall again; inf if never."""
    if not collisions:
        return float("inf")
    away = np.where(gaps.frame >= collisions[0].frame, -gaps.heavy_px, np.nan)
    nearest = _first_of(low_points(-away, _turn_depth(gaps)))
    if nearest is None:
        return float("inf")
    later = np.where(gaps.frame > gaps.frame[nearest], away, np.nan)
    turn = _first_of(low_points(later, _turn_depth(gaps)))
    if turn is None:
        return float("inf")
    return _settled(float(gaps.frame[turn]), -away[turn], gaps, collisions)


def _settled(turn: float, furthest: float, gaps: Gaps, collisions: Sequence[Collision]) -> float:
    """Sharpen the turn where a collision lies close to it, by the vertex of each flight's path.

    The furthest of many noisy places says little about when; whether the heavy body still moved
    away right before a collision decides whether that one belongs to the burst.
    """
    nearer = gaps.heavy_px < furthest - 2 * _turn_depth(gaps)
    since = gaps.frame[nearer & (gaps.frame < turn)].max(initial=-np.inf)
    until = gaps.frame[nearer & (gaps.frame > turn)].min(initial=np.inf)
    bounds = [since, *(c.frame for c in collisions if since < c.frame < until), until]
    for start, end in pairwise(bounds):
        inside = (gaps.frame > start) & (gaps.frame < end) & np.isfinite(gaps.heavy_px)
        if inside.sum() < FRAMES_TO_JUDGE:
            continue
        bend, slope, _ = np.polyfit(gaps.frame[inside] - turn, gaps.heavy_px[inside], 2)
        vertex = turn - slope / (2 * bend) if bend < 0 else np.inf
        if start < vertex < end:
            return float(vertex)
    return turn


def _turn_depth(gaps: Gaps) -> float:
    return max(TURN_AT_LEAST_PX, TURN_SIGMAS * sigma_of(gaps.heavy_px))


def _first_of(places: np.ndarray[tuple[int], np.dtype[np.intp]]) -> int | None:
    return int(places[0]) if len(places) else None


def _beginning(inside: Sequence[Collision], gaps: Gaps) -> str | None:
    if not inside:
        return None
    first = inside[0]
    if first.kind == "wall":
        return (
            "the clip starts after the first collision: the ball already moves to the wall; "
            "start the clip while the ball is still at rest"
        )
    ball = side_of(gaps.frame, gaps.ball_px, first.frame, -np.inf)
    if ball is None or ball.points < FRAMES_TO_JUDGE:
        return (
            "the clip starts too close to its first collision to tell whether the ball was at "
            "rest; start it some frames earlier"
        )
    speed = abs(ball.slope) - CLOSING_SIGMAS * float(np.sqrt(ball.covariance[1, 1]))
    approach = _approach(first)
    if speed > AT_REST_SHARE * approach:
        return (
            "the clip starts after the first collision: the ball is not at rest before the "
            "first one seen; start the clip earlier"
        )
    return None


def _approach(first: Collision) -> float:
    """Speed at which the bodies close in before the first collision; inf if it is not shown."""
    speed = abs(first.velocity_before.heavy_px_frame - first.velocity_before.ball_px_frame)
    return speed if np.isfinite(speed) else np.inf


def _ending(inside: Sequence[Collision], gaps: Gaps, end: float, swing: Swing | None) -> str | None:
    """Judge the state after the last collision: bodies that part, no contact ahead."""
    if not inside or np.isfinite(end):
        return None
    last, final = inside[-1].frame, float(gaps.frame[-1])
    struck = max((c.frame for c in inside if c.kind == "bodies"), default=inside[0].frame)
    gone = last_seen(gaps.frame, gaps.heavy_px)
    since = max(last, min(final - WINDOW_FRAMES, gaps.frame[-int(WINDOW_PICTURES) :][0]))
    # A cylinder that leaves the picture is judged by its last frames there.
    hidden = final - gone > HIDDEN_FRAMES
    gap = _rate(gaps, gaps.gap_px, (since, final))
    heavy = _rate(gaps, gaps.heavy_px, (struck, gone) if hidden else (since, final))
    ball = _rate(gaps, gaps.ball_px, (since, final))
    parts = parted_until_turn(gaps, swing, (inside[0].frame, last), struck)
    if ball is None or heavy is None or (gap is None and not hidden):
        what = "right after a collision"
    elif heavy < 0 and not _driven_back(gaps):
        what = "while the cylinder still moves to the wall"
    elif hidden and not parts:
        what = "while the cylinder, out of the picture, may be struck once more"
    elif gap is not None and gap < 0 and not parts:
        what = "while the ball still catches up with the cylinder"
    elif ball < 0 and not parts:
        what = "while the ball still moves to the wall"
    else:
        return None
    return f"the clip ends {what}, before the burst can be over; let it run longer"


def _grazing(inside: Sequence[Collision], gaps: Gaps, end: float) -> str | None:
    """Judge whether the ball creeps to the wall once more and turns too gently to show it."""
    walls = [c.frame for c in inside if c.kind == "wall"]
    if not walls or inside[-1].kind == "wall":
        return None
    seen = np.isfinite(gaps.ball_px)
    level = float(np.median(np.interp(walls, gaps.frame[seen], gaps.ball_px[seen])))
    later = seen & (gaps.frame > inside[-1].frame + HALF_EXPOSURE) & (gaps.frame < end)
    if later.sum() < GRAZING_FRAMES:
        return None
    # One place alone may be wrong by more than its noise.
    nearest = float(np.sort(gaps.ball_px[later])[GRAZING_FRAMES - 1])
    if nearest > level + GRAZING_SIGMAS * sigma_of(gaps.ball_px):
        return None
    return (
        "after the last collision that is seen the ball creeps up to the wall: whether it strikes "
        "it before the burst is over is too faint to tell"
    )


def _driven_back(gaps: Gaps) -> bool:
    """Whether the heavy body is clearly further away than it once was."""
    seen = gaps.heavy_px[np.isfinite(gaps.heavy_px)]
    return float(seen[-1] - seen.min()) > _turn_depth(gaps)


def _rate(gaps: Gaps, signal: Floats, between: tuple[float, float]) -> float | None:
    """Mean slope of a signal between two frames; 0 if not significant, None if hardly seen."""
    chosen = (gaps.frame > between[0] + HALF_EXPOSURE) & (gaps.frame <= between[1])
    chosen &= np.isfinite(signal)
    if chosen.sum() < FRAMES_TO_JUDGE:
        return None
    about = float(gaps.frame[chosen].mean())
    side = fit_side(gaps.frame[chosen], signal[chosen], about, sigma_of(signal))
    if side is None:
        return None
    significant = abs(side.slope) > CLOSING_SIGMAS * float(np.sqrt(side.covariance[1, 1]))
    return side.slope if significant else 0.0

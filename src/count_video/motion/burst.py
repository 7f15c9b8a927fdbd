"""The burst that counts: where it begins, where it ends, and whether the clip shows all of it.

It begins with the first contact of the heavy body with the ball at rest. It ends when the heavy
body, driven back, turns round again. A clip supports a count if it shows the ball at rest before,
and either that turn or, at its end, bodies that part and no wall that the ball could reach before.

The turn is told by the heavy body's fitted velocities. Of two collisions shortly before and after
the turn, the first belongs to the burst and the second does not; its places hardly tell, for near
the turn it stands still. Its velocities at the collisions do. Where even they leave it open, the
velocity over its uncertainty is the chance of either.

What follows the clip's last frame is foreseen as far as two pendulums let it be. Both swing at the
rate measured on the heavy body, the ball about the place where it hung at first, and the paths are
followed until the heavy body's turn; one that has left the picture is followed from where it was
last seen.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from count_video.motion.gaps import Gaps
from count_video.motion.joint import Contacts
from count_video.motion.pieces import HALF_EXPOSURE, WINDOW_FRAMES
from count_video.motion.reasons import Cause, Reason
from count_video.motion.swing import Swing
from count_video.records import Collision, Floats
from count_video.signals import low_points, sigma_of

FRAMES_TO_JUDGE = 4
"""Fewer frames before the first or after the last collision do not tell how the bodies move."""
AT_REST_SHARE = 0.3
"""A ball slower than this share of the approach speed is at rest before the first collision; in
the midst of a burst it is never slower than the heavy body itself."""
SIGMAS = 4.0
"""A velocity or a change of it counts from this many standard uncertainties on."""
WINDOW_PICTURES = 6
"""The clip's end is as many frames as a piece of a flight, or so many pictures."""
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
    reason: Reason
    """What leaves it open."""


@dataclass(frozen=True)
class Burst:
    """Extent of the first burst."""

    count: int
    """How many of the collisions belong to it."""
    rival: Rival | None
    """How many may belong to it just as well; None where that is clear."""
    end_frame: float
    """Where the heavy body turns round again; inf if the clip ends before."""
    shortcomings: tuple[Reason, ...]
    """Why the clip does not support a count; empty if it does."""


def find_burst(
    collisions: Sequence[Collision], contacts: Contacts, gaps: Gaps, swing: Swing | None
) -> Burst:
    """Find the first burst among collisions in order of time, and their fitted contacts.

    ``swing`` is the heavy body's path through all of them, as far as it is known.
    """
    turning = first_turn(contacts)
    end = min(turn_round(gaps, contacts), turning.before)
    inside = [c for c in collisions if c.frame <= end and c.frame < turning.before]
    count, rival = len(inside), None
    if np.isfinite(turning.open_before) and turning.open_before <= end:
        surely = sum(c.frame < turning.open_before for c in inside)
        turned = turning.chance < 0.5
        count, other = (surely, count) if turned else (count, surely)
        end = turning.open_before if turned else end
        reason = Reason(Cause.TURN_OPEN, (turning.open_before,))
        rival = Rival(other, min(turning.chance, 1 - turning.chance), reason)
    inside = inside[:count]
    causes = (
        _beginning(inside, contacts),
        _ending(inside, gaps, end, swing),
        _grazing(inside, gaps, end),
    )
    return Burst(count, rival, end, tuple(Reason(cause) for cause in causes if cause))


def turn_round(gaps: Gaps, contacts: Contacts) -> float:
    """Frame at which the heavy body, driven back, turns toward the wall again; inf if never.

    The furthest of many noisy places says little about when: it is put after collisions nearby at
    which the heavy body still moves away.
    """
    if len(contacts.frame) == 0:
        return float("inf")
    depth = _turn_depth(gaps)
    away = np.where(gaps.frame >= contacts.frame[0], -gaps.heavy_px, np.nan)
    nearest = _first_of(low_points(-away, depth))
    if nearest is None:
        return float("inf")
    later = np.where(gaps.frame > gaps.frame[nearest], away, np.nan)
    turn = _first_of(low_points(later, depth))
    if turn is None:
        return float("inf")
    back = gaps.frame[(away > away[turn] + depth) & (gaps.frame > gaps.frame[turn])]
    rate, sigma = contacts.bodies[1].rate[:, 0], contacts.bodies[1].sigma[:, 0]
    leaving = (contacts.frame < back.min(initial=np.inf)) & (rate > SIGMAS * sigma)
    return max(float(gaps.frame[turn]), float(contacts.frame[leaving].max(initial=-np.inf)))


def _turn_depth(gaps: Gaps) -> float:
    return max(TURN_AT_LEAST_PX, TURN_SIGMAS * sigma_of(gaps.heavy_px))


def _first_of(places: np.ndarray[tuple[int], np.dtype[np.intp]]) -> int | None:
    return int(places[0]) if len(places) else None


def _beginning(inside: Sequence[Collision], contacts: Contacts) -> Cause | None:
    if not inside:
        return None
    first, ball = inside[0], contacts.bodies[0]
    if first.kind == "wall":
        return Cause.STARTS_MOVING
    speed, sigma = abs(ball.rate[0, 0]), ball.sigma[0, 0]
    if ball.rows[0, 0] < FRAMES_TO_JUDGE or sigma > _approach(first):
        return Cause.STARTS_CLOSE
    late = speed - SIGMAS * sigma > AT_REST_SHARE * _approach(first)
    return Cause.STARTS_LATE if late else None


def _approach(first: Collision) -> float:
    """Speed at which the bodies close in before the first collision; inf if it is not shown."""
    speed = abs(first.velocity_before.heavy_px_frame - first.velocity_before.ball_px_frame)
    return speed if np.isfinite(speed) else np.inf


def _ending(
    inside: Sequence[Collision], gaps: Gaps, end: float, swing: Swing | None
) -> Cause | None:
    """Judge the state after the last collision: bodies that part, no contact ahead."""
    if not inside or np.isfinite(end):
        return None
    last, final = inside[-1].frame, float(gaps.frame[-1])
    struck = max((c.frame for c in inside if c.kind == "bodies"), default=inside[0].frame)
    gone = last_seen(gaps.frame, gaps.heavy_px)
    since = max(last, min(final - WINDOW_FRAMES, gaps.frame[-WINDOW_PICTURES:][0]))
    # A cylinder that leaves the picture is judged by its last frames there.
    hidden = final - gone > HIDDEN_FRAMES
    gap = _rate(gaps, gaps.gap_px, (since, final))
    heavy = _rate(gaps, gaps.heavy_px, (struck, gone) if hidden else (since, final))
    ball = _rate(gaps, gaps.ball_px, (since, final))
    parts = parted_until_turn(gaps, swing, (inside[0].frame, last), struck)
    if ball is None or heavy is None or (gap is None and not hidden):
        return Cause.ENDS_AT_CONTACT
    if heavy < 0 and not _driven_back(gaps):
        return Cause.ENDS_APPROACHING
    cause = Cause.ENDS_RETURNING if ball < 0 else None
    cause = Cause.ENDS_CATCHING_UP if gap is not None and gap < 0 else cause
    cause = Cause.ENDS_HIDDEN if hidden else cause
    return None if parts else cause


def _grazing(inside: Sequence[Collision], gaps: Gaps, end: float) -> Cause | None:
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
    return Cause.GRAZES_WALL


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
    time = gaps.frame[chosen] - gaps.frame[chosen].mean()
    slope, _ = np.polyfit(time, signal[chosen], 1)
    # What a parabola leaves over is noise; its own bend is none.
    left_over = signal[chosen] - np.polyval(np.polyfit(time, signal[chosen], 2), time)
    variance = max(sigma_of(signal) ** 2, float(left_over @ left_over) / max(len(time) - 3, 1))
    return float(slope) if abs(slope) > SIGMAS * np.sqrt(variance / (time @ time)) else 0.0


@dataclass(frozen=True)
class Turning:
    """Where the heavy body, driven back, turns round by itself between two collisions."""

    before: float
    """Frame of the collision before which it has turned; inf where there is none."""
    open_before: float
    """Frame of an earlier collision before which it may have turned; inf where there is none."""
    chance: float
    """Probability that it has not turned before that one; 1 where there is none."""


def first_turn(contacts: Contacts) -> Turning:
    """Find where the heavy body, driven back, turns round between two collisions."""
    open_before, chance = np.inf, 1.0
    heavy = contacts.bodies[1]
    for number, frame in enumerate(contacts.frame[1:].tolist()):
        first, last = float(heavy.rate[number, 1]), float(heavy.rate[number + 1, 0])
        sigmas = heavy.sigma[number, 1], heavy.sigma[number + 1, 0]
        slowed = first - last > SIGMAS * np.hypot(*sigmas)
        if not slowed or first < SIGMAS * sigmas[0] or last > SIGMAS * sigmas[1]:
            continue
        if last < -SIGMAS * sigmas[1]:
            return Turning(frame, open_before, chance)
        if np.isinf(open_before):
            open_before, chance = frame, math.erfc(-last / sigmas[1] / math.sqrt(2.0)) / 2
    return Turning(np.inf, open_before, chance)


STATE_FRAMES = 64.0
"""The state at the end is fitted to at most so many frames."""
POINTS_AT_LEAST = 4
SWING_SHARE = 0.05
"""A cylinder that swings by less than this share of the way it has come is as good as at rest: when
it turns round is not known."""
SAMPLES = 400
CLEARANCE_SHARE = 0.005
"""Paths that come nearer than this share of the bodies' distance to rest are too near to call."""


def parted_until_turn(
    gaps: Gaps, swing: Swing | None, burst: tuple[float, float], struck: float
) -> bool:
    """Whether ball, cylinder and wall stay apart from the last frame to the cylinder's turn.

    Parameters
    ----------
    gaps
        The clip's distances.
    swing
        The cylinder's swing; without it nothing can be foreseen.
    burst
        Frames of the first and the last collision.
    struck
        Frame of the last collision of the cylinder.
    """
    if swing is None or swing.rate_squared < SIGMAS * swing.rate_squared_sigma:
        return False
    final, gone = float(gaps.frame[-1]), last_seen(gaps.frame, gaps.heavy_px)
    before = gaps.ball_px[gaps.frame < burst[0]]
    if not np.isfinite(before).any():
        return False
    rest = float(np.nanmedian(before))
    rate = float(np.sqrt(swing.rate_squared))
    # What the ball meets meanwhile changes nothing for a cylinder out of the picture.
    since = burst[1] if gone == final else struck
    heavy = _state(gaps.frame, gaps.heavy_px - swing.centre_px, rate, (since, gone))
    ball = _state(gaps.frame, gaps.ball_px - rest, rate, (burst[1], final))
    way = float(np.nanmax(gaps.heavy_px) - np.nanmin(gaps.heavy_px))
    if heavy is None or ball is None or np.hypot(*heavy) < SWING_SHARE * way:
        return False
    unseen = rate * (final - gone)
    turn = np.pi / 2 - np.arctan2(*heavy) - unseen
    if turn <= 0:
        return False
    phase = np.linspace(0.0, turn, SAMPLES)
    heavy_path = swing.centre_px + _away(heavy, unseen + phase)
    ball_path = rest + _away(ball, phase)
    contact = float(np.nanmin(gaps.heavy_px - gaps.ball_px))
    wall = float(np.nanmin(gaps.ball_px))
    clear_wall = ball_path - wall > CLEARANCE_SHARE * (rest - wall)
    clear_heavy = heavy_path - ball_path - contact > 0
    return bool(np.all(clear_wall) and np.all(clear_heavy))


def last_seen(frame: Floats, signal: Floats) -> float:
    """Last frame that shows a signal, shape (n,); -inf if none does."""
    return float(frame[np.isfinite(signal)].max(initial=-np.inf))


def _state(
    frame: Floats, away: Floats, rate: float, between: tuple[float, float]
) -> tuple[float, float] | None:
    """Fit a swing about its centre, as its cosine and sine parts at the second of two frames."""
    since, until = between
    chosen = np.isfinite(away) & (frame > max(since + HALF_EXPOSURE, until - STATE_FRAMES))
    chosen &= frame <= until
    if chosen.sum() < POINTS_AT_LEAST:
        return None
    phase = rate * (frame[chosen] - until)
    swing = np.column_stack([np.cos(phase), np.sin(phase)])
    cosine, sine = np.linalg.lstsq(swing, away[chosen], rcond=None)[0]
    return float(cosine), float(sine)


def _away(state: tuple[float, float], phase: Floats) -> Floats:
    """Distances of a pendulum from its centre at phases after a state."""
    return state[0] * np.cos(phase) + state[1] * np.sin(phase)

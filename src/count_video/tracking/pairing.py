"""From bodies that were followed to tracks: which two may be a pair, and where each was.

Only the ball bounces off the wall: on the side away from its neighbour it reverses with a jump of
its velocity. The heavy body reverses on its far side too, when it swings back, but smoothly.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, permutations

import numpy as np

from count_video.records import (
    BodyTrack,
    CameraTurns,
    Floats,
    Indices,
    Mask,
    MotionLine,
    Track,
    WallSide,
)
from count_video.signals import NOISE_AT_LEAST_PX, low_points, noise_px, sigma_of
from count_video.tracking.following import Followed, was_followed
from count_video.tracking.shape import size_of
from count_video.tracking.turning import Turns
from count_video.tracking.view import View

PAIRS_AT_MOST = 3
"""So many pairs of bodies are offered, should the likeliest not collide."""
OPPOSITE_AT_LEAST = 0.05
"""Where contacts follow each other faster than the frames, opposite jumps do not show: pairs are
then ranked by what else they do, behind most that show some."""
EXCHANGED = 0.5
"""Two bodies exchange momentum if the correlation of their jumps is farther below 0 than this."""
ORDERED_SHARE = 0.75
"""Share of the common sightings in which the order of two neighbours holds."""
MIRROR_SHARE = 0.05
"""Places whose sum varies by less than this share of their difference are mirror images; where it
is the difference that hardly varies, they are parts of one body."""
NEAR_SHARE = 0.5
"""Outlines of bodies that touch overlap or leave a gap, but none of this share of their size."""
CONTACT_SPREAD_PX = 2.0
"""Two bodies touch at one distance: by so much it scatters between contacts."""
REVERSAL_SIGMAS = 8.0
REVERSAL_AT_LEAST_PX = 0.4
SPAN_FRAMES = 3
"""The jump is read between the mean velocities over so many frames on either side."""
LEAVES_WITHIN = 8
"""Pictures after that which showed a body last, in which it reaches the border if it leaves; fewer
than these may show a title."""


@dataclass(frozen=True)
class Movers:
    """The bodies that move in a clip, those with most corners first."""

    bodies: list[Followed]
    """In pictures that are transposed where ``upright``."""
    tilt_deg: float
    """Direction of motion in those pictures, from their x axis."""
    upright: bool
    """True if the pictures were transposed because the bodies move up and down."""
    shift_px: Floats | None
    """How the camera moved each picture, by image x and y, shape (n, 2); None where it stood."""
    turns: Turns | None = None
    """How it turned and scaled each picture; None where it did not. All else is freed of it."""


def pair_tracks(
    movers: Movers, frames: Indices, view: View, wall: WallSide | None = None
) -> list[Track]:
    """Tracks of the pairs that may be ball and heavy body, the likeliest first.

    ``frames`` are the indices of the pictures in which the movers were sought, shape (n,), ``view``
    is the view of them, and ``wall`` the side of the wall; None to find it by the motion.
    """
    pairs = ranked_pairs(movers.bodies)[:PAIRS_AT_MOST]
    tracks = (_track(pair, movers, frames, view, wall) for pair in pairs)
    return [track for track in tracks if track is not None]


def ranked_pairs(found: Sequence[Followed]) -> list[tuple[Followed, Followed]]:
    """Pairs of bodies that may collide, the likeliest first, each with the body on the left first.

    Only where no two move on one line, one of them may be the mirror image or the shadow of a body
    that was not followed: it moves as the body does.
    """
    pairs = _neighbours(found)
    some = list(filter(_on_one_line, pairs)) or pairs
    return sorted(some, key=lambda pair: -_score(*pair))


def has_pair(found: Sequence[Followed]) -> bool:
    """Whether two of the bodies move as ball and heavy body do.

    One is a ball by its outline, or momentum goes from one to the other at each of their contacts.
    """
    return any(
        _meet(left, right)
        and _score(left, right) > 0
        and (left.body.round_ or right.body.round_ or _opposite(left, right) > EXCHANGED)
        for left, right in filter(_on_one_line, _neighbours(found))
    )


def _gap(left: Followed, right: Followed) -> tuple[Floats, Indices]:
    """How far two bodies are apart in each picture, and in which rows they are nearest."""
    gap = right.edges_px[0] - left.edges_px[1]
    return gap, low_points(gap, 6.0 * sigma_of(gap))


def _neighbours(found: Sequence[Followed]) -> list[tuple[Followed, Followed]]:
    """Pairs of bodies that move side by side, the one on the left first."""
    pairs = ((one, other) for two in combinations(found, 2) for one, other in permutations(two))
    return [pair for pair in pairs if _side_by_side(*pair)]


def _on_one_line(pair: tuple[Followed, Followed]) -> bool:
    """Whether two bodies overlap across their motion in the pictures that show both."""
    both = np.isfinite(pair[0].x_px + pair[1].x_px)
    levels = [float(np.median(one.middle_px[both, 1])) for one in pair]
    heights = [size_of(one.body.box)[1] for one in pair]
    return abs(levels[0] - levels[1]) <= sum(heights) / 2


def _meet(left: Followed, right: Followed) -> bool:
    """Whether two bodies come so near that they may touch, but do not pass over each other."""
    gap, _ = _gap(left, right)
    return abs(float(np.nanmin(gap))) < NEAR_SHARE * _least_size_px(left, right)


def _least_size_px(left: Followed, right: Followed) -> float:
    """Width or height of two bodies, whichever is the least."""
    return min(*size_of(left.body.box), *size_of(right.body.box))


def _side_by_side(left: Followed, right: Followed) -> bool:
    """Whether one body stays to the left of the other, and both move each on its own."""
    if not (was_followed(left.x_px) and was_followed(right.x_px)):
        return False
    a, b = left.edges_px[1], right.edges_px[0]
    both = np.isfinite(a) & np.isfinite(b)
    apart = (right.middle_px - left.middle_px)[:, 0]
    if np.count_nonzero(both) < 4 or np.mean(apart[both] > 0) < ORDERED_SHARE:
        return False
    together, away = float(np.std((a + b)[both])), float(np.std((a - b)[both]))
    return min(together, away) > MIRROR_SHARE * max(together, away)


def _score(left: Followed, right: Followed) -> float:
    """How much two bodies move as ball and heavy body do: in px per frame of velocity jumps.

    They repel each other, always at the same distance, and one of them bounces off something on
    its far side.
    """
    gap, lows = _gap(left, right)
    spread = float(np.median(np.abs(gap[lows] - np.median(gap[lows])))) if len(lows) else 0.0
    walls = max(far_side_jump(left.edges_px[0]), far_side_jump(-right.edges_px[1]))
    size = _least_size_px(left, right)
    noise = max(float(np.nanmedian(np.hypot(left.sigma_px, right.sigma_px))), NOISE_AT_LEAST_PX)
    jumps = max(_opposite(left, right), OPPOSITE_AT_LEAST)
    whole = (far_side_jump(gap) + walls) * size / noise
    return jumps * whole / (1 + (spread / CONTACT_SPREAD_PX) ** 2)


def _opposite(one: Followed, other: Followed) -> float:
    """How much velocities jump in opposite directions, in one ratio: from 0 to 1.

    It is minus the correlation (about 0) of the two bodies' jumps at their contacts, by which
    momentum goes from one to the other, adjusted for the ratio that one of them gives (Ezekiel
    1930).
    """
    _, contacts = _gap(one, other)
    jumps = np.array([_jumps(seen.x_px, contacts) for seen in (one, other)])
    known = np.isfinite(jumps).all(axis=0)
    left, right = jumps[:, known]
    count, size = np.count_nonzero(known), float((left @ left) * (right @ right))
    product = min(float(left @ right), 0.0)
    if count < 2 or size == 0:
        return 0.0
    return float(np.sqrt(max(0.0, 1 - (1 - product**2 / size) * count / (count - 1))))


def _track(
    pair: tuple[Followed, Followed],
    movers: Movers,
    frames: Indices,
    view: View,
    given: WallSide | None,
) -> Track | None:
    """Make the track of two bodies, the one on the left (or above) first; None if one was lost."""
    axis = int(movers.upright)
    places = [places_of(one, movers, view) for one in pair]
    paths = [one.xy_px[:, axis] for one in places]
    if not all(map(was_followed, paths)):
        return None
    halves = [float(one.size_px[axis]) / 2 for one in places]
    found = wall_side(paths[0] - halves[0], paths[1] + halves[1])
    side: WallSide = given or found or "left"
    ball, heavy = (0, 1) if side == "left" else (1, 0)
    # Of the cylinder it is the place of the face that the ball strikes.
    low, high = (0.0, 2 * halves[heavy]) if side == "left" else (-2 * halves[heavy], 0.0)
    x, y = np.nanmedian(places[ball].xy_px, axis=0).tolist()
    return Track(
        frame=frames.astype(np.float64),
        ball=BodyTrack(paths[ball], places[ball].sigma_px, -halves[ball], halves[ball]),
        heavy=BodyTrack(paths[heavy] - (low + high) / 2, places[heavy].sigma_px, low, high),
        wall_side=side,
        ball_diameter_px=2 * halves[ball],
        line=MotionLine(x, y, movers.tilt_deg, movers.upright),
        warnings=(
            *unseen_warning("ball", paths[ball]),
            *unseen_warning("cylinder" if given or found else "other body", paths[heavy]),
            *contradiction(given, found),
        ),
        shift_px=camera_shift(movers, view),
        turned=camera_turned(movers, view),
        wall_seen=bool(given or found),
        stamped=view.footage.stamped(frames),
        lost_beyond=tuple(frame for one in places for frame in lost_beyond(one, frames, view)),
    )


def lost_beyond(body: Places, frames: Indices, view: View) -> Iterator[float]:
    """Yield the first and the last frame that show a body, where it is lost within the picture.

    One that leaves it would reach its border soon after, if it went on as it was last seen.
    """
    seen = np.flatnonzero(body.seen)
    corner, size = np.split(np.array(view.region), 2)
    for last, before, end in ((seen[0], seen[1], 0), (seen[-1], seen[-2], len(frames) - 1)):
        step = (body.xy_px[last] - body.xy_px[before]) / abs(last - before)
        soon = body.xy_px[last] + LEAVES_WITHIN * step
        inside = np.abs(soon - corner - size / 2) < (size - body.size_px) / 2
        if abs(last - end) > LEAVES_WITHIN and inside.all():
            yield float(frames[last])


@dataclass(frozen=True)
class Places:
    """Where the middle of a body's outline was in n pictures, in px of the footage.

    Places are NaN where it is not seen for sure.
    """

    xy_px: Floats
    """By image x and y, shape (n, 2)."""
    sigma_px: Floats
    """Standard uncertainty along the line of motion, shape (n,)."""
    size_px: Floats
    """Width and height, shape (2,)."""

    @property
    def seen(self) -> Mask:
        """Which pictures show it, shape (n,)."""
        return np.isfinite(self.xy_px[:, 0])


def places_of(body: Followed, movers: Movers, view: View) -> Places:
    """Turn places of a template in a view into those of the body in the footage."""
    middle = np.where(np.isfinite(body.sure_x_px)[:, None], body.middle_px, np.nan)
    axes = [1, 0] if movers.upright else [0, 1]
    size, sigma = np.array(size_of(body.body.box))[axes], body.sigma_px
    return Places(view.in_picture(middle[:, axes]), view.factor * sigma, view.factor * size)


def camera_shift(movers: Movers, view: View) -> Floats | None:
    """How far the camera moved each picture, shape (n, 2), in px of the footage; None if not."""
    return None if movers.shift_px is None else view.factor * movers.shift_px


def camera_turned(movers: Movers, view: View) -> CameraTurns | None:
    """How the camera turned each picture, about the middle of the view; None if it did not."""
    if movers.turns is None:
        return None
    x, y, width, height = view.region
    both = np.stack([movers.turns.real, movers.turns.imag], axis=1)
    return CameraTurns(both, (x + (width - 1) / 2, y + (height - 1) / 2))


def unseen_warning(name: str, x_px: Floats) -> list[str]:
    """Say in how many frames a body is not seen, if there are any."""
    unseen = int(np.isnan(x_px).sum())
    return [f"the {name} is not seen in {unseen} of {len(x_px)} frames"] if unseen else []


def contradiction(given: WallSide | None, found: WallSide | None) -> list[str]:
    """Say so if the ball bounces on another side than that on which the wall is said to stand."""
    if given is None or found is None or given == found:
        return []
    return [f"a body turns with jumps on the {found}, where no wall is said to be: check --wall"]


def wall_side(left_px: Floats, right_px: Floats) -> WallSide | None:
    """Find the side of the wall from the places of the left and the right body, shape (n,).

    It is ``left`` if the left body is the ball; None if neither bounces on its far side.
    """
    left, right = far_side_jump(left_px), far_side_jump(-right_px)
    if left == right == 0.0:
        return None
    return "left" if left > right else "right"


def far_side_jump(distance_px: Floats) -> float:
    """Sum of the velocity jumps, in px per frame, at the low points of a distance."""
    depth = max(REVERSAL_AT_LEAST_PX, REVERSAL_SIGMAS * noise_px(distance_px))
    return float(np.nansum(_jumps(distance_px, low_points(distance_px, depth))))


def _jumps(path_px: Floats, rows: Indices) -> Floats:
    """Change of velocity at these rows, between means over some frames; NaN near the ends."""
    jumps = np.full(len(rows), np.nan)
    inner = (rows >= SPAN_FRAMES) & (rows < len(path_px) - SPAN_FRAMES)
    at = rows[inner]
    second = path_px[at + SPAN_FRAMES] - 2 * path_px[at] + path_px[at - SPAN_FRAMES]
    jumps[inner] = second / SPAN_FRAMES
    return jumps

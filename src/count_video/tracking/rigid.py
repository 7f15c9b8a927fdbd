"""Trajectories of corners gathered into rigid bodies.

Two corners belong to one body if their distance stays the same, within the noise of following
them, while both move. The corner with most such partners begins a body; its members are those that
keep their distance from the common path. The rest begins the next body. Bodies are solid: what
surrounds one that moves otherwise is none.

All sums over samples run over those in which a corner was followed: with the indicator M, shape
(corners, samples), and places x that are 0 elsewhere, the sums over the samples that two corners
share are the products x @ M.T and the like.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from count_video.records import Floats, Indices, Mask, Pixels
from count_video.tracking.corners import Trajectories
from count_video.tracking.shape import known_of

RIGID_PX = 0.45
"""Standard deviation of a distance that is taken for constant: following a corner errs by 0.1 to
0.3 px."""
SMEARED_SHARE = 0.1
"""What moves is smeared, and followed worse by this share of its way from sample to sample."""
MOVED_PX = 2.0
"""Corners that move by less than this over the clip show nothing of a motion."""
SHARED_SPAN_PX = 4 * RIGID_PX
"""In the samples that two corners share they move by so much at least."""
SHARED_SAMPLES = 5
SHARED_SHARE = 0.05
"""Two corners are compared by so many samples, and this share of all, at least."""
NEAR_SHARE = 0.9
"""Members keep their distance from the common path in this share of the samples."""
TOGETHER_SHARE = 0.6
"""Paths of one body keep their distance in this share of the samples, and move in them: in others
the corners of either may have slid to what passes by."""
CORNERS_AT_LEAST = 4
BODIES_AT_MOST = 8
OUTERMOST = 0.05, 0.95
"""A body's corners lie between these quantiles: one of a few beyond may have slid to another."""
OFTEN_SHARE = 0.3
"""Corners followed through a smaller share of the samples than the best one are no part of the
template."""
SHAKEN_PX = 0.5
"""A background that moves by less than this stands still."""
SCENE_SPREAD = 0.4
"""Corners of the background spread over this share of the picture's width or height; those of a
cylinder over a third of it."""
SCENE_SEEN = 0.6
"""Corners of the background are followed through this share of the samples."""
ROUNDS = 3


@dataclass(frozen=True)
class RigidGroup:
    """Corners that move as one rigid body, in px of the samples."""

    path_px: Floats
    """Common path by image x and y, shape (samples, 2); NaN where no corner was followed."""
    corners_px: Floats
    """Places of the corners from the path, shape (corners, 2)."""
    blurred: bool = False
    """Whether the path is right to some px only: a region's, whose corners these are."""


def rigid_groups(trajectories: Trajectories, scene_px: Floats) -> list[RigidGroup]:
    """Gather corners that move into rigid bodies, those with most corners first.

    ``scene_px`` is how far the camera has moved each sample, shape (samples, 2); paths are those
    in the pictures as they are.
    """
    places = trajectories.places_px - scene_px.astype(np.float32)
    seen = np.isfinite(places[:, :, 0])
    moving = _moving(places, seen)
    places, seen = places[moving], seen[moving]
    joined = _joined(places, seen)
    partners, weight = joined.astype(np.float32), np.sqrt(seen.sum(axis=1, dtype=np.float32))
    left = np.ones(len(moving), np.bool_)
    found: list[Indices] = []
    while len(found) < BODIES_AT_MOST:
        enough = left & (partners @ left >= CORNERS_AT_LEAST)
        if not enough.any():
            break
        centre = int(np.argmax(np.where(enough, partners @ (weight * left), 0)))
        members = _settled(
            places, seen, np.flatnonzero(left), np.flatnonzero(left & joined[centre])
        )
        if len(members) >= CORNERS_AT_LEAST:
            found.append(members)
            left[members] = False
        else:
            left[centre] = False
    groups = [_group(places, seen, members, scene_px) for members in _merged(places, seen, found)]
    solid = [one for one in groups if not any(_surrounds(one, other) for other in groups)]
    return sorted(solid, key=lambda group: -len(group.corners_px))


def _surrounds(one: RigidGroup, other: RigidGroup) -> bool:
    """Whether the corners of one surround another that moves otherwise, and further.

    Corners of what hardly moves keep their distances by chance, wherever in the picture they are.
    """
    apart = known_of(other.path_px - one.path_px)
    here, there = (float(np.ptp(known_of(group.path_px), axis=0).max()) for group in (one, other))
    if there <= here or len(apart) == 0 or apart.std(axis=0).max() < MOVED_PX:
        return False
    middle = apart + other.corners_px.mean(axis=0)
    low, high = np.quantile(one.corners_px, OUTERMOST, axis=0)
    inside = (middle > low) & (middle < high)
    return bool(inside.all(axis=1).mean() > 0.5)


def scene_path(trajectories: Trajectories, shape: tuple[int, ...]) -> Floats:
    """How far the camera has moved each sample, shape (samples, 2); 0 where nothing shows it.

    Corners that keep their distances make rigid scenes. That with most corners, spread furthest,
    is taken for the background, if it spreads further than a body, and unless what stays in its
    place in the picture is more: corners of a plain background jitter each by itself. ``shape`` is
    that of a sample.
    """
    whole = trajectories.seen.mean(axis=1) > SCENE_SEEN
    places, seen = trajectories.places_px[whole], trajectories.seen[whole]
    still = np.zeros(trajectories.places_px.shape[1:])
    joined = _joined(places, seen, still=True)
    # Corners of one scene name the same ones.
    scenes = [np.flatnonzero(row) for row in np.unique(joined, axis=0)]
    scenes = [one for one in scenes if len(one) >= CORNERS_AT_LEAST]
    if not scenes:
        return still
    spread = np.array([_spread(places[members], shape) for members in scenes])
    widest = int(np.argmax(spread * [len(members) for members in scenes]))
    members, strays = scenes[widest], _strays_px(places)
    at_rest = places[strays < strays[members].mean() - SHAKEN_PX]
    stands = len(at_rest) * _spread(at_rest, shape) > len(members) * spread[widest]
    if stands or spread[widest] < SCENE_SPREAD:
        return still
    path = _path(places[members], seen[members])
    if not np.isfinite(path).any():
        return still
    path -= np.nanmedian(path, axis=0)
    moves = float(np.nanmax(path) - np.nanmin(path)) > SHAKEN_PX
    return np.nan_to_num(path) if moves else still


def _means(places: Pixels) -> Floats:
    """Mean place of each corner, shape (corners, 2)."""
    return np.asarray(np.nanmean(places, axis=1), np.float64)


def _spread(places: Pixels, shape: tuple[int, ...]) -> float:
    """Over what share of a picture's width or height corners spread."""
    if len(places) == 0:
        return 0.0
    return float(np.max(np.ptp(_means(places), axis=0) / shape[::-1]))


def _strays_px(places: Pixels) -> Floats:
    """Root mean square displacement of each corner from its mean place, in px, shape (corners,)."""
    away = places - _means(places)[:, None]
    return np.asarray(np.sqrt(np.nanmean(away**2, axis=(1, 2))))


def _moving(places: Pixels, seen: Mask) -> Indices:
    enough = seen.sum(axis=1) >= _shared_at_least(seen)
    highest = np.where(seen[:, :, None], places, -np.inf).max(axis=1)
    lowest = np.where(seen[:, :, None], places, np.inf).min(axis=1)
    return np.flatnonzero(enough & ((highest - lowest).max(axis=1) > MOVED_PX))


def _shared_at_least(seen: Mask) -> float:
    return max(float(SHARED_SAMPLES), SHARED_SHARE * float(seen.shape[1]))


def _joined(places: Pixels, seen: Mask, *, still: bool = False) -> Mask:
    """Which corners keep their distance from which while they move, or at all; shape (n, n)."""
    indicator = seen.astype(np.float32)
    shared = indicator @ indicator.T
    count = np.maximum(shared, 1)
    apart, span = np.zeros_like(shared), np.zeros_like(shared)
    step = _steps_px(places, seen)
    noise = RIGID_PX**2 + (SMEARED_SHARE * np.minimum(step[:, None], step)) ** 2
    for axis in range(2):
        # About the mean of each corner, so that sums of squares keep their digits.
        x = np.where(seen, places[:, :, axis], 0)
        x -= (x.sum(axis=1) / seen.sum(axis=1))[:, None] * indicator
        sums, squares, products = x @ indicator.T, (x * x) @ indicator.T, x @ x.T
        mean = (sums - sums.T) / count
        apart += np.maximum((squares + squares.T - 2 * products) / count - mean**2, 0)
        own = squares / count - (sums / count) ** 2
        span += np.minimum(own, own.T)
    # An even motion over a span has a standard deviation of that span over the root of 12.
    moved = still | (span > SHARED_SPAN_PX**2 / 12)
    joined = (shared >= _shared_at_least(seen)) & (apart < noise) & moved
    np.fill_diagonal(joined, True)
    return np.asarray(joined)


def _steps_px(places: Pixels, seen: Mask) -> Pixels:
    """Root mean square step of each corner from sample to sample, shape (corners,)."""
    both = seen[:, 1:] & seen[:, :-1]
    squares = np.where(both[:, :, None], np.diff(places, axis=1) ** 2, 0).sum(axis=(1, 2))
    return np.asarray(np.sqrt(squares / np.maximum(both.sum(axis=1), 1)), np.float32)


def _noise_px(path: Floats) -> Floats:
    """How far corners may seem to be from their place on a path, in each sample, shape (samples,).

    Where a step is not known the body is taken to rest.
    """
    step = np.hypot(*np.gradient(path, axis=0).T)
    return np.asarray(np.hypot(RIGID_PX, SMEARED_SHARE * np.nan_to_num(step)))


def _settled(places: Pixels, seen: Mask, candidates: Indices, members: Indices) -> Indices:
    """Members of a body: the candidates that keep their distance from its common path."""
    for _ in range(ROUNDS):
        if len(members) < CORNERS_AT_LEAST:
            break
        path = _path(places[members], seen[members])
        members = candidates[_keeps(places[candidates], seen[candidates], path)]
    return members


def _path(places: Pixels, seen: Mask) -> Floats:
    """Find the common path of corners of one body, shape (samples, 2).

    The corner that was followed longest gives a first path; the offsets of the others from it, and
    then the mean of all corners less their offsets, follow in turns. Corners far off are left out.
    """
    path = places[int(np.argmax(seen.sum(axis=1)))].astype(np.float64)
    for _ in range(ROUNDS):
        offset, error = _offsets(places, seen, path)
        known = np.asarray(np.isfinite(error))
        offset = np.where(np.isfinite(offset), offset, 0.0)
        use = seen & np.asarray(np.isfinite(offset).all(axis=1))[:, None]
        use &= (known & (error < 2 * _noise_px(path))) | ~np.asarray(np.isfinite(path[:, 0]))[None]
        total = np.where(use[:, :, None], places - offset[:, None], 0.0).sum(axis=0)
        count = use.sum(axis=0)[:, None]
        path = np.where(count > 0, total / np.maximum(count, 1), np.nan)
    return np.asarray(path, dtype=np.float64)


def _offsets(places: Pixels, seen: Mask, path: Floats) -> tuple[Floats, Floats]:
    """Offset of each corner from a path, shape (n, 2), and its distance then, shape (n, samples).

    NaN where corner and path share no sample.
    """
    known = seen & np.isfinite(path[:, 0])[None]
    count = np.maximum(known.sum(axis=1), np.finfo(np.float32).tiny)
    offset = np.empty((len(places), 2))
    error = np.where(known, np.float32(0.0), np.float32(np.nan))
    for axis in range(2):
        away = np.where(known, places[:, :, axis] - path[:, axis].astype(np.float32), 0)
        offset[:, axis] = np.where(count >= 1, away.sum(axis=1, dtype=np.float64) / count, np.nan)
        away -= offset[:, axis, None].astype(np.float32)
        error = np.maximum(error, np.abs(away))
    return offset, error


def _keeps(places: Pixels, seen: Mask, path: Floats) -> Mask:
    """Whether corners keep their distance from a path in most samples, shape (n,)."""
    _, error = _offsets(places, seen, path)
    known = np.isfinite(error)
    count = known.sum(axis=1)
    near = (known & (error < _noise_px(path))).sum(axis=1) >= NEAR_SHARE * count
    span = np.zeros(len(places))
    for along in path.T:
        highest, lowest = (np.where(known, along, end) for end in (-np.inf, np.inf))
        span = np.maximum(span, highest.max(axis=1) - lowest.min(axis=1))
    return np.asarray(near & (count >= SHARED_SAMPLES) & (span > SHARED_SPAN_PX))


def _merged(places: Pixels, seen: Mask, found: list[Indices]) -> list[Indices]:
    """Join groups whose paths keep their distance where both are known."""
    groups = [(members, _path(places[members], seen[members])) for members in found]
    place = 0
    while place < len(groups):
        members, path = groups[place]
        partner = next(
            (k for k in range(place + 1, len(groups)) if _same_body(path, groups[k][1])), None
        )
        if partner is None:
            place += 1
            continue
        joined = np.concatenate([members, groups.pop(partner)[0]])
        groups[place] = joined, _path(places[joined], seen[joined])
    return [members for members, _ in groups]


def _same_body(one: Floats, other: Floats) -> bool:
    both = np.isfinite(one[:, 0]) & np.isfinite(other[:, 0])
    if np.count_nonzero(both) < SHARED_SAMPLES:
        return False
    away = one[both] - other[both]
    noise = np.maximum(_noise_px(one), _noise_px(other))[both]
    together = np.abs(away - np.median(away, axis=0)).max(axis=1) < 2 * noise
    if together.mean() < TOGETHER_SHARE:
        return False
    return float(np.ptp(one[both][together], axis=0).max()) > 2 * SHARED_SPAN_PX


def _group(places: Pixels, seen: Mask, members: Indices, scene_px: Floats) -> RigidGroup:
    path = _path(places[members], seen[members])
    offset, _ = _offsets(places[members], seen[members], path)
    # Of a body that comes into the picture, only what is seen most of the time.
    often = seen[members].sum(axis=1)
    good = np.isfinite(offset).all(axis=1) & (often >= OFTEN_SHARE * often.max())
    return RigidGroup(path + scene_px, offset[good])

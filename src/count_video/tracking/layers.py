"""One body after the other: learnt from what those that are known leave unexplained."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import permutations

import numpy as np

from count_video.records import Floats, Indices, Mask
from count_video.signals import MEDIAN_TO_SIGMA, running_median
from count_video.tracking.composite import Source
from count_video.tracking.cutting import EDGE_PX
from count_video.tracking.disc import Disc
from count_video.tracking.following import Clip, Followed, follow, was_followed
from count_video.tracking.learning import Body, learn
from count_video.tracking.outline import BEYOND_OUTLINE_PX
from count_video.tracking.paths import Rough
from count_video.tracking.round_bodies import find_ball
from count_video.tracking.shape import Shape, size_of

STEADY_AT_LEAST = 6
MOVES_PX = 2.0
"""A body moves by so much at least."""
JUMP_STEPS, JUMP_PX, JUMPS_SHARE = 5.0, 3.0, 0.5
"""A step that is so many times as long as the running median, picture by picture, and so many px,
is a jump; those of a body make up less than this share of its way in between, each by the share of
the sightings that it leads astray."""
BLUR_PX = EDGE_PX + BEYOND_OUTLINE_PX
"""So far beyond its outline a body is cut out."""
SAME_BODY_PX, SMEARED_SHARE = 1.0, 0.1
"""Two templates whose distance varies by less than this are parts of one body, and by this share of
its way from one picture to the next."""
CLEARER_VARIANCE = 2.0
"""One takes another's place if the variance of its place is so many times less."""
ALIKE_SHARE = 0.9
"""A ball looks alike in fewer of the pictures that show it only if its surface changes."""
FIXED_VARIANCE = 4.0
"""What is fixed to a ball has a distance from its outline that varies by less than so many times
the variance of the outline's place."""
SAME_SIZE, SAME_SIZE_PX = 0.05, 2.0
"""Outlines are right to this share of their size, and to so many px."""
NEIGHBOURS = 2
"""So many others have a say in where a body ends, and in which pictures it is learnt from."""
BODIES_AT_MOST, BODIES_ENOUGH = 6, 2
"""So many bodies are followed that have many corners; others only if these are fewer than two."""


def add_bodies(
    clip: Clip, roughs: Sequence[Rough], known: Sequence[Followed], in_vain: Sequence[Rough] = ()
) -> tuple[list[Followed], list[Rough]]:
    """Learn and follow bodies beside those that are known, each only once.

    Proposals that were tried ``in_vain`` before are not tried again. Returns all bodies, and all
    proposals that gave none.
    """
    found, failed = list(known), list(in_vain)
    # Paths of corners are exact, those of regions right to some px.
    for rough in sorted(roughs, key=lambda one: one.blurred):
        enough = BODIES_AT_MOST if rough.sure else BODIES_ENOUGH
        if len(found) - len(known) >= enough:
            break
        bodies = [clip.shape(other) for other in found]
        if any(Shape(rough.path_px, rough.box).holds(body) for body in bodies):
            continue
        if any(_alike(rough, one) for one in in_vain):
            continue
        others = [other.path_px for other in roughs if other is not rough][:NEIGHBOURS]
        # Paths of corners are exact; those of its own are no other's.
        exact = [other.corners for other in roughs if not other.blurred]
        seeds = [seed for seed in exact if not seed.moves_with(rough.corners)]
        hide = [*seeds, *(one for one in bodies if rough.blurred or not one.holds(rough.corners))]
        paths = [seed.path_px for seed in seeds]
        source = Source(clip.pictures, clip.background, hide, paths[:NEIGHBOURS])
        body = learn(source, rough, others)
        seen = follow(clip, body) if body is not None and body.round_ else None
        if seen is None or not _is_steady(seen, rough):
            body = _or_ball(clip, rough, body, bodies)
        if body is None or any(
            _part_of(body, other, clip) and _stands_for_both(other.body, body) for other in found
        ):
            failed.append(rough)
            continue
        if seen is None or seen.body is not body:
            seen = follow(clip, body)
        moves = was_followed(seen.x_px) and max(_ways_px(seen), default=0.0) > MOVES_PX
        alike = [same_body(seen.xy_px, other.xy_px) for other in found]
        if moves and not any(_stands_for_both(found[k].body, body) for k in np.flatnonzero(alike)):
            found = [other for other, same in zip(found, alike, strict=True) if not same]
            found.append(seen)
        else:
            failed.append(rough)
    return found, failed


def _or_ball(clip: Clip, rough: Rough, body: Body | None, known: Sequence[Shape]) -> Body | None:
    """Take a ball whose surface changes for what was learnt of it: a part, or a rare view."""
    source = Source(clip.pictures, clip.background, known)
    ball = find_ball(source, rough.path_px, rough.box)
    if ball is None and body is not None:
        ball = find_ball(source, body.path_px, body.box)
    if ball is None or body is None:
        return ball or body
    return body if is_fixed_to(body, ball, clip) else ball


def is_fixed_to(body: Body, ball: Body, clip: Clip) -> bool:
    """Whether a template is seen wherever the outline of a ball is, and in one place of it.

    A mark on a ball that turns moves within the outline.
    """
    outline = follow(clip, ball)
    away = (follow(clip, body).xy_px - outline.xy_px)[np.isfinite(outline.x_px)]
    seen = np.isfinite(away[:, 0])
    if not seen.any() or seen.mean() < ALIKE_SHARE:
        return False
    away = away[seen]
    spread = MEDIAN_TO_SIGMA * np.median(np.abs(away - np.median(away, axis=0)), axis=0)
    return bool((spread**2 < FIXED_VARIANCE * ball.template.shift_variance).all())


def _is_steady(seen: Followed, rough: Rough) -> bool:
    """Whether nearly all pictures show a template that are to show it.

    They are those in which its proposal is known, and all from the first that shows it to the last.
    """
    known = np.isfinite(seen.x_px)
    between = np.logical_or.accumulate(known) & np.logical_or.accumulate(known[::-1])[::-1]
    asked = between | np.isfinite(rough.path_px[:, 0])
    return bool(known[asked].mean() >= ALIKE_SHARE)


def _of_one_size(one: Body, other: Body) -> bool:
    """Whether two outlines are as wide and as high as each other."""
    size, usual = (np.array(size_of(body.box)) for body in (one, other))
    return bool((np.abs(size - usual) <= np.maximum(SAME_SIZE_PX, SAME_SIZE * usual)).all())


def _stands_for_both(body: Body, other: Body) -> bool:
    """Whether the first of two that move alike stands for both: the other is not much clearer.

    A body is much clearer than its mirror image or its shadow, and than a part of it.
    """
    return body.template.shift_variance <= CLEARER_VARIANCE * other.template.shift_variance


def apart(followed: Sequence[Followed]) -> list[Followed]:
    """Bodies that move, each only once and each in a place of its own.

    Of two templates of one body, as it is and smeared by its motion, the second fills gaps of the
    first.
    """
    once: dict[int, Followed] = {}
    order = sorted(
        enumerate(followed), key=lambda one: (not _moves(one[1]), -np.isfinite(one[1].x_px).sum())
    )
    for number, seen in order:
        if max(_ways_px(seen), default=0.0) > MOVES_PX:  # it does not only jump
            alike = (k for k, other in once.items() if same_body(seen.xy_px, other.xy_px))
            first = next(alike, number)
            once[first] = _filled(once[first], seen) if first in once else seen
    return _in_places_of_their_own([once[number] for number in sorted(once)])


def _filled(one: Followed, other: Followed) -> Followed:
    """Fill gaps of a path by another one of the same body."""
    gaps = np.isnan(one.x_px)
    x, y = (other.xy_px + np.nanmedian(one.xy_px - other.xy_px, axis=0)).T
    return replace(
        one,
        x_px=np.where(gaps, x, one.x_px),
        y_px=np.where(gaps, y, one.y_px),
        sigma_px=np.where(gaps, other.sigma_px, one.sigma_px),
    )


def _in_places_of_their_own(once: Sequence[Followed]) -> list[Followed]:
    """Leave out where the middle of a body lies in another that is followed for longer there."""
    paths = [_unbroken(seen) for seen in once]
    lost = [np.zeros(len(path), np.bool_) for path in paths]
    for one, other in permutations(range(len(once)), 2):
        shorter = paths[one] < paths[other]
        lost[one] |= shorter & _overlap(once[one], once[other])
    kept = [seen.only(~rows) for seen, rows in zip(once, lost, strict=True)]
    return [seen for seen in kept if _moves(seen)]


def _unbroken(seen: Followed) -> Indices:
    """Length of the unbroken path that each sighting is part of, shape (n,)."""
    length = np.zeros(len(seen.x_px), np.intp)
    for piece in _pieces(seen):
        length[piece] = len(piece)
    return length


def _pieces(seen: Followed) -> list[Indices]:
    """Which pictures show the unbroken pieces of a path."""
    known = np.flatnonzero(np.isfinite(seen.x_px))
    return np.split(known, np.flatnonzero(_jumps(seen)) + 1)


def _ways_px(seen: Followed) -> list[float]:
    """How far a body gets in each unbroken piece of its path, by x and y together."""
    pieces = (piece for piece in _pieces(seen) if len(piece))
    return [float(_way_px(seen.xy_px[piece]).sum()) for piece in pieces]


def _way_px(path_px: Floats) -> Floats:
    """How far a path, shape (n, 2), leads by x and by y, but for misplaced places.

    A ball may rest for all of a clip but these.
    """
    return np.asarray(np.ptp(running_median(path_px), axis=0))


def _overlap(one: Followed, other: Followed) -> Mask:
    """Where the middle of one of two bodies lies within the outline of the other, shape (n,)."""
    reach = np.maximum(size_of(one.body.box), size_of(other.body.box)) / 2
    return np.asarray((np.abs(one.middle_px - other.middle_px) < reach).all(axis=1))


def _jumps(seen: Followed) -> Mask:
    """Which steps from one sighting to the next are too long for a body, shape (sightings - 1,)."""
    known = np.flatnonzero(np.isfinite(seen.x_px))
    steps = np.hypot(np.diff(seen.x_px[known]), np.diff(seen.y_px[known]))
    if len(steps) == 0:
        return np.zeros(0, np.bool_)
    apart = np.diff(known)
    usual = running_median(steps / apart)
    return np.asarray(steps > JUMP_STEPS * usual * apart + JUMP_PX)


def _moves(seen: Followed) -> bool:
    """Whether a template was followed along a path: scenery stays, or is mistaken for its like."""
    x, y = (place[np.isfinite(place)] for place in (seen.x_px, seen.y_px))
    if len(x) < STEADY_AT_LEAST:
        return False
    jumps = np.flatnonzero(_jumps(seen))
    # Before the first jump, or after the last one, few pictures may show something else.
    astray = np.minimum(jumps + 1, len(x) - jumps - 1) / (len(x) / 2)
    jumped = float(np.hypot(np.diff(x), np.diff(y))[jumps] @ astray)
    way = sum(_ways_px(seen))
    return way > MOVES_PX and jumped < JUMPS_SHARE * way


def learn_again(few: Clip, seen: Followed, found: Sequence[Followed]) -> Body | None:
    """Learn a body from all samples in which it was found, without what others hide of it."""
    others, own = [other for other in found if other is not seen], few.shape(seen)
    shapes = [few.shape(other) for other in others]
    sure = replace(seen, x_px=seen.sure_x_px)
    left, top, right, bottom = seen.body.box
    box = left - BLUR_PX, top - BLUR_PX, right + BLUR_PX, bottom + BLUR_PX
    rough = Rough(few.shape(sure).path_px, box, (-np.inf, np.inf), own, again=True)
    disc = isinstance(seen.body.template, Disc)
    if disc and (ball := _or_ball(few, rough, None, shapes)) is not None:
        return ball
    hide = [shape for shape in shapes if not shape.holds(own)]
    paths = [shape.path_px for shape in shapes if not shape.moves_with(own)][:NEIGHBOURS]
    source = Source(few.pictures, few.background, hide, paths)
    body = learn(source, rough, [shape.path_px for shape in shapes][:NEIGHBOURS])
    alike = body is not None and _of_one_size(body, seen.body)
    stays = disc or alike or not seen.body.round_
    return body if stays else _or_ball(few, rough, body, shapes)


def _alike(one: Rough, other: Rough) -> bool:
    """Whether two proposals are the same."""
    return one.box == other.box and np.array_equal(one.path_px, other.path_px, equal_nan=True)


def _part_of(body: Body, other: Followed, clip: Clip) -> bool:
    """Whether a template, where it was learnt, keeps its distance from a body that was followed."""
    path_px = body.path_px - clip.shift_px
    return same_body(other.xy_px[body.learnt], path_px[body.learnt])


def same_body(one_px: Floats, other_px: Floats) -> bool:
    """Whether two paths, shape (n, 2), keep their distance by x, or by y if they move more by it.

    Across their motion all bodies of an experiment keep it. Two templates place a body that is
    smeared by its motion differently, by a share of its way from one picture to the next.
    """
    seen = np.flatnonzero(np.isfinite(one_px[:, 0]) & np.isfinite(other_px[:, 0]))
    if len(seen) < STEADY_AT_LEAST:
        return False
    axis = int(np.argmax(_way_px(one_px[seen]) + _way_px(other_px[seen])))
    place, other = one_px[seen, axis], other_px[seen, axis]
    smeared = SMEARED_SHARE * np.abs(np.gradient(place, seen))
    varies = np.abs(place - other - np.median(place - other)) - smeared
    return float(np.quantile(varies, 0.9)) < SAME_BODY_PX

"""Learn the template of a body: its median over many pictures, with a weight for each pixel.

Pieces of pictures are laid upon each other where the body's corners were followed to, and
registered to their median; the median of the registered pieces is the template. A pixel belongs to
the body if the median explains the pieces better than what lies behind it does: the background and
the bodies that are known already. What the body is shows in reduced pictures; of those as they are
only its box is read.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import isqrt

import numpy as np

from count_video.records import Floats, Indices
from count_video.tracking.composite import Source
from count_video.tracking.cutting import CLOSE_PX, SIGHTINGS_AT_LEAST, Stage, cut_out
from count_video.tracking.disc import Disc
from count_video.tracking.outline import Outline, widths_of
from count_video.tracking.paths import Rough, choose, only
from count_video.tracking.registration import register_all
from count_video.tracking.sequences import Lumas
from count_video.tracking.shape import Box, share_within, size_of
from count_video.tracking.template import Template, make_template, piece_at

SURROUNDINGS, ENDS_APART = 0.6, 1.5
"""The surroundings that a wide view shows too, on all sides, as a share of the box's longer side,
and at both ends also of its height: the other end of a plain body may be so far away."""
WIDER, WIDEST, BODY_SHARE = 2, 16, 0.5
"""Corners may all lie at one end of a body: views so many times as wide each are tried, up to so
many times in all, until the body ends within one, or they show this share of the picture on all
sides."""
REDUCED_PX = 72
"""What a body is shows in pictures reduced until a square of its area is hardly higher."""
WIDE_PICTURES = 16
"""What a body is shows in so many of them, if its path is exact; a faint one needs them all."""
ROUNDS, ROUNDS_AGAIN, SETTLED_PX = 3, 2, 2
"""So often at most, less if its places are known already, a body is cut out of reduced pictures
until its size changes by no more than so many of their px."""
REGION_HOLDS = 2.0
"""A region of change holds most of the body that makes it: what is cut out is no such body if it is
so many times as wide or high as the region."""
ROUND_HEIGHT = 0.87, 1.15
"""Height of the rows at least half as wide as a ball's outline, over its width."""
AGREEMENT_AT_LEAST = 0.5
"""Correlation below which a piece is not taken for the body."""
INNER_SHARE = 0.5
"""Pieces about a region are compared in this share of the ellipse that fills their box: what lies
around the region is in the box as well, and stands still."""
AGREEMENT_SHARE = 0.9
"""Pieces that agree less than this share of the median are dropped."""
AGREEING_AT_LEAST = 0.5
"""A body looks alike in this share of the pictures that are to show it."""
INSIDE_AT_LEAST = 0.7
"""Share of the template that must lie within a picture to learn from it."""


@dataclass(frozen=True, eq=False)
class Body:
    """A template with its outline."""

    template: Template | Disc
    """Its appearance, or its outline alone where that changes from picture to picture."""
    box: Box
    """The outline's outermost points, from the template's top left pixel."""
    round_: bool
    """Whether the outline is a circle, or as high as one of its width."""
    path_px: Floats
    """Image x and y of the template's top left pixel, roughly where it was not learnt, shape
    (samples, 2); NaN where it is not known."""
    learnt: Indices
    """Samples it was learnt from, in which it was registered."""
    typical_agreement: float
    """Median correlation with the pictures it was learnt from."""


_View = tuple[Stage, Outline, bool]
"""What a view of reduced pictures shows of a body, and whether the body ends within it."""


def learn(source: Source, rough: Rough, others: Sequence[Floats]) -> Body | None:
    """Learn the template of a body that is roughly known.

    ``others`` are paths of other bodies, by which samples are known to be alike, shape (samples, 2)
    each. None where the pieces show no outline, or too few agree with their median.
    """
    chosen = choose(rough.path_px, others)
    wide = _wide(source, rough, chosen)
    if wide is None:
        return None
    found = cut_out(source, wide, (CLOSE_PX + wide.unsure_px,) * 2, rough.fence)
    if found is None:
        return None
    stage = _registered(source.pictures, *found)
    rare = not rough.blurred and stage.agreeing < AGREEING_AT_LEAST
    if rare or len(stage.samples) < SIGHTINGS_AT_LEAST or stage.fills(source):
        return None
    return _body(found[1], rough.path_px, stage)


def _wide(source: Source, rough: Rough, chosen: Indices) -> Stage | None:
    """Learn what a body is, and where it ends, from some samples, reduced."""
    left, top, right, bottom = (round(edge) for edge in rough.box)
    stage = Stage(1, (float(left), float(top)), (bottom - top, right - left), rough.path_px)
    few = chosen[:: -(-len(chosen) // WIDE_PICTURES)] if rough.sure else chosen
    stage = stage.at(rough.path_px, few)
    seen = None
    for number in range(ROUNDS_AGAIN if rough.again else ROUNDS):
        seen = _seen(source, rough, stage) if number else _first_seen(source, rough, stage)
        if seen is None or (rough.blurred and _outgrows(seen[0], rough.box)):
            return None
        after, outline, _ = seen
        small = source.reduced(after.scale).pictures
        if not rough.again:
            after = _registered(small, after, outline)
        before, stage = stage.reduced(after.scale).shape, after.enlarged()
        if max(np.abs(np.subtract(after.shape, before))) <= SETTLED_PX:
            break
    if rough.again or seen is None:
        return stage.at(rough.path_px, chosen)
    whole = stage.at(rough.path_px, chosen).reduced(after.scale)
    return _registered(small, replace(whole, own=after.own), outline).enlarged()


def _first_seen(source: Source, rough: Rough, stage: Stage) -> _View | None:
    """Cut a body out of the first view that it ends within, or else of the widest that shows it."""
    left, top, right, bottom = rough.box
    usual = SURROUNDINGS * max(right - left, bottom - top)
    widest = 0.0 if rough.blurred else BODY_SHARE * max(source.background.luma.shape)
    last, wider = _seen(source, rough, stage, align=rough.blurred), 1
    while wider < WIDEST and wider * usual < widest and not (last and last[2]):
        wider *= WIDER
        last = _seen(source, rough, stage, wider) or last
    return last


def _seen(
    source: Source, rough: Rough, stage: Stage, wider: int = 1, *, align: bool = False
) -> _View | None:
    """Cut a body out of reduced pictures; None if they show none."""
    height, width = stage.shape
    around = wider * SURROUNDINGS * max(height, width)
    ends = 0.0 if rough.blurred or width > height else ENDS_APART * height
    scale = max(1, wider * isqrt(height * width) // REDUCED_PX)
    margin = round(around / scale), round(max(around, ends) / scale)
    small, before = source.reduced(scale), stage.reduced(scale)
    if align:
        before = replace(before, path_px=_aligned(small.pictures, before))
    cut = cut_out(small, before, margin, rough.fence)
    return None if cut is None else (*cut, _ends_within(cut[0], before, margin))


def _ends_within(found: Stage, before: Stage, margin: tuple[int, int]) -> bool:
    """Whether what was cut out ends before a view of so many rows and columns around does."""
    rows = found.corner[1] - before.corner[1], found.shape[0], before.shape[0], margin[0]
    columns = found.corner[0] - before.corner[0], found.shape[1], before.shape[1], margin[1]
    return all(
        -reach < begin and begin + size < usual + reach
        for begin, size, usual, reach in (rows, columns)
    )


def _outgrows(stage: Stage, box: Box) -> bool:
    """Whether what was cut out cannot be the body of a region with this box."""
    height, width = (stage.scale * size for size in stage.shape)
    left, top, right, bottom = box
    return width > REGION_HOLDS * (right - left) or height > REGION_HOLDS * (bottom - top)


def _aligned(pictures: Lumas, stage: Stage) -> Floats:
    """Places that are right to some px, made better by registration to one of the pieces."""
    samples, (height, width) = stage.samples, stage.shape
    weight = np.zeros(stage.shape, dtype=np.float32)
    y, x = np.indices(weight.shape)
    across, along = (height - 1) / 2, (width - 1) / 2
    weight[((y - across) / across) ** 2 + ((x - along) / along) ** 2 < INNER_SHARE] = 1.0
    best = np.empty(0, np.intp)
    path = stage.path_px
    for first in samples[len(samples) // 4 :: max(1, len(samples) // 4)].tolist():
        x, y = stage.path_px[first].tolist()
        template = make_template(piece_at(pictures[first], x, y, (height, width)), weight)
        fits = register_all(pictures, template, stage.path_px)
        good = np.flatnonzero(fits.agreement > AGREEMENT_AT_LEAST)
        if len(good) > len(best):
            best, path = good, fits.places_px
    return only(path, best)


def _body(outline: Outline, path_px: Floats, stage: Stage) -> Body:
    learnt, corner = stage.samples, np.array(stage.corner)
    drift = np.median(stage.path_px[learnt] - (path_px[learnt] + corner), axis=0)
    path = path_px + (corner + drift)
    path[learnt] = stage.path_px[learnt]
    round_ = outline.round_ or _as_high_as_wide(outline)
    return Body(outline.template, outline.box, round_, path, learnt, stage.agreement)


def _as_high_as_wide(outline: Outline) -> bool:
    """Whether the rows at least half as wide as the outline are chords of a circle.

    They are longer than its radius over 0.87 of its diameter; the edge's blur, which the template
    holds as well, adds some px. Threads are narrow and add none. Those of a box are all alike.
    """
    width, _ = size_of(outline.box)
    rows = widths_of(outline.template.weight > 0).astype(np.float64)
    rows = rows[rows >= 0.5 * width]
    if not ROUND_HEIGHT[0] * width < len(rows) < ROUND_HEIGHT[1] * width:
        return False
    diameter = max(rows.max(), len(rows))
    down = np.arange(len(rows)) - (len(rows) - 1) / 2
    chords = np.sqrt(diameter**2 - (2 * down) ** 2)
    return bool(((rows - chords) ** 2).sum() < ((rows - np.median(rows)) ** 2).sum())


def _registered(pictures: Lumas, stage: Stage, outline: Outline) -> Stage:
    """Register a template in the samples; of those that agree, its places and their agreement."""
    fits = register_all(pictures, outline.template, stage.path_px)
    good = (fits.agreement >= AGREEMENT_AT_LEAST) & (fits.inside >= INSIDE_AT_LEAST)
    typical = float(np.median(fits.agreement[good])) if good.any() else 0.0
    agree = np.flatnonzero(good & (fits.agreement > AGREEMENT_SHARE * typical))
    within = share_within(stage.path_px, stage.shape, pictures[0].shape)
    held = np.count_nonzero(within >= INSIDE_AT_LEAST)
    share = len(agree) / max(1, int(held))
    return replace(stage, path_px=only(fits.places_px, agree), agreement=typical, agreeing=share)

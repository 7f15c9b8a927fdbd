r"""Tell what stands still from bodies that rest for most of a clip, by what lies around them.

    grey                                   a body that rests: most pictures show b,
     |      b b b b b b                    a few show a, before it came or after it left
     |      .         .
     | a a a a . . . a a a a a             the surroundings go on with a
     +----------------------------> place

No count of pictures tells a body at rest from the scenery: of two like bodies, one rests until the
other strikes it and that one stays where it struck. But the scenery goes on where a body ends.
Where pixels show other values for a while, the surroundings are filled in, and of the values that
crowds of pictures agree on the nearest to that is the scenery's, if the outline vanishes with it.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

Picture = NDArray[np.float32]

ALTERED_SHARE = 0.12
"""Pictures of which so much more differs than usual show something else, a title or a cut:
nothing in them is a body, nor is it scenery."""
CROWD_SHARE = 0.08
CROWD_AT_LEAST = 3
"""So many pictures agree on a value that a pixel shows for a while, be it the scenery's."""
CLEARLY = 0.5
"""The surroundings speak for another value if it is nearer to them by this factor."""
VANISHES = 1.5
"""The outline of a body that goes from the scenery was steeper before by this factor."""
MARGIN_PX = 3
OUTLINE_PX = 2
"""A body's outline is blurred over less than the first, and its steep part lies within the second
on either side."""
ENDS_PX = 3
"""So many pixels beyond an end tell what lies there."""
ONE_END_LEVELS = 255.0
"""Where only one end is in the picture, the other direction comes first."""


def without_resting(stack: Picture, luma: Picture, threshold: float) -> Picture:
    """Put the scenery in place of bodies that rest for most of the clip.

    Parameters
    ----------
    stack
        Pictures, shape (n, height, width); NaN where a body is known to hide the scenery.
    luma
        The scenery as most pictures show it, shape (height, width).
    threshold
        Grey levels from which on a difference is no noise, for a pixel before which nothing moves.
    """
    settled = _agreed_on(stack, luma, threshold)
    free = _free_at_an_end(stack, settled, threshold)
    return _agreed_on(stack, free, threshold) if (free != settled).any() else settled


def _agreed_on(stack: Picture, luma: Picture, threshold: float) -> Picture:
    """Take the values that crowds of pictures agree on, where the surroundings speak for them."""
    held = max(CROWD_AT_LEAST, round(CROWD_SHARE * len(stack)))
    other = (np.abs(stack - luma) > threshold).sum(axis=0) >= held
    if not other.any():
        return luma
    wide = np.asarray(cv2.dilate(other.astype(np.uint8), _square(MARGIN_PX))) > 0
    around = filled_in(luma, wide)
    settled = luma.copy()
    settled[wide] = _nearest_crowd(stack[:, wide], luma[wide], around[wide], (held, threshold))
    return where_outlines_vanish(luma, settled, threshold)


def _free_at_an_end(stack: Picture, luma: Picture, threshold: float) -> Picture:
    """Take what the first or the last pictures show where a body rests in most others.

    A body that came to rest left its place free at first, one that was driven away does at last. Of
    what lies there now and what was there then, the scenery is what shows no outline. A dark body
    shows in the scenery by darker pixels than there are without it, and in a picture likewise: the
    brighter one of both is without either. With bright bodies it is the darker one.
    """
    changed = (np.abs(stack - luma) > threshold).mean(axis=(1, 2))
    for few in (slice(CROWD_AT_LEAST), slice(-CROWD_AT_LEAST, None)):
        if float(np.median(changed[few])) > float(np.median(changed)) + ALTERED_SHARE:
            continue
        picture = np.sort(stack[few], axis=0)[CROWD_AT_LEAST // 2]
        picture = np.where(np.isfinite(picture), picture, luma)
        for without_bodies in (np.maximum, np.minimum):
            luma = where_outlines_vanish(luma, without_bodies(luma, picture), threshold)
    return luma


def filled_in(luma: Picture, unknown: NDArray[np.bool_], slack: float = 0.0) -> Picture:
    """Fill a picture in where it is not known, region by region, from both ends of each.

    Rails, tables and walls go on in the direction in which both ends agree, across or down. What
    goes on in either direction already, to so many grey levels of ``slack``, stays as it is.
    """
    filled = luma.copy()
    number, _, stats, _ = cv2.connectedComponentsWithStats(unknown.astype(np.uint8))
    for left, top, width, height, _ in np.asarray(stats)[1:number].tolist():
        rows, columns = slice(top, top + height), slice(left, left + width)
        across, strays_across = _between_ends(luma[rows], columns)
        down, strays_down = _between_ends(luma.T[columns], rows)
        if min(strays_across, strays_down) < np.inf:
            now = luma[rows, columns]
            off = np.minimum(np.abs(now - across), np.abs(now - down.T))
            nearer = across if strays_across <= strays_down else down.T
            filled[rows, columns] = np.where(off < slack, now, nearer)
    return filled


def _between_ends(rows: Picture, columns: slice) -> tuple[Picture, float]:
    """Go in each row from what lies left of the columns to what lies right of them.

    Also tells by how many grey levels the ends differ: inf at both borders of the picture.
    """
    left = rows[:, max(0, columns.start - ENDS_PX) : columns.start]
    right = rows[:, columns.stop : columns.stop + ENDS_PX]
    ends = [end.mean(axis=1) for end in (left, right) if end.shape[1]]
    if not ends:
        return rows[:, columns], np.inf
    share = np.linspace(0, 1, columns.stop - columns.start)
    line = ends[0][:, None] * (1 - share) + ends[-1][:, None] * share
    strays = float(np.abs(ends[0] - ends[-1]).mean()) if len(ends) == 2 else ONE_END_LEVELS
    return np.asarray(line, dtype=np.float32), strays


def _nearest_crowd(
    values: Picture, usual: Picture, around: Picture, crowd: tuple[int, float]
) -> Picture:
    """Of the values that crowds agree on, shape (n, pixels), tell the one nearest to ``around``.

    ``crowd`` is how many make one, and how many grey levels they may spread over.
    """
    held, spread = crowd
    values = np.sort(values, axis=0)
    width = values[held - 1 :] - values[: len(values) - held + 1]
    middle = values[: len(values) - held + 1] + width / 2
    far = np.where(width < spread, np.abs(middle - around), np.inf)
    place = np.argmin(far, axis=0)[None]
    nearest = np.take_along_axis(middle, place, axis=0)[0]
    agree = np.abs(values - nearest) < spread
    nearest = np.where(agree, values, 0).sum(axis=0) / np.maximum(agree.sum(axis=0), 1)
    speaks = np.take_along_axis(far, place, axis=0)[0] < CLEARLY * np.abs(usual - around)
    return np.asarray(np.where(speaks, nearest, usual), dtype=np.float32)


def where_outlines_vanish(luma: Picture, settled: Picture, threshold: float) -> Picture:
    """Take over the changes, region by region, whose outline is less steep than it was."""
    changed = (np.abs(settled - luma) > threshold).astype(np.uint8)
    number, found, stats, _ = cv2.connectedComponentsWithStats(changed)
    labels = np.asarray(found)
    before, after = steepness(luma), steepness(settled)
    result = luma.copy()
    for label in range(1, number):
        left, top, width, height = (int(size) for size in stats[label][:4])
        box = (
            slice(max(0, top - MARGIN_PX), top + height + MARGIN_PX),
            slice(max(0, left - MARGIN_PX), left + width + MARGIN_PX),
        )
        region = (labels[box] == label).astype(np.uint8)
        ring = np.asarray(cv2.morphologyEx(region, cv2.MORPH_GRADIENT, _square(OUTLINE_PX))) > 0
        steep, calm = float(before[box][ring].mean()), float(after[box][ring].mean())
        if steep > VANISHES * calm:
            wide = np.asarray(cv2.dilate(region, _square(MARGIN_PX))) > 0
            result[box] = np.where(wide, settled[box], result[box])
    return result


def steepness(picture: Picture) -> Picture:
    """Length of the gradient in grey levels per px."""
    down, across = np.gradient(picture)
    return np.asarray(np.hypot(down, across), dtype=np.float32)


def _square(margin: int) -> NDArray[np.uint8]:
    return np.ones((2 * margin + 1, 2 * margin + 1), np.uint8)

"""A body alone, seen closer: its places by its look, where patches tell them only roughly.

A patch is what stands out from the scenery. Where a bright ball passes before a bright table a part
of it does not, and the centre of the patch strays by several pixels. What the body looks like, as
pictures that show it whole have it, tells its place there too. A body that turns has no one look;
then the patches know better.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from count_video.footage.reader import Footage
from count_video.records import Floats
from count_video.tracking.looks.register import register
from count_video.tracking.looks.sprite import Sprite, look, make_sprite
from count_video.tracking.patches.merging import moved_to
from count_video.tracking.patches.movers import Movers, fresh
from count_video.tracking.patches.paths import Path, cleaned
from count_video.tracking.patches.scenery import Luma, difference, shrunk
from count_video.tracking.view import TrackSettings, cropped

PICTURES = 40
"""So many pictures teach a body's look."""
ROUNDS = 3
"""How often the look is learnt: each time laid upon each other by the one before."""
MARGIN_PX = 3
"""A sprite is larger than the patch by so much on all sides."""
NOISE_FLOOR = 1.0
"""Variance in grey levels squared that every pixel has at least (rounding, compression)."""
LEVELS_SHARE = 0.4
COVERED_SHARE = 0.5
"""Pixels that differ from the scenery by the first share of the body's contrast, in the second
share of the pictures, are the body's."""
ONE_LOOK = 0.9
"""The look of a body that does not turn usually agrees so well at least; noise leaves it more."""
AGREEMENT_SHARE = 0.9
"""A place is believed from this share of the usual agreement on: fast bodies are blurred."""
BELIEVED_AT_LEAST = 0.8
"""In such a share of its pictures a body that does not turn shows its one look."""


@dataclass(frozen=True)
class _Pictures:
    """Pictures of a body and where its patch is in each, all by their rows."""

    luma: Mapping[int, Luma]
    stands_out: Mapping[int, Luma]
    """1 where a pixel differs from the scenery as the body does, else 0."""
    centres: Mapping[int, tuple[float, float]]


def seen_closer(body: Path, movers: Movers, footage: Footage, settings: TrackSettings) -> Path:
    """Place a body by its look in the pictures that show it so, by its patch in the others."""
    pictures = _taught(body, movers, footage, settings)
    sprite = _learn(body, pictures)
    reach = _middle(sprite.shape)
    places = np.full((len(body.rows), 3), np.nan)
    number = {row: place for place, row in enumerate(body.rows)}
    for row, luma in _fresh(movers, footage, settings):
        if row not in number:
            continue
        blob = body.blobs[number[row]]
        fit = register(luma, sprite, (blob.x_px - reach[0], blob.y_px - reach[1]))
        if fit is not None:
            places[number[row]] = fit.x_px + reach[0], fit.y_px + reach[1], fit.agreement
    return _placed(body, places)


def _fresh(movers: Movers, footage: Footage, settings: TrackSettings) -> Iterator[tuple[int, Luma]]:
    for row, frame in enumerate(fresh(footage, settings)):
        yield row, shrunk(cropped(frame, settings.region).luma, movers.scenery.scale)


def _taught(body: Path, movers: Movers, footage: Footage, settings: TrackSettings) -> _Pictures:
    """Keep some pictures that show the body whole, spread over the clip."""
    usual = _whole(body)
    chosen = usual[:: -(-len(usual) // PICTURES)]
    centres = {body.rows[i]: (body.blobs[i].x_px, body.blobs[i].y_px) for i in chosen.tolist()}
    luma = {
        row: picture.copy() for row, picture in _fresh(movers, footage, settings) if row in centres
    }
    levels = LEVELS_SHARE * body.contrast
    stands_out = {
        row: (np.abs(difference(picture, movers.scenery)) > levels).astype(np.uint8)
        for row, picture in luma.items()
    }
    return _Pictures(luma, stands_out, centres)


def _whole(body: Path) -> NDArray[np.intp]:
    """Sightings with the usual area: the half that strays least."""
    areas = np.log([blob.area_px for blob in body.blobs])
    strays = np.abs(areas - np.median(areas))
    return np.flatnonzero(strays <= np.median(strays))


def _learn(body: Path, pictures: _Pictures) -> Sprite:
    """Learn a body's look, its centre in the middle of the sprite."""
    width, height = (
        int(np.median([getattr(blob, side) for blob in body.blobs])) + 2 * MARGIN_PX + 1
        for side in ("width_px", "height_px")
    )
    reach = _middle((height, width))
    corners = {row: (x - reach[0], y - reach[1]) for row, (x, y) in pictures.centres.items()}
    sprite = _mean(pictures, corners, (height, width))
    for _ in range(ROUNDS - 1):
        found = {}
        for row, corner in corners.items():
            fit = register(pictures.luma[row], sprite, corner)
            found[row] = corner if fit is None else (fit.x_px, fit.y_px)
        moved = np.mean([np.subtract(found[row], corners[row]) for row in found], axis=0)
        corners = {row: (x - moved[0], y - moved[1]) for row, (x, y) in found.items()}
        sprite = _mean(pictures, corners, (height, width))
    return sprite


def _mean(
    pictures: _Pictures, corners: Mapping[int, tuple[float, float]], shape: tuple[int, int]
) -> Sprite:
    """Lay pictures upon each other; what lies before the body in few of them has no say."""
    pieces = np.array([look(pictures.luma[row], *corners[row], shape) for row in corners])
    covers = [look(pictures.stands_out[row], *corners[row], shape) for row in corners]
    mean = np.median(pieces, axis=0)
    variance = (1.4826 * np.median(np.abs(pieces - mean), axis=0)) ** 2 + NOISE_FLOOR
    cover = np.mean(covers, axis=0)
    inside = cover >= min(COVERED_SHARE, float(cover.max()))  # a tiny body covers no pixel wholly
    return make_sprite(
        mean.astype(np.float32), np.where(inside, 1 / variance, 0).astype(np.float32)
    )


def _middle(shape: tuple[int, int]) -> tuple[float, float]:
    return (shape[1] - 1) / 2, (shape[0] - 1) / 2


def _placed(body: Path, places: Floats) -> Path:
    """Take over the places that are believed, shape (n, 3) with the agreement, if most are."""
    agreement = np.nan_to_num(places[:, 2])
    usual = float(np.median(agreement))
    good = agreement >= AGREEMENT_SHARE * usual
    if usual < ONE_LOOK or good.mean() < BELIEVED_AT_LEAST:
        return cleaned(body)
    off = places[:, :2] - np.stack([body.x_px, body.y_px], axis=1)
    whole = _whole(body)
    places = places[:, :2] - np.median(off[whole[good[whole]]], axis=0)
    kept = set(cleaned(body).rows)
    rows, blobs = [], []
    for place, (row, blob) in enumerate(zip(body.rows, body.blobs, strict=True)):
        if good[place] or row in kept:
            rows.append(row)
            blobs.append(moved_to(blob, *places[place].tolist()) if good[place] else blob)
    return Path(rows, blobs)

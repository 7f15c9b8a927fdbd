"""Which of the paths in a clip are those of bodies.

Shadows and mirror images move along with a body, their places a fixed linear function of its own,
and stand out less: they are none. Nor are parts of one body, which keep their distance. A body that
was lost for a while leaves its path in pieces.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from count_video.errors import TrackingError
from count_video.records import Floats
from count_video.tracking.patches.paths import Path

SEEN_AT_LEAST = 0.6
"""Share of the pictures between first and last sighting in which a body must be seen."""
STEADY_AT_LEAST = 0.8
"""And this share if it stands out no more than a shadow of the first: soft light comes and goes."""
SIGHTINGS_AT_LEAST = 10
SWEEP_SIZES = 0.4
"""A body's places spread over this many of its own sizes at least, or it does not move."""
RIVAL_SHARE = 0.15
"""What is worth this share of the first body is a body too."""
ALIKE_FACTOR = 1.6
PIECE_SIGHTINGS = 5
"""Bodies of a kind agree in area and contrast to this factor; pieces of a path have so many."""
COMPANY_SHARE = 0.12
"""A shadow's places stray from a linear function of the body's by this share of their spread."""
SHADOW_CONTRAST = 0.75
"""A shadow stands out less than the body by this factor at least."""
SHADOW_ROUNDS = 4
PART_SHARE = 0.1
"""The distance from one part of a body to another strays by less than this share of its way; that
of two bodies next to each other shrinks to nothing when they collide, or grows as they part."""
AREA_SCATTER = 0.4
"""A rigid body's patch keeps its area: the median stray of its logarithm is below this."""


def bodies_among(paths: Sequence[Path]) -> list[Path]:
    """Pick the bodies among what moves, the most worthy first: one, or two.

    Raises
    ------
    TrackingError
        If there are none, or more than two.
    """
    if not paths:
        raise TrackingError("nothing moves in this clip")
    first, *others = _mended(paths)
    reason = _why_no_body(first)
    if reason is not None:
        raise TrackingError(reason)
    bodies = [first]
    for path in others:
        rival = path.worth > RIVAL_SHARE * first.worth or _alike(path, first)
        if (
            rival
            and _why_no_body(path) is None
            and not (_stands_behind(path, first) and _seen_share(path) < STEADY_AT_LEAST)
            and not any(_accompanies(path, body) for body in bodies)
        ):
            bodies.append(path)
    shadows = [path for path in bodies[1:] if _accompanies_in_turn(path, bodies)]
    bodies = [path for path in bodies if not any(path is shadow for shadow in shadows)]
    if len(bodies) > 2:
        raise TrackingError(
            f"{len(bodies)} things move on their own: one body alone or two can be followed; cut "
            "the others away with --region"
        )
    return bodies


def _mended(paths: Sequence[Path]) -> list[Path]:
    """Put the pieces of one path together, that of a body which was lost for a while."""
    first, *others = paths
    left = []
    for path in others:
        apart = path.rows[0] > first.rows[-1] or path.rows[-1] < first.rows[0]
        if apart and _alike(path, first) and len(path.rows) >= PIECE_SIGHTINGS:
            pieces = sorted((first, path), key=lambda piece: piece.rows[0])
            first = Path(
                [row for piece in pieces for row in piece.rows],
                [blob for piece in pieces for blob in piece.blobs],
            )
        else:
            left.append(path)
    return [first, *left]


def _alike(one: Path, other: Path) -> bool:
    """Whether two paths may be those of one body, or of two bodies of a kind."""
    size = abs(np.log(one.area_px / other.area_px)) < np.log(ALIKE_FACTOR)
    return bool(size and abs(np.log(one.contrast / other.contrast)) < np.log(ALIKE_FACTOR))


def _why_no_body(path: Path) -> str | None:
    """Why a path is not that of a rigid body that moves, in words for the user; None if it is."""
    if len(path.rows) < SIGHTINGS_AT_LEAST or _seen_share(path) < SEEN_AT_LEAST:
        return "what moves cannot be followed: it is lost too often"
    if path.sweep_px < SWEEP_SIZES * path.size_px:
        return "nothing moves by more than a part of its own size"
    areas = np.log([blob.area_px for blob in path.blobs])
    if float(np.median(np.abs(areas - np.median(areas)))) > AREA_SCATTER:
        return "what moves changes its shape: it is no rigid body"
    return None


def _seen_share(path: Path) -> float:
    """Share of the pictures between first and last sighting that show a path."""
    return len(path.rows) / (path.rows[-1] - path.rows[0] + 1)


def _accompanies(path: Path, body: Path) -> bool:
    """Whether a path is that of the body's shadow or mirror image, or of another part of it."""
    common = sorted(set(path.rows) & set(body.rows))
    if len(common) < SIGHTINGS_AT_LEAST:
        return False
    one, two = (at_rows(which, common) for which in (body, path))
    if keeps_its_distance(two - one, one, body.size_px + path.size_px):
        return True
    if not _stands_behind(path, body):
        return False
    design = _with_one(one)
    solution, *_ = np.linalg.lstsq(design, two, rcond=None)
    stray = np.sqrt(np.mean(np.sum((two - design @ solution) ** 2, axis=1)))
    return bool(stray < COMPANY_SHARE * np.hypot(*np.std(two, axis=0)) * np.sqrt(12.0))


def _accompanies_in_turn(path: Path, bodies: Sequence[Path]) -> bool:
    """Whether a path is that of the shadows of several bodies that meet and exchange them."""
    alike = [body for body in bodies if body is not path and _stands_behind(path, body)]
    rows = set(path.rows).intersection(*(body.rows for body in alike))
    if len(alike) < 2 or len(rows) < SIGHTINGS_AT_LEAST:
        return False
    common = sorted(rows)
    shadow, places = at_rows(path, common), [at_rows(body, common) for body in alike]
    strays = np.array([np.hypot(*(place - shadow).T) for place in places])
    for _ in range(SHADOW_ROUNDS):
        # One lamp: all bodies have the same linear function; each sighting belongs to one of them.
        nearest = np.argmin(strays, axis=0)
        chosen = np.array(places)[nearest, np.arange(len(common))]
        solution, *_ = np.linalg.lstsq(_with_one(chosen), shadow, rcond=None)
        strays = np.array([np.hypot(*(_with_one(place) @ solution - shadow).T) for place in places])
    stray = np.sqrt(np.mean(strays.min(axis=0) ** 2))
    return bool(stray < COMPANY_SHARE * np.hypot(*np.std(shadow, axis=0)) * np.sqrt(12.0))


def _stands_behind(path: Path, body: Path) -> bool:
    """Whether a path stands out less than a body, as its shadow does."""
    return path.contrast <= SHADOW_CONTRAST * body.contrast


def _with_one(places: Floats) -> Floats:
    return np.column_stack([places, np.ones(len(places))])


def keeps_its_distance(apart_px: Floats, places_px: Floats, reach_px: float) -> bool:
    """Whether what is so far from a body, shape (n, 2), is a part of it; nothing farther is."""
    if np.hypot(*np.median(apart_px, axis=0)) > reach_px:
        return False
    return bool(
        np.hypot(*np.std(apart_px, axis=0)) < PART_SHARE * np.hypot(*np.std(places_px, axis=0))
    )


def at_rows(path: Path, rows: Sequence[int]) -> Floats:
    """Places of a path in some of its pictures, shape (n, 2)."""
    place = dict(zip(path.rows, zip(path.x_px, path.y_px, strict=True), strict=True))
    return np.array([place[row] for row in rows])

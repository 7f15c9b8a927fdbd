"""Is there a circle among these edge points? A ball's outline, found in spite of its markings.

Random triples of points propose circles and the points near each circle vote (Fischler and Bolles
1981). Nothing depends on it but the scale and the ball's centre: bodies need not be round.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from count_video.records import Floats

TRIPLES = 600
PROPOSALS = 300
"""Of the circles through so many triples, those of the widest triangles vote: three neighbours on
an outline that is known to half a pixel say little of the rest of it."""
SEED = 20260101
"""Draws are repeatable: the same footage gives the same answer."""
NEAR_PX = 1.0
"""Points this near to the circle are on it: edges are found to about half a pixel."""
SECTORS = 24
SECTORS_AT_LEAST = 11
"""So many of the circle's 24 sectors must hold points."""
CENTRAL_ROWS = 0.7
OUTERMOST_PX = 1.2
BETTER_SIDE = 0.8
POORER_SIDE = 0.1
"""In the rows within 0.7 radii of the centre the outermost points must lie this near to the circle,
in these shares of the rows on either side. A square's side can be that near to a circle in up to
70 % of them; a ball's far side may fade into what lies behind."""
LARGE_PX, SQUARE_SECTORS, NEARLY_ALL = 24.0, 16, 22
"""No straight side is mistaken for the arc of a circle at least this large: a square is near to it
in no more than so many sectors. If more hold points, one side will do, and if nearly all do, none
need be outermost: a ball that hardly moves keeps parts of what lies behind it."""
POINTS_AT_LEAST = 16
POINTS_AT_MOST = 500
"""More points are thinned out at random: the vote does not need them."""
RADIUS_SHARE = (0.2, 0.7)
"""Radius as a share of the height of the area that is searched."""
VOTES_SHARE = 0.8
REFINED = 12
"""So many of the circles with most votes are refined and vote again: three points of an outline
that are known to half a pixel give it by a pixel or two only."""
REFINEMENTS = 3


@dataclass(frozen=True)
class Circle:
    """A circle in px."""

    x_px: float
    y_px: float
    radius_px: float


def circle_through(
    x: Floats,
    y: NDArray[np.intp],
    shape: tuple[int, ...],
    radius_share: tuple[float, float] = RADIUS_SHARE,
) -> Circle | None:
    """Find the circle that most of its sectors show; None if there is none.

    Parameters
    ----------
    x, y
        Edge points, shape (n,), in px.
    shape
        Height and width of the area they lie in.
    radius_share
        Smallest and largest radius as a share of this height.
    """
    if len(x) < POINTS_AT_LEAST:
        return None
    points = np.stack([x, y], axis=1).astype(np.float64)
    rng = np.random.default_rng(SEED)
    voters = points
    if len(points) > POINTS_AT_MOST:
        voters = points[rng.choice(len(points), POINTS_AT_MOST, replace=False)]
    low, high = (share * shape[0] for share in radius_share)
    circles = _sized(_through_three(_triples(voters, rng)), low, high)[:PROPOSALS]
    best = np.argsort(-_votes(voters, circles), kind="stable")[:REFINED]
    circles = _sized(_refined(points, circles[best]), low, high)
    if len(circles) == 0:
        return None
    votes = _votes(voters, circles)
    good = circles[votes >= VOTES_SHARE * votes.max()]
    # An arc and the ring of a ball make up smaller circles: the largest good one is the outline.
    outline = good[int(np.argmax(good[:, 2]))]
    return Circle(*(float(value) for value in outline)) if _shown(points, outline) else None


def _sized(circles: Floats, low: float, high: float) -> Floats:
    """Keep circles with a radius between two bounds; shape (n, 3)."""
    circles = circles.reshape(-1, 3)
    return circles[(circles[:, 2] > low) & (circles[:, 2] < high)]


def _triples(points: Floats, rng: np.random.Generator) -> Floats:
    """Random triples: of all points, and of the outermost ones in their rows; shape (n, 3, 2).

    Most of the latter lie on the outline, however many marks the ball has within it.
    """
    order = np.lexsort((points[:, 0], points[:, 1]))
    rows = points[order, 1]
    ends = np.flatnonzero(np.diff(rows))
    outer = points[order[np.unique(np.r_[0, ends, ends + 1, len(rows) - 1])]]
    triples = [some[rng.integers(0, len(some), (TRIPLES // 2, 3))] for some in (points, outer)]
    return np.concatenate(triples)


def _through_three(triples: Floats) -> Floats:
    """Circles (x, y, radius) through three points each, shape (n, 3), widest triangles first.

    A triangle is wide if it takes much of its circle's area; those next to nothing are left out.
    """
    a, b, c = triples[:, 0], triples[:, 1], triples[:, 2]
    ab, ac = b - a, c - a
    cross = 2 * (ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0])
    good = np.abs(cross) > 1.0
    a, ab, ac, cross = a[good], ab[good], ac[good], cross[good]
    square_b, square_c = (ab**2).sum(axis=1), (ac**2).sum(axis=1)
    x = (ac[:, 1] * square_b - ab[:, 1] * square_c) / cross
    y = (ab[:, 0] * square_c - ac[:, 0] * square_b) / cross
    circles = np.stack([a[:, 0] + x, a[:, 1] + y, np.hypot(x, y)], axis=1)
    return circles[np.argsort(-np.abs(cross) / circles[:, 2] ** 2, kind="stable")]


def _votes(points: Floats, circles: Floats) -> NDArray[np.intp]:
    """How many sectors of each circle hold points: many points of one arc count once."""
    shown = np.zeros((len(circles), SECTORS), dtype=bool)
    circle, point = np.nonzero(_near(points, circles, NEAR_PX))
    away = points[point] - circles[circle, :2]
    shown[circle, _sector(away[:, 0], away[:, 1])] = True
    return np.asarray(shown.sum(axis=1), dtype=np.intp)


def _near(points: Floats, circles: Floats, reach_px: float) -> NDArray[np.bool_]:
    """Which points lie within a distance of which circles, shape (circles, points).

    A distance d from a centre is within e of a radius r if d^2 - r^2 - e^2 is within 2 r e of 0,
    which takes one product of matrices and no roots.
    """
    x, y, radius = circles.T
    rest = x**2 + y**2 - radius**2 - reach_px**2
    of_circles = np.stack([-2 * x, -2 * y, np.ones(len(x)), rest], axis=1)
    of_points = np.stack([*points.T, (points**2).sum(axis=1), np.ones(len(points))])
    return np.asarray(np.abs(of_circles @ of_points) < 2 * reach_px * radius[:, None])


def _sector(x: Floats, y: Floats) -> NDArray[np.intp]:
    """Return the number of the sector in which a direction lies."""
    turn = np.arctan2(y, x) / (2 * np.pi) + 0.5
    return np.floor(turn * SECTORS).astype(np.intp) % SECTORS


def _refined(points: Floats, circles: Floats) -> Floats:
    """Least squares circles through the points near each (Kasa 1976, linear in its unknowns).

    A circle near which there are few points stays as it is.
    """
    middle = np.append(points.mean(axis=0), 0.0)  # so that the normal equations keep their digits
    points, circles = points - middle[:2], circles - middle
    unknowns = np.column_stack([2 * points, np.ones(len(points))])
    square = (points**2).sum(axis=1)
    products = (unknowns[:, :, None] * unknowns[:, None]).reshape(len(points), -1)
    for _ in range(REFINEMENTS):
        near = _near(points, circles, 2 * NEAR_PX)
        held = near.astype(np.float64)
        powers = (held @ products).reshape(-1, 3, 3)
        right = held @ (unknowns * square[:, None])
        x, y, rest = (np.linalg.pinv(powers, hermitian=True) @ right[:, :, None])[:, :, 0].T
        fitted = np.stack([x, y, np.sqrt(np.maximum(rest + x * x + y * y, 0.0))], axis=1)
        many = near.sum(axis=1) >= POINTS_AT_LEAST
        circles = np.where(many[:, None], fitted, circles)
    return np.asarray(circles + middle)


def _shown(points: Floats, circle: Floats) -> bool:
    """Whether the circle is the outline: all around, and outermost in most rows."""
    sectors = int(_votes(points, circle[None])[0])
    poorer, better = sorted(_outermost_share(points, circle, side) for side in (-1, 1))
    if circle[2] >= LARGE_PX and sectors > SQUARE_SECTORS:
        return better >= BETTER_SIDE or sectors >= NEARLY_ALL
    return sectors >= SECTORS_AT_LEAST and poorer >= POORER_SIDE and better >= BETTER_SIDE


def _outermost_share(points: Floats, circle: Floats, side: int) -> float:
    """Share of the rows about the centre whose outermost point on a side lies on the circle."""
    central = points[np.abs(points[:, 1] - circle[1]) < CENTRAL_ROWS * circle[2]]
    if len(central) == 0:
        return 0.0
    rows, row = np.unique(central[:, 1], return_inverse=True)
    outermost = np.full(len(rows), -np.inf)
    np.maximum.at(outermost, row, side * central[:, 0])
    edge = side * circle[0] + np.sqrt(circle[2] ** 2 - (rows - circle[1]) ** 2)
    return float(np.mean(np.abs(outermost - edge) < OUTERMOST_PX))

"""Is there a circle among these edge points? A ball's outline, found in spite of its markings.

Random triples of points propose circles and the points near each circle vote (Fischler and Bolles
1981). An outline has clear points all around and none a little outside, where the pictures show now
this and now that: a ring within it has, and of a shadow a part is hidden. Nothing depends on it but
the scale and the ball's centre: bodies need not be round.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from count_video.records import Floats, Indices, Mask, Pixels
from count_video.signals import beyond

TRIPLES = 600
PROPOSALS = 300
"""Of the circles through so many triples, those of the widest triangles vote: three neighbours on
an outline that is known to half a pixel say little of the rest of it."""
SEED = 20260101
"""Draws are repeatable: the same footage gives the same answer."""
NEAR_PX, BEYOND_PX = 1.0, 3.0
"""Points this near to a circle are on it, for edges are found to about half a pixel; so far outside
of an outline there are none."""
SECTORS, SECTORS_AT_LEAST = 24, 10.5
"""So many of a circle's sectors show it: of balls 11 or more, also beside their shadow, of other
bodies at most 10, but for wheels and the like (189 outlines of rendered clips, truth known)."""
POINTS_AT_LEAST = 16
POINTS_AT_MOST = 400
"""More points are thinned out: the vote does not need them."""
RADIUS_SHARE = (0.2, 0.7)
"""Radius as a share of the height of a body in which a circle is sought."""
CLEAR_QUANTILE, NOISE_CLEAR = 0.9, 0.1
"""Points count by their clarity up to this quantile of it, of which noise is about this share."""
REFINED, ROUGHLY = 12, 2.0
"""So many of the circles are refined and vote again: three points of an outline that are known to
half a pixel give it so many times less surely."""
REFINEMENTS = 3


@dataclass(frozen=True)
class Circle:
    """A circle in px."""

    x_px: float
    y_px: float
    radius_px: float
    sectors: float
    """So many of its sectors show it, of ``SECTORS``."""

    def away_px(self, shape: tuple[int, ...]) -> Floats:
        """How far pixels of a picture lie outside of it, shape (height, width); inside negative."""
        y, x = np.indices(shape)
        return np.asarray(np.hypot(x - self.x_px, y - self.y_px) - self.radius_px)


@dataclass(frozen=True)
class Edges:
    """Edge points, n of them."""

    places_px: Floats
    """By x and y, shape (n, 2)."""
    clarity: Floats
    """How steep each is, in any unit, shape (n,)."""

    def beside(self, across: Edges) -> Edges:
        """Join edges in rows with those in columns, which were found in the transposed picture."""
        places = np.concatenate([self.places_px, across.places_px[:, ::-1]])
        return Edges(places, np.concatenate([self.clarity, across.clarity]))


def steepest(slope: Pixels) -> tuple[Floats, tuple[Indices, Indices]]:
    """Find where a slope is steepest among its neighbours in the row; 0 is none.

    Between the columns the parabola through the neighbours gives the place. Returns x and y of n
    places, shape (n, 2), and rows and columns of their pixels.
    """
    before = np.pad(slope, ((0, 0), (1, 0)))[:, :-1]
    after = np.pad(slope, ((0, 0), (0, 1)))[:, 1:]
    y, x = np.nonzero((slope > before) & (slope >= after))
    between = beyond(before[y, x], slope[y, x], after[y, x])
    return np.stack([x + between, y], axis=1), (y, x)


def circle_through(
    edges: Edges, height_px: int, radius_share: tuple[float, float] = RADIUS_SHARE
) -> Circle | None:
    """Find the circle that most of its sectors show clearly; None if there is none.

    ``height_px`` is that of the area in which the edges lie, of which the radius is some share.
    """
    if len(edges.clarity) < POINTS_AT_LEAST:
        return None
    points = edges.places_px
    clear = np.minimum(edges.clarity / np.quantile(edges.clarity, CLEAR_QUANTILE), 1.0)
    rng = np.random.default_rng(SEED)
    some = np.arange(len(points))
    if len(points) > POINTS_AT_MOST:
        some = rng.choice(some, POINTS_AT_MOST, replace=False)
    some = some[np.argsort(clear[some], kind="stable")]
    voters, votes = points[some], clear[some]
    low, high = (share * height_px for share in radius_share)
    triples = points[rng.choice(len(points), (TRIPLES, 3), p=clear / clear.sum())]
    circles = _sized(_through_three(triples), low, high)[:PROPOSALS]
    best = np.argsort(-_shown(voters, votes, circles, ROUGHLY), kind="stable")[:REFINED]
    circles = _sized(_refined(points, np.ones(len(points)), circles[best]), low, high)
    if len(circles) == 0:
        return None
    shown = _shown(voters, votes, circles)
    outline = int(np.argmax(shown))
    if shown[outline] < SECTORS_AT_LEAST:
        return None
    x, y, radius = circles[outline].tolist()
    return Circle(x, y, radius, float(shown[outline]))


def placed(circle: Circle, edges: Edges) -> Circle:
    """Place a circle by its clear edges: faint ones are marks and noise beside the outline."""
    rough = np.array([[circle.x_px, circle.y_px, circle.radius_px]])
    x, y, radius = _refined(edges.places_px, edges.clarity, rough, NEAR_PX)[0].tolist()
    return Circle(x, y, radius, circle.sectors)


def _sized(circles: Floats, low: float, high: float) -> Floats:
    """Keep circles with a radius between two bounds; shape (n, 3)."""
    circles = circles.reshape(-1, 3)
    return circles[(circles[:, 2] > low) & (circles[:, 2] < high)]


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


def _shown(points: Floats, clear: Floats, circles: Floats, roughly: float = 1.0) -> Floats:
    """How many sectors show an outline: clearer points on the circle than a little outside of it.

    A sector counts by the contrast of the two. Circles that are known ``roughly`` are so many times
    less sure.
    """
    on, beyond = (
        _clearest(points, clear, circles, _near(points, circles, roughly * NEAR_PX, outside_px))
        for outside_px in (0.0, roughly * BEYOND_PX)
    )
    return np.asarray(((on - beyond) / (on + beyond + NOISE_CLEAR)).sum(axis=1))


def _clearest(points: Floats, clear: Floats, circles: Floats, near: Mask) -> Floats:
    """Clarity of the clearest of the near points of each sector, shape (circles, SECTORS)."""
    found = np.zeros((len(circles), SECTORS))
    circle, point = np.nonzero(near)
    away = points[point] - circles[circle, :2]
    turn = np.arctan2(away[:, 1], away[:, 0]) / (2 * np.pi) + 0.5
    # Points are in order of their clarity, and of those in one sector the last one stays.
    found[circle, np.floor(turn * SECTORS).astype(np.intp) % SECTORS] = clear[point]
    return found


def _near(points: Floats, circles: Floats, reach_px: float, outside_px: float = 0.0) -> Mask:
    """Which points lie on which circles, or so far outside, shape (circles, points).

    A distance d from a centre is within e of a radius r if d^2 - r^2 - e^2 is within 2 r e of 0,
    which takes one product of matrices and no roots.
    """
    x, y, radius = circles.T
    radius = radius + outside_px
    rest = x**2 + y**2 - radius**2 - reach_px**2
    of_circles = np.stack([-2 * x, -2 * y, np.ones(len(x)), rest], axis=1)
    of_points = np.stack([*points.T, (points**2).sum(axis=1), np.ones(len(points))])
    return np.asarray(np.abs(of_circles @ of_points) < 2 * reach_px * radius[:, None])


def _refined(
    points: Floats, weight: Floats, circles: Floats, reach_px: float = ROUGHLY * NEAR_PX
) -> Floats:
    """Least squares circles through the points near each (Kasa 1976, linear in its unknowns).

    A circle near which there are few points stays as it is.
    """
    if len(points) == 0:
        return circles
    middle = np.append(points.mean(axis=0), 0.0)  # so that the normal equations keep their digits
    points, circles = points - middle[:2], circles - middle
    unknowns = np.column_stack([2 * points, np.ones(len(points))])
    square = (points**2).sum(axis=1)
    products = (unknowns[:, :, None] * unknowns[:, None]).reshape(len(points), -1)
    for _ in range(REFINEMENTS):
        near = _near(points, circles, reach_px)
        held = near * weight
        powers = (held @ products).reshape(-1, 3, 3)
        right = held @ (unknowns * square[:, None])
        x, y, rest = (np.linalg.pinv(powers, hermitian=True) @ right[:, :, None])[:, :, 0].T
        fitted = np.stack([x, y, np.sqrt(np.maximum(rest + x * x + y * y, 0.0))], axis=1)
        many = near.sum(axis=1) >= POINTS_AT_LEAST
        circles = np.where(many[:, None], fitted, circles)
    return np.asarray(circles + middle)

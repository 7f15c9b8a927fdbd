"""Where in a picture is this template? Sub-pixel registration by Gauss-Newton.

A piece of the picture is smoothed as the template was, at a fraction of a pixel. The shift then
follows by weighted least squares on the linearised template, together with a gain and an offset for
lamps that flicker (Lucas and Kanade 1981; Baker and Matthews 2004).

Pixels that disagree (something passes in front, a reflection) lose their weight by Tukey's
biweight. The standard uncertainty comes from the residual noise carried through the same linear
equations, with the correlation that the smoothing causes taken into account.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from count_video.records import Floats, Indices, Luma, Mask, Pixels
from count_video.signals import MEDIAN_TO_SIGMA
from count_video.tracking.sequences import Lumas
from count_video.tracking.template import Model, Template, inverse_of, pixels_at

ROUNDS, FRESH_ROUNDS = 8, 2
"""In the first rounds, pixels may disagree because the place is wrong: which of them do is judged
anew. If that does not settle, the weights that were left judge the next round, as in iteratively
reweighted least squares."""
CONVERGED_PX = 0.1
"""A Gauss-Newton step this small ends the iteration: what is left is of the order of its square
times the bend of an edge over its slope, some thousandths of a px."""
CONVERGED_SIGMAS = 0.5
"""So does one that is small beside the uncertainty: along an edge there is no end of steps."""
GUESS_PX = 2.0
"""A guess is right to so much, as a standard deviation."""
STEP_AT_MOST_PX = 2.0
STEEPER = 0.5, 4.0
"""Edges of a picture are from so many to so many times as steep as the template's: one of both may
be smeared by motion."""
ASTRAY_PX = 8.0
"""The linear model leads nowhere from further away than this."""
BIWEIGHT = 5.0
"""Residuals beyond this many robust standard deviations have no say."""
KEPT = 1 - 2 / BIWEIGHT**2 + 3 / BIWEIGHT**4
"""Mean weight that the biweight leaves to pixels with normal noise: it takes from the normal
equations, but hardly from their information."""
SPREAD_STRIDE = 4
"""The robust standard deviation is taken over every fourth pixel: it need not be finer."""
PIXELS_AT_LEAST = 30
AT_ONCE = 16
"""So many pictures are worked on together: that takes less time, and not much memory."""
TINY = 1e-9
"""Is added to the equations, so that what shows no template has a solution: a gain of 0."""
GAIN_AT_LEAST = 0.2
"""A body whose contrast fades below this share of the template's is not there."""


@dataclass(frozen=True)
class Fit:
    """Place of a template in one picture."""

    x_px: float
    y_px: float
    """Image position of the template's top left pixel."""
    sigma_x_px: float
    """Standard uncertainty of ``x_px``."""
    agreement: float
    """Correlation of the picture with the template at its place, -1 to 1, over the pixels that
    were not taken for something in front of the body or behind it."""
    inside: float
    """Share of the template's pixels that lie within the picture."""


@dataclass(frozen=True)
class Fits:
    """Places of a template in n pictures; NaN for a picture that shows none."""

    places_px: Floats
    sigmas_px: Floats
    """By image x and y, with their standard uncertainties, shape (n, 2)."""
    agreement: Floats
    inside: Floats
    """As in a ``Fit``, shape (n,)."""

    def fit(self, number: int) -> Fit | None:
        """Take what one of the pictures shows."""
        parts = *self.places_px.T, self.sigmas_px[:, 0], self.agreement, self.inside
        row = [float(part[number]) for part in parts]
        return None if math.isnan(row[0]) else Fit(*row)


def register_all(pictures: Lumas, template: Template, guesses_px: Floats) -> Fits:
    """Place the template in pictures, starting from guesses that are right to a pixel or two.

    ``guesses_px`` has shape (n, 2), NaN where there is none. No place is found where the equations
    have no solution or the iteration does not settle nearby. Some pictures are worked on together,
    which takes half the time.
    """
    found = np.full((len(guesses_px), 6), np.nan)
    known = np.flatnonzero(np.isfinite(guesses_px[:, 0]))
    for some in (known[k : k + AT_ONCE] for k in range(0, len(known), AT_ONCE)):
        # No name holds these pictures while the next ones are read.
        found[some] = _together([pictures[k] for k in some.tolist()], template, guesses_px[some])
    return Fits(found[:, :2], found[:, 2:4], *found[:, 4:].T)


@dataclass(frozen=True)
class _Search:
    """Pictures in which the place is sought, m of them, by n pixels."""

    row: Indices
    """Which of the pictures, shape (m,)."""
    start: Floats
    place: Floats
    """Where the search began and where it is, by x and y, shape (m, 2)."""
    inside: Floats
    """Share of the pixels that the picture shows, shape (m,)."""
    own: Pixels
    """Weight of each pixel, shape (m, n): 0 where the picture does not show it."""
    judge: Pixels
    inverse: Floats
    """Weights for the residuals that judge the pixels, shape (m, n), and the inverse of the normal
    equations with them, shape (m, 4, 4)."""
    given: Floats
    taken: Floats
    """The last step as the equations gave it, and as it was taken, by x and y, shape (m, 2)."""

    def take(self, step: _Step) -> Floats:
        """Shorten or lengthen a step by the secant method; by x and y, shape (m, 2).

        Where the edges of a picture are r times as steep as the template's, steps are r times too
        long. What was left of the last one after it was taken gives r; one that was too long for
        the linear model gives none.
        """
        squares = np.square(self.taken).sum(axis=1)
        fallen = ((self.given - step.shift_px) * self.taken).sum(axis=1)
        linear = (squares > 0) & (np.abs(self.given) < STEP_AT_MOST_PX).all(axis=1)
        steeper = np.divide(fallen, squares, out=np.ones_like(squares), where=linear)
        taken = step.shift_px / steeper.clip(*STEEPER)[:, None]
        return np.asarray(taken.clip(-STEP_AT_MOST_PX, STEP_AT_MOST_PX))

    def only(self, which: Indices) -> _Search:
        """Take some of the pictures."""
        return _Search(*(getattr(self, one.name)[which] for one in fields(self)))


def _together(pictures: Sequence[Luma], template: Template, guesses_px: Floats) -> Floats:
    """Place the template in some pictures, from a guess for each: what ``Fits`` hold of them."""
    found = np.full((len(pictures), 6), np.nan)
    search = _begun(pictures, template, guesses_px)
    for number in range(ROUNDS):
        if len(search.row) == 0:
            break
        step = _step(template.model, search, _seen(pictures, template, search))
        taken = search.take(step)
        place = search.place + taken
        there = replace(search, place=place, given=step.shift_px, taken=taken)
        near = step.shows & (np.abs(there.place - there.start).max(axis=1) <= ASTRAY_PX)
        parts = there.place, step.sigma_px, step.agreement, there.inside
        # Another step would change little, or less than what the noise leaves open.
        enough = np.maximum(CONVERGED_PX, CONVERGED_SIGMAS * step.sigma_px)
        small = (np.abs(taken) < enough).all(axis=1)
        settled = near & small
        found[search.row[settled]] = np.column_stack(parts)[settled]
        left = np.flatnonzero(near & ~small)
        search = there.only(left)
        # What was found to disagree may not lead the next step astray.
        if number >= FRESH_ROUNDS - 1:
            search = replace(search, judge=step.weight[left], inverse=step.covariance[left])
    return found


def _seen(pictures: Sequence[Luma], template: Template, search: _Search) -> Pixels:
    """Brightness of the pixels where the template may be, less its mean, shape (m, n)."""
    tiles = template.model.tiles
    places = zip(search.row.tolist(), search.place.tolist(), strict=True)
    seen = np.stack([pixels_at(pictures[row], x, y, tiles) for row, (x, y) in places])
    # An offset changes nothing, and sums of squares about the mean keep their digits.
    return np.asarray(seen - seen.mean(axis=1, keepdims=True), np.float32)


def _begun(pictures: Sequence[Luma], template: Template, guesses_px: Floats) -> _Search:
    """Begin the search in those pictures that show enough of the template."""
    model = template.model
    each = zip(pictures, guesses_px.tolist(), strict=True)
    inside = np.array([_inside(picture.shape, template, guess) for picture, guess in each])
    row = np.flatnonzero(np.count_nonzero(inside, axis=1) >= PIXELS_AT_LEAST)
    inside = inside[row]
    # Pixels that a picture does not show are read as well, but have no say.
    own = model.weight * inside
    inverse = np.tile(model.inverse, (len(row), 1, 1))
    for k in np.flatnonzero(~inside.all(axis=1)).tolist():
        inverse[k] = inverse_of(model.design, own[k])
    start = guesses_px[row]
    none = np.zeros_like(start)
    return _Search(row, start, start, inside.mean(axis=1), own, own, inverse, none, none)


def _inside(shape: tuple[int, ...], template: Template, guess: Sequence[float]) -> Mask:
    """Which pixels a picture of this shape shows."""
    chosen = template.model.chosen
    height, width = template.shape
    rows, columns = shape
    left, top = round(guess[0]), round(guess[1])
    whole = left >= 0 and top >= 0 and left + width <= columns and top + height <= rows
    if whole:
        return np.ones(len(chosen), np.bool_)
    y, x = np.divmod(chosen, width)
    x, y = x + left, y + top
    return np.asarray((x >= 1) & (x < columns - 1) & (y >= 1) & (y < rows - 1))


@dataclass(frozen=True)
class _Step:
    """What one step gives in m pictures."""

    shift_px: Floats
    sigma_px: Floats
    """By x and y, shape (m, 2)."""
    agreement: Floats
    """Weighted correlation of the picture with the template, at the place before the step."""
    shows: Mask
    """Whether the template has not faded away, shape (m,)."""
    weight: Pixels
    covariance: Floats
    """Weights that were left, shape (m, n), and the inverse of the equations with them."""


def _step(model: Model, search: _Search, seen: Pixels) -> _Step:
    """One robust least squares step, by what is seen of the pixels, shape (m, n).

    Along a straight edge nothing but where the search began says where a template is: its prior
    keeps it from running away with the noise.
    """
    judged = (search.inverse @ ((search.judge * seen) @ model.design.T)[:, :, None])[:, :, 0]
    left_over = seen - judged.astype(np.float32) @ model.design
    weight, spread = _robust(search.own, left_over)
    weighted = weight * seen
    normal = (weight @ model.products).reshape(-1, 4, 4).astype(np.float64)
    projected = (weighted @ model.design.T).astype(np.float64)
    agreement = _correlation(normal, projected, np.einsum("ij,ij->i", weighted, seen))
    prior = np.square(spread / GUESS_PX)
    normal[:, (0, 1), (0, 1)] += prior[:, None]
    normal[:, (2, 3), (2, 3)] += TINY
    covariance = np.asarray(np.linalg.inv(normal), np.float64)
    projected[:, :2] += prior[:, None] * (search.start - search.place)
    found = (covariance @ projected[:, :, None])[:, :, 0]
    gain = found[:, 2, None]
    shows = gain[:, 0] > GAIN_AT_LEAST
    gain = np.where(shows[:, None], gain, 1.0)
    shift = found[:, :2] / gain
    scale = spread[:, None] * (KEPT * model.correlation) ** 0.5 / gain
    sigma = scale * np.sqrt(np.maximum(covariance[:, (0, 1), (0, 1)], 0.0))
    return _Step(shift, sigma, agreement, shows, weight, covariance)


def _robust(own: Pixels, left_over: Pixels) -> tuple[Pixels, Floats]:
    """Weights with pixels that disagree taken down, and the spread of the others, shape (m,)."""
    scaled = left_over * np.sqrt(own)
    some = np.abs(scaled[:, ::SPREAD_STRIDE])
    # Pixels without a say come last.
    some[own[:, ::SPREAD_STRIDE] == 0] = np.inf
    shown = np.isfinite(some).sum(axis=1)
    ordered = np.sort(some, axis=1)
    middle = ordered[np.arange(len(some)), np.minimum(shown // 2, some.shape[1] - 1)]
    spread = MEDIAN_TO_SIGMA * np.where(shown > 0, middle, 0.0).astype(np.float64) + 1e-6
    ratio = scaled * (1 / (BIWEIGHT * spread[:, None])).astype(np.float32)
    return own * np.square(np.maximum(1 - ratio * ratio, 0)), np.asarray(spread, np.float64)


def _correlation(normal: Floats, projected: Floats, power: Pixels) -> Floats:
    """Weighted correlation of pictures and template, from sums that the equations hold already.

    ``normal`` and ``projected`` are the weighted products of appearance (row 2) and ones (row 3)
    with each other and with the picture, ``power`` that of the picture with itself.
    """
    total = np.maximum(normal[:, 3, 3], TINY)
    shared = projected[:, 2] - normal[:, 2, 3] * projected[:, 3] / total
    expected = normal[:, 2, 2] - normal[:, 2, 3] ** 2 / total
    seen = power - projected[:, 3] ** 2 / total
    good = np.minimum(expected, seen) > 0
    return np.where(good, shared / np.sqrt(np.where(good, expected * seen, 1.0)), 0.0)

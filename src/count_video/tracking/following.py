"""Follow a template through all pictures of a clip.

Between the pictures in which its corners were followed, the place of a body is guessed by linear
interpolation; the registration makes it exact. Where that fails (nothing is known nearby, or the
body turned at a collision faster than the guess allows) the guess of its last velocity is tried,
and then the surroundings are searched, further out the longer the body has been lost.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from count_video.records import Floats, Indices, Mask, Point
from count_video.signals import correlation
from count_video.tracking.background import Background
from count_video.tracking.disc import Disc, differing, register_discs
from count_video.tracking.learning import Body
from count_video.tracking.registration import Fit, Fits, register_all
from count_video.tracking.search import likely_places
from count_video.tracking.sequences import Lumas, chosen
from count_video.tracking.shape import Shape
from count_video.tracking.template import pixels_at

AGREEMENT_SHARE = 0.75
"""A fit is believed from this share of the template's typical correlation on."""
SURE_SHARE, SCENERY_RATIO = 0.9, 0.5
"""With a smaller share of the typical correlation a place is scenery if the background lacks less
than this share of what the template lacks of a full correlation with the picture."""
UNSURE_FACTOR, UNSURE_PX = 8.0, 0.2
"""A sighting with an uncertainty so many times the usual one is hardly one: blur at full speed and
a body half hidden double or treble it."""
INSIDE_AT_LEAST = 0.35
"""Share of the template that must lie within the picture."""
REACH_AT_LEAST_PX = 8.0
REACH_OVER_HEIGHT = 0.25
"""Large bodies are seen from close by, and move by more px."""
REACH_OVER_SPEED = 3.0
"""A search reaches this many times as far as the body ever moved in a frame."""
BACK_FROM = 4
"""From the first picture in which a body is known it is followed on, and, from so many later, back
to the first of the clip."""
ORDERS = 1, 2
"""Powers of the time that extrapolate its last places: constant velocity, then free fall."""
USUAL_RATIO, ONWARD_PX = 4.0, 2.0
"""A place needs no rival if it leaves so many times as much of the picture open as usual at most,
or lies so near to where the body moves on to."""
FRAMES_AT_LEAST, PRESENT_AT_LEAST, SEEN_AT_LEAST = 12, 0.2, 0.5
"""A body comes in and goes out again, but is seen in so many pictures and this share of all, and in
this share of those between its first and its last; else it was not followed."""


@dataclass(frozen=True)
class Followed:
    """Where a template was in each picture; arrays have shape (n,), NaN where not seen."""

    body: Body
    x_px: Floats
    y_px: Floats
    """Image position of the template's top left pixel, freed of the camera's motion."""
    sigma_px: Floats
    """Standard uncertainty of ``x_px``."""

    @property
    def xy_px(self) -> Floats:
        """Shape (n, 2)."""
        return np.stack([self.x_px, self.y_px], axis=1)

    @property
    def sure_x_px(self) -> Floats:
        """``x_px`` of the sightings that are sure, NaN for the others.

        What is like a body, or what is left of it at the picture's edge, matches its template
        loosely. The lower quartile is the usual uncertainty: of a poor template most may do so.
        """
        known = np.isfinite(self.sigma_px)
        usual = np.quantile(self.sigma_px[known], 0.25) if known.any() else np.nan
        sure = self.sigma_px <= max(UNSURE_FACTOR * usual, UNSURE_PX)
        return np.where(sure, self.x_px, np.nan)

    @property
    def middle_px(self) -> Floats:
        """Image x and y of the middle of the outline, shape (n, 2)."""
        return np.asarray(self.xy_px + np.reshape(self.body.box, (2, 2)).mean(axis=0))

    @property
    def edges_px(self) -> tuple[Floats, Floats]:
        """Image x of the left and of the right end of the outline."""
        return self.x_px + self.body.box[0], self.x_px + self.body.box[2]

    def moved(self, away_px: Floats) -> Followed:
        """Move its places by image x and y, shape (n, 2)."""
        x, y = away_px.T
        return replace(self, x_px=self.x_px + x, y_px=self.y_px + y)

    def only(self, rows: Mask) -> Followed:
        """Leave out all sightings but those in some pictures."""
        arrays = self.x_px, self.y_px, self.sigma_px
        return Followed(self.body, *(np.where(rows, one, np.nan) for one in arrays))


@dataclass(frozen=True)
class Clip:
    """What bodies are followed in; pictures lie so that the motion is nearer to their x axis."""

    pictures: Lumas
    """In order of time, n of them."""
    frames: Indices
    """Frame index of each, shape (n,)."""
    samples: Indices
    """Which of them bodies are learnt from, shape (samples,)."""
    background: Background
    shift_px: Floats
    """The camera's motion, shape (n, 2)."""

    def sampled(self) -> Clip:
        """Take the samples alone."""
        frames, shift_px = self.frames[self.samples], self.shift_px[self.samples]
        pictures, every = chosen(self.pictures, self.samples), np.arange(len(frames))
        return Clip(pictures, frames, every, self.background, shift_px)

    def register(self, rows: Indices, body: Body, guesses_px: Floats) -> Fits:
        """Place a body in some pictures, by a guess for each, shape (n, 2)."""
        some, template = chosen(self.pictures, rows), body.template
        if isinstance(template, Disc):
            behind = self.background.luma, self.shift_px[rows]
            return register_discs(some, *behind, template, guesses_px)
        return register_all(some, template, guesses_px)

    def as_learnt(self, body: Body) -> Followed:
        """Take a body to be where it was when it was learnt, without an uncertainty."""
        x, y = (body.path_px - self.shift_px[self.samples]).T
        return Followed(body, x, y, 0.0 * x)

    def shape(self, seen: Followed) -> Shape:
        """Describe what a body hides."""
        template = seen.body.template
        if isinstance(template, Disc):
            return Shape(seen.xy_px + self.shift_px, seen.body.box)
        appearance = template.appearance, template.weight > 0
        return Shape(seen.xy_px + self.shift_px, seen.body.box, appearance)


def follow(clip: Clip, body: Body) -> Followed:
    """Find a body in all pictures."""
    frames, known = clip.frames, np.isfinite(body.path_px[:, 0])
    rows = clip.samples[known]
    seen = body.path_px[known] - clip.shift_px[rows]
    guesses = np.stack([np.interp(frames, frames[rows], along) for along in seen.T], axis=1)
    found = np.full((len(frames), 3), np.nan)
    at_guess = clip.register(np.arange(len(frames)), body, guesses + clip.shift_px)
    first = int(rows[0])
    ways = range(first, len(frames)), range(min(first + BACK_FROM, len(frames)) - 1, -1, -1)
    for way in ways:
        path = _Path(clip, body)
        for row in way:
            x, y, _ = found[row].tolist()
            if math.isfinite(x):
                path.pass_by(row, (x, y))
            elif fit := path.find(row, (guesses[row, 0], guesses[row, 1]), at_guess.fit(row)):
                along, across = clip.shift_px[row].tolist()
                found[row] = fit.x_px - along, fit.y_px - across, fit.sigma_x_px
    return Followed(body, *found.T)


def was_followed(x_px: Floats) -> bool:
    """Whether a body is seen in most pictures while it is in view, by its places, shape (n,)."""
    seen = np.flatnonzero(np.isfinite(x_px))
    if len(seen) < max(FRAMES_AT_LEAST, PRESENT_AT_LEAST * len(x_px)):
        return False
    return len(seen) >= SEEN_AT_LEAST * (int(seen[-1]) - int(seen[0]) + 1)


class _Path:
    """Where a body was last seen, and how it moves; places are those in a picture at rest."""

    def __init__(self, clip: Clip, body: Body) -> None:
        self._clip, self._body, self._typical = clip, body, body.typical_agreement
        self._trail: deque[tuple[int, Point]] = deque(maxlen=max(ORDERS) + 1)
        self._fastest: Point = (0.0, 0.0)
        self.lost = self._unsure = 0
        """Pictures since the last that showed the body, and since the last that did so surely."""

    def find(self, row: int, guess: Point, at_guess: Fit | None) -> Fit | None:
        """Find the body in the next picture; ``at_guess`` is what was registered from the guess."""
        moves_on = bool(self._trail) and not self.lost
        onward = [self.onward(row, guess, order) for order in ORDERS if moves_on]
        best: Fit | None = None
        for number, place in enumerate((guess, *onward)):
            fit = self._believed(self._registered(row, place) if number else at_guess, row)
            if fit is not None and (best is None or fit.agreement > best.agreement):
                best = fit
            if best is not None and self._settles(best, [self._shown(row, one) for one in onward]):
                break
        else:
            best = self._or_searched(best, row, onward[0] if onward else guess)
        self._unsure = 0 if best is not None and self._is_sure(best) else self._unsure + 1
        if best is None:
            self.lost += 1
            return None
        right, down = self._clip.shift_px[row].tolist()
        self.pass_by(row, (best.x_px - right, best.y_px - down))
        return best

    def _or_searched(self, best: Fit | None, row: int, near: Point) -> Fit | None:
        """Take what is found further away if that agrees better: than a sure place, much better.

        The longer no fit has been sure, the rarer are the searches: in the 1st, 2nd, 3rd, 5th, 9th
        picture and so on. The samples guess where the body is when it shows again.
        """
        if self._unsure & (self._unsure - 1):
            return best
        found = self._searched(row, near)
        if found is None or best is None:
            return found or best
        much = USUAL_RATIO if self._is_sure(best) else 1.0
        return found if much * (1 - found.agreement) < 1 - best.agreement else best

    def _shown(self, row: int, place: Point) -> Point:
        """Where a picture shows what is at a place when the camera has not moved."""
        right, down = self._clip.shift_px[row].tolist()
        return place[0] + right, place[1] + down

    def _registered(self, row: int, place: Point) -> Fit | None:
        shown = np.array([self._shown(row, place)])
        return self._clip.register(np.array([row]), self._body, shown).fit(0)

    def _searched(self, row: int, near: Point) -> Fit | None:
        clip, template, picture = self._clip, self._body.template, self._clip.pictures[row]
        if isinstance(template, Disc):
            picture = differing(picture, clip.background.luma, clip.shift_px[row])
        places = likely_places(picture, template, self._shown(row, near), self._reach())
        found = clip.register(np.full(len(places), row), self._body, np.reshape(places, (-1, 2)))
        fits = sorted(
            filter(None, map(found.fit, range(len(places)))), key=lambda fit: -fit.agreement
        )
        if isinstance(template, Disc):
            return next(filter(self._is_sure, fits), None)  # ends of bodies are half circles
        return next((fit for fit in fits if self._believed(fit, row)), None)

    def _reach(self) -> Point:
        """How far to search by x and by y: further, the longer the body has been lost."""
        large = REACH_OVER_HEIGHT * self._body.template.shape[0]
        along, across = (REACH_OVER_SPEED * fastest for fastest in self._fastest)
        away = 1 + self.lost
        return max(REACH_AT_LEAST_PX, large, along) * away, large + across * away

    def onward(self, row: int, guess: Point, order: int = 1) -> Point:
        """Extrapolate the last places by a polynomial; the guess where there are none."""
        known, frame = list(self._trail)[-order - 1 :], int(self._clip.frames[row])
        x = y = 0.0
        for at, place in known:
            share = math.prod((frame - other) / (at - other) for other, _ in known if other != at)
            x, y = x + share * place[0], y + share * place[1]
        return (x, y) if known else guess

    def pass_by(self, row: int, place: Point) -> None:
        """Take note of where the body is in a picture."""
        frame = int(self._clip.frames[row])
        if self._trail:
            last, before = self._trail[-1]
            steps = abs(frame - last)
            along, across = (abs(a - b) / steps for a, b in zip(place, before, strict=True))
            self._fastest = max(self._fastest[0], along), max(self._fastest[1], across)
        if self.lost:
            self._trail.clear()
        self._trail.append((frame, place))
        self.lost = 0

    def _is_sure(self, fit: Fit) -> bool:
        return fit.agreement >= SURE_SHARE * self._typical

    def _settles(self, fit: Fit, onward: Sequence[Point]) -> bool:
        """Whether no other place can agree better, or one that the body moves on to is found."""
        if 1 - fit.agreement <= USUAL_RATIO * (1 - self._typical):
            return True
        away = (max(abs(fit.x_px - x), abs(fit.y_px - y)) for x, y in onward)
        return self._is_sure(fit) and min(away, default=0.0) < ONWARD_PX

    def _believed(self, fit: Fit | None, row: int) -> Fit | None:
        """Take a fit only if it is the body's, and not a place of the scenery that is like it."""
        if fit is None or fit.inside < INSIDE_AT_LEAST:
            return None
        if self._is_sure(fit):
            return fit
        if fit.agreement < AGREEMENT_SHARE * self._typical:
            return None
        template = self._body.template
        if isinstance(template, Disc):
            return fit  # scenery differs from the background nowhere
        model = template.model
        seen = pixels_at(self._clip.pictures[row], fit.x_px, fit.y_px, model.tiles)
        x, y = fit.x_px - self._clip.shift_px[row, 0], fit.y_px - self._clip.shift_px[row, 1]
        behind = pixels_at(self._clip.background.luma, float(x), float(y), model.tiles)
        like = correlation(seen, behind, model.weight)
        return None if 1 - like < SCENERY_RATIO * (1 - fit.agreement) else fit

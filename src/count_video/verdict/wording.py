"""Sentences for the reasons why a clip supports no count, or why a count is in doubt."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

from count_video.motion.reasons import Cause, Reason

ENDS = "the clip ends {}, before the burst can be over; let it run longer"
SENTENCES: Final = {
    Cause.NO_COLLISION: "no collision is seen: no gap between two bodies closes and opens with a "
    "jump",
    Cause.NEVER_TOUCH: "the two bodies that move never touch: where they turn back, a gap stays "
    "between them",
    Cause.STARTS_MOVING: "the clip starts after the first collision: the ball already moves to the "
    "wall; start the clip while the ball is still at rest",
    Cause.STARTS_CLOSE: "the clip starts too close to its first collision to show whether the ball "
    "was at rest; start it some frames earlier",
    Cause.STARTS_LATE: "the clip starts after the first collision: the ball is not at rest before "
    "the first one seen; start the clip earlier",
    Cause.ENDS_AT_CONTACT: ENDS.format("right after a collision"),
    Cause.ENDS_APPROACHING: ENDS.format("while the cylinder still moves to the wall"),
    Cause.ENDS_CATCHING_UP: ENDS.format("while the ball still catches up with the cylinder"),
    Cause.ENDS_RETURNING: ENDS.format("while the ball still moves to the wall"),
    Cause.ENDS_BEFORE_NEXT: ENDS.format(
        "when by the fitted motion one more collision follows, with a probability of {:.0%}"
    ),
    Cause.STRAYS: "the cylinder does not move as its swing and these collisions would have it: "
    "some were missed, or something else was taken for a body",
    Cause.WALL_MISSED: "between frames {:.1f} and {:.1f} a collision of the ball with the wall was "
    "missed",
    Cause.BODY_MISSED: "between frames {:.1f} and {:.1f} a collision of the ball with the cylinder "
    "was missed",
    Cause.UNRESOLVED: "collisions follow each other within {:.1f} pictures, less than the {} that "
    "show each for certain; film at a higher rate",
    Cause.LEFT_OUT: "about {1:.0f} frames are left out after frame {0:.0f}, in which collisions "
    "may have happened",
    Cause.NO_IMPACT: "no impact is seen: what could be followed turns round smoothly, if at all, "
    "and jumps nowhere",
    Cause.TOO_FAINT: "the few turns that are seen are too faint or too short to be called impacts",
    Cause.NO_FLIGHTS: "the body's path between its turns is not that of one that bounces: impacts "
    "and smooth turns cannot be distinguished",
    Cause.NOT_FREE: "the body does not fly freely in frames {spans}",
    Cause.BEFORE_UNSEEN: "what came before the first impact is not seen: one may be missing",
    Cause.TURNS_OPEN: "whether the turns at the stop in frames {turns} are impacts is not clear",
    Cause.CUT_AT_STOP: "the clip is cut off where the body is at its stop: one may be missing",
    Cause.TOO_FREQUENT: "the last impacts follow each other faster than the pictures show: some "
    "may be missed",
    Cause.DIES_OUT: "the last bounces are lower than the pictures show: they are not counted",
    Cause.WALL_AHEAD: "the clip ends while a body moves towards something that stands in its way: "
    "if that is a wall, let the clip run until the last collision",
    Cause.SEVERAL_BOUNCE: "{:.0f} bodies each bounce by themselves, and which of them is meant is "
    "not known; give its part of the picture with --region",
    Cause.OTHERS_MOVE: "few impacts of one body are seen ({:.0f}) where more move by themselves "
    "({:.0f}): it may be the ball of a trial whose heavy body could not be followed",
    Cause.UNLIKE: "the two bodies are not of a kind, and neither reaches a wall: let the clip run "
    "until the burst is over",
    Cause.MEETS_OTHERS: "one of the two bodies also bounces off something else: show the trial "
    "from the ball at rest until the heavy body is driven back, or bodies that meet nothing but "
    "each other",
    Cause.ENDS_TOGETHER: "the clip ends before the bodies have parted; let it run longer",
    Cause.STARTS_TOGETHER: "the clip starts when the bodies are next to each other; start it "
    "earlier",
    Cause.PARTS_OF_BODIES: "what was followed as ball and heavy body may be parts of them: their "
    "outlines do not meet where they collide, and their motion shows no momentum to be kept; light "
    "the bodies better, or give their part of the picture with --region",
    Cause.MODEL_LACKS_FRAMES: "too few frames surround the collisions to fit a model of the motion "
    "to them",
    Cause.MODEL_FITS_NOTHING: "no motion of two bodies and a wall resembles the track",
    Cause.MODEL_DIFFERS: "the fitted collisions are not those that were seen",
    Cause.MODEL_STRAYS: "the modelled motion strays from the track by {:.1f} px where {:.1f} are "
    "allowed: something else than two swinging bodies and a wall took part",
}


def sentence(reason: Reason) -> str:
    """Put a reason into words for the user."""
    figures = reason.figures
    return SENTENCES[reason.cause].format(
        *figures,
        turns=", ".join(f"{figure:.0f}" for figure in figures),
        spans=", ".join(
            f"{first:.0f} to {last:.0f}"
            for first, last in zip(figures[:-1:2], figures[1::2], strict=True)
        ),
    )


def sentences(reasons: Iterable[Reason]) -> str | None:
    """Put reasons into words, one after the other; None if there are none."""
    return "; ".join(map(sentence, reasons)) or None

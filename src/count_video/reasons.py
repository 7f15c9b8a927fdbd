"""Why a clip supports no count, or why a count is in doubt: causes with their figures.

What is decided by them is decided by the cause; ``reports.words`` makes the sentences.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, auto


class Cause(Enum):
    """What stands against a count; ``Reason.figures`` are listed in brackets, frames first."""

    NO_COLLISION = auto()
    NEVER_TOUCH = auto()  # the outlines stay apart where the ball turns back
    STARTS_MOVING = auto()  # the ball moves to the wall when the clip starts
    STARTS_CLOSE = auto()  # too few frames before the first collision show the ball at rest
    STARTS_LATE = auto()  # the ball is not at rest before the first collision that is seen
    ENDS_WITHIN = auto()  # after the last collision the bodies do not part and leave the wall
    ENDS_BEFORE_NEXT = auto()  # by the fitted motion one more follows after the end [probability]
    STRAYS = auto()  # the heavy body's path does not follow from its swing and the collisions
    WALL_MISSED = auto()  # between two frames [two] the ball must have met the wall ...
    BODY_MISSED = auto()  # ... or the heavy body [two]
    WALL_NOT_REACHED = auto()  # ... or it turned round by itself before the wall [two]
    UNRESOLVED = auto()  # they follow each other too fast [shortest interval, what shows each]
    FRAMES_MISSING = auto()  # frames that the file promises are missing [how many]
    NO_IMPACT = auto()
    SWAYS = auto()  # what turns moves by little of its size
    TOO_FAINT = auto()
    BEFORE_UNSEEN = auto()
    FIRST_UNSEEN = auto()  # no picture shows the first impact [its frame]
    LAST_UNSEEN = auto()  # no picture shows the last impact [its frame]
    TURNS_OPEN = auto()  # turns at a stop may be impacts [all frames]
    NOT_TURNED = auto()  # by all flights together a body does not turn at impacts [all frames]
    CUT_AT_STOP = auto()
    TOO_FREQUENT = auto()  # or the body came back to its stop while no picture showed it
    DIES_OUT = auto()  # the body bounces lower and lower, at last below what the pictures show
    WALL_BEHIND = auto()
    WALL_AHEAD = auto()
    SEVERAL_BOUNCE = auto()  # bodies that each bounce by themselves [how many]
    OTHERS_MOVE = auto()  # beside the body that has impacts [how many impacts, others]
    UNLIKE = auto()  # two bodies are not of a kind, and neither reaches a wall
    MEETS_OTHERS = auto()
    LOST = auto()  # a body is not seen to the clip's end, and does not leave the picture [frame]
    STRUCK = auto()  # something that is not followed strikes the body at rest [frame]
    STRUCK_MOVING = auto()  # an impact gives the body speed: what it struck moves [frame]
    HEAVY_UNSEEN = auto()  # the heavy body is known by what it does to the ball alone
    MOVES_BESIDE = auto()  # something not followed moves beside the body where it turns [frame]
    PARTNER_UNSEEN = auto()  # it may have struck something that was not followed [probability]
    ENDS_TOGETHER = auto()
    STARTS_TOGETHER = auto()
    PARTS_OF_BODIES = auto()  # neither touching, nor momentum kept, nor the law obeyed
    OTHERS_LIKELY = auto()  # others are together likelier [count of impacts seen, its probability]
    MODEL_LACKS_FRAMES = auto()
    MODEL_FITS_NOTHING = auto()
    MODEL_DIFFERS = auto()  # the collisions of the fitted model are not those that are seen
    MODEL_STRAYS = auto()  # the fitted model strays from the track [rms in px, what is allowed]
    MODEL_LEAVES_OPEN = auto()  # none is likelier than all others [each count and its probability]
    TOO_MANY = auto()  # more collisions than the fit seeks [how many it does]
    LIGHTER = auto()  # the body that swings in is much lighter than the other
    MASSES_WOULD_HELP = auto()  # the masses are not known, and would narrow the count down

    # What is unusual about a clip and stands against no count.
    GAP_MADE_UP_FOR = auto()  # frames are left out that the times allow for [frame, how many]
    OTHER_SHOTS = auto()  # the clip is cut, and one shot is counted [its first and last frame]
    STANDS_STILL = auto()  # the bodies stand still at either end [frames in which they move]
    RATE_CHANGES = auto()  # the rate of the footage changes [by which factor, at which frames]
    UNEVEN_STAMPS = auto()  # frames were taken at uneven times, which their time stamps say
    OUTLINES_LEAVE_OPEN = auto()  # collisions are inferred though the outlines do not meet
    OUTLINES_APART = auto()  # ball and cylinder touch with a gap between their outlines [in px]
    ENERGY_GAINED = auto()  # by the fitted motion [the most energy after a collision, of the first]
    MASSES_UNUSED = auto()  # masses are given, and there is no trial at a wall
    MASSES_CONTRADICT = auto()  # the motion shows another ratio [given, shown, its uncertainty]


LEFT_TO_THE_FIT = frozenset((Cause.STARTS_CLOSE, Cause.ENDS_WITHIN, Cause.STRAYS))
"""A fitted model of the motion makes up for these: it knows what came before, and what follows."""


UNEVEN_TIMES = frozenset((Cause.RATE_CHANGES, Cause.UNEVEN_STAMPS))
"""By these no one rate is that of all frames."""


@dataclass(frozen=True)
class Reason:
    """A cause and its figures."""

    cause: Cause
    figures: tuple[float, ...] = ()

"""Why a clip supports no count, or why a count is in doubt: causes with their figures.

What is decided by them is decided by the cause; ``reports.words`` makes the sentences.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, auto


class Cause(Enum):
    """What stands against a count; ``Reason.figures`` are listed in brackets, frames first."""

    NO_COLLISION = auto()
    NEVER_TOUCH = auto()
    """The outlines stay apart where the ball turns back."""
    STARTS_MOVING = auto()
    """The ball moves to the wall when the clip starts."""
    STARTS_CLOSE = auto()
    """Too few frames before the first collision show whether the ball was at rest."""
    STARTS_LATE = auto()
    """The ball is not at rest before the first collision that is seen."""
    ENDS_AT_CONTACT = auto()
    ENDS_APPROACHING = auto()
    """The heavy body still moves to the wall at the end."""
    ENDS_CATCHING_UP = auto()
    """The ball catches up with the heavy body at the end."""
    ENDS_RETURNING = auto()
    """The ball moves to the wall at the end."""
    ENDS_BEFORE_NEXT = auto()
    """By the fitted motion one more collision follows after the clip's end [probability]."""
    STRAYS = auto()
    """The heavy body's path does not follow from its swing and the collisions."""
    WALL_MISSED = auto()
    """Between two frames [two] the ball must have met the wall, ..."""
    BODY_MISSED = auto()
    """... or the heavy body [two]."""
    UNRESOLVED = auto()
    """Collisions follow each other too fast [the shortest interval, that which shows each]."""
    LEFT_OUT = auto()
    """Frames are missing without a trace in the time stamps [frame, how many]."""
    FRAMES_MISSING = auto()
    """Frames that the file promises are missing [how many]."""
    NO_IMPACT = auto()
    TOO_FAINT = auto()
    NO_FLIGHTS = auto()
    """The path between the turns is not that of a body that bounces."""
    NOT_FREE = auto()
    """The body does not fly freely in some frames [first and last of each span]."""
    BEFORE_UNSEEN = auto()
    TURNS_OPEN = auto()
    """Turns at a stop may be impacts [all frames]."""
    CUT_AT_STOP = auto()
    TOO_FREQUENT = auto()
    DIES_OUT = auto()
    """The body bounces lower and lower, at last below what the pictures show."""
    WALL_AHEAD = auto()
    SEVERAL_BOUNCE = auto()
    """Bodies that each bounce by themselves [how many]."""
    OTHERS_MOVE = auto()
    """Few impacts of one body, while others move by themselves [how many impacts, others]."""
    UNLIKE = auto()
    """Two bodies are not of a kind, and neither reaches a wall."""
    MEETS_OTHERS = auto()
    STRUCK = auto()
    """Something that is not followed strikes the body at rest [frame]."""
    MOVES_BESIDE = auto()
    """Something that is not followed moves beside the body where it turns [frame]."""
    PARTNER_UNSEEN = auto()
    """The body may have struck something that could not be followed [probability]."""
    ENDS_TOGETHER = auto()
    STARTS_TOGETHER = auto()
    PARTS_OF_BODIES = auto()
    """The bodies neither touch, nor show momentum to be kept, nor obey the law."""
    OTHERS_LIKELY = auto()
    """Other counts are together more probable [the count of the impacts seen, its probability]."""
    MODEL_LACKS_FRAMES = auto()
    MODEL_FITS_NOTHING = auto()
    MODEL_DIFFERS = auto()
    """The collisions of the fitted model are not those that are seen."""
    MODEL_STRAYS = auto()
    """The fitted model strays from the track [root mean square in px, what is allowed]."""
    MODEL_HAS_FEWER = auto()
    """The best fit has fewer collisions than are seen [how many, how many are seen]."""
    MODEL_LEAVES_OPEN = auto()
    """No count is likelier than all others [each count, followed by its probability]."""
    MASSES_WOULD_HELP = auto()
    """The masses are not known, and would narrow the count down."""

    # What is unusual about a clip and stands against no count.
    GAP_MADE_UP_FOR = auto()
    """Frames are left out that the times allow for [frame, how many]."""
    RATE_CHANGES = auto()
    """The rate of the footage changes [by which factor, at which frames]."""
    OUTLINES_APART = auto()
    """The outlines of ball and cylinder do not meet where they touch [gap between them in px]."""
    MASSES_CONTRADICT = auto()
    """The motion shows another mass ratio than was given [given, shown, its uncertainty]."""


LEFT_TO_THE_FIT = frozenset(
    (
        Cause.STARTS_CLOSE,
        Cause.ENDS_AT_CONTACT,
        Cause.ENDS_APPROACHING,
        Cause.ENDS_CATCHING_UP,
        Cause.ENDS_RETURNING,
        Cause.STRAYS,
    )
)
"""A fitted model of the motion makes up for these: it knows what came before, and what follows."""


@dataclass(frozen=True)
class Reason:
    """A cause and its figures."""

    cause: Cause
    figures: tuple[float, ...] = ()

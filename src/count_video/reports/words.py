"""What all reports write with: safe text, numbers with nouns, sentences, labels beside them."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Final

from count_video.reasons import Cause, Reason

if TYPE_CHECKING:  # NumPy takes time, and the command needs this module at once
    from count_video.records import Estimate

WIDTH = 80
"""Columns that a terminal has at the least."""
RARE = 0.005
"""Less probable counts, and counts that fewer trials have, are not listed."""
KINDS: Final = {"bodies": "between the bodies", "wall": "with the wall"}
Note = tuple[str, str]
"""A label and the sentence that stands beside it."""


def printable(text: str) -> str:
    """Escape what a terminal would obey instead of show: line ends, control codes, lost bytes."""
    return "".join(
        sign if sign.isprintable() else sign.encode("unicode_escape").decode("ascii")
        for sign in text
    )


def storable(text: str) -> str:
    """Replace what UTF-8 cannot hold: the unpaired surrogates of a file name that is not UTF-8."""
    return text.encode("utf-8", "backslashreplace").decode("utf-8")


def plural(number: int, noun: str) -> str:
    """Join a number and its noun: ``no collision``, ``1 collision``, ``31 collisions``."""
    return f"{number or 'no'} {noun}{'s' if number > 1 else ''}"


def counts_words(low: int, high: int) -> str:
    """Write a range of counts: ``31``, ``3 or 4``, ``29 to 31``."""
    return str(low) if low == high else f"{low}{' or ' if high == low + 1 else ' to '}{high}"


def shortened(value: float, digits: int = 4) -> str:
    """Write a number with so many digits, or all before its point, and never an exponent."""
    return f"{value:.0f}" if abs(value) >= 10**digits else f"{value:.{digits}g}"


def ratio_words(ratio: Estimate | None, between: str = "±") -> str:
    """Write a mass ratio, the sign ``between``, and its uncertainty, 0 where the ratio was given.

    There are two digits of the uncertainty, and none of the ratio beyond them.
    """
    return "not known" if ratio is None else _with_sigma(ratio.value, ratio.sigma, between)


def _with_sigma(value: float, sigma: float, between: str) -> str:
    if not sigma or not math.isfinite(sigma):
        return shortened(value)
    digits = max(0, 1 - math.floor(math.log10(sigma)))
    return f"{value:.{digits}f} {between} {sigma:.{digits}f}"


def percent(chance: float) -> str:
    """Write a chance, with a decimal near 0 and near 1, and never as certain."""
    return f"{chance:.0%}" if 0.01 <= chance < 0.99 else f"{min(chance, 0.999):.1%}"


def share_words(share: float) -> str:
    """Write a share of trials, all of them as ``100%``."""
    return "100%" if share == 1 else percent(share)


def chances_words(probability: Mapping[int, float], most: int | None = None) -> str:
    """List the likely counts with their chances, the likeliest first, and ``most`` at the most."""
    ordered = sorted(probability.items(), key=lambda item: -item[1])[:most]
    return ", ".join(f"{count}: {percent(p)}" for count, p in ordered if p >= RARE)


def labelled(label: str, sentence: str, width: int = WIDTH) -> list[str]:
    """Write a label and, beside it, a sentence in lines of at most ``width`` columns."""
    return textwrap.wrap(
        printable(sentence),
        width,
        initial_indent=f"  {label:<13}",
        subsequent_indent=" " * 15,
        break_on_hyphens=False,  # an option's name stays whole
    )


def answer_text(
    headline: str, notes: Iterable[Note], *tables: list[str], width: int = WIDTH
) -> str:
    """Write headline, notes, and those tables that are not empty; no line's end at its end."""
    lines = [headline, ""]
    for label, sentence in notes:
        lines += labelled(label, sentence, width)
    for table in filter(None, tables):
        lines += ["", *table]
    return "\n".join(lines)


# ---- what stands against a count, leaves it in doubt, or is unusual about a clip ---------------

CLEARER: Final = (
    "film from nearer, with more light and before a plain background, or show the bodies' part of "
    "the picture alone with --region X,Y,W,H"
)
"""What to do where the bodies could not be followed."""
SAID: Final[Mapping[str, Mapping[Cause, str]]] = {
    "copy the file again from the camera, whole": {
        Cause.FRAMES_MISSING: "{missing} missing, in which collisions may have happened",
    },
    "move the wall nearer to the ball, or pull the cylinder further back": {
        Cause.WALL_NOT_REACHED: "between frames {:.1f} and {:.1f} the ball turned round by itself: "
        "it did not reach the wall",
    },
    "start the clip well before the first collision, with the ball at rest": {
        Cause.STARTS_MOVING: "the clip starts after the first collision: the ball already moves to "
        "the wall",
        Cause.STARTS_CLOSE: "the clip starts too close to its first collision to show whether the "
        "ball was at rest",
        Cause.STARTS_LATE: "the clip starts after the first collision: the ball is not at rest "
        "before the first one seen",
        Cause.BEFORE_UNSEEN: "what came before the first impact is not seen: one may be missing",
        Cause.FIRST_UNSEEN: "no picture shows the first impact; that there was one, about frame "
        "{:.0f}, follows from the flight after it",
        Cause.WALL_BEHIND: "the clip begins while a body comes from something that stands still, "
        "which it may have struck",
        Cause.STARTS_TOGETHER: "the clip starts when the bodies are next to each other",
    },
    "let the clip run until the bodies have parted for good": {
        Cause.ENDS_WITHIN: "the clip ends before the burst can be over: after the last collision "
        "seen ball and cylinder do not part and leave the wall",
        Cause.ENDS_BEFORE_NEXT: "the clip ends before the burst can be over: by the fitted motion "
        "more collisions follow, with a probability of {chance}",
        Cause.LAST_UNSEEN: "no picture shows the last impact; that there was one, about frame "
        "{:.0f}, follows from the flights before it",
        Cause.CUT_AT_STOP: "the clip is cut off where the body is at its stop: one may be missing",
        Cause.WALL_AHEAD: "the clip ends while a body moves towards something that stands in its "
        "way, which may be a wall",
        Cause.UNLIKE: "the two bodies are not of a kind, and neither reaches a wall",
        Cause.ENDS_TOGETHER: "the clip ends before the bodies have parted",
    },
    "film at a higher rate: --plan gives the one that shows every collision": {
        Cause.WALL_MISSED: "between frames {:.1f} and {:.1f} a collision of the ball with the wall "
        "was missed",
        Cause.BODY_MISSED: "between frames {:.1f} and {:.1f} a collision of the ball with the "
        "cylinder was missed",
        Cause.UNRESOLVED: "collisions follow each other within {:.2g} pictures, less than the {} "
        "that show each for certain",
        Cause.TOO_FREQUENT: "impacts follow each other faster than the pictures show, or the body "
        "came back to its stop while no picture shows it: some may be missed",
        Cause.MODEL_LACKS_FRAMES: "too few frames surround the collisions to fit a model of the "
        "motion to them",
        Cause.MODEL_LEAVES_OPEN: "{open_counts}",
    },
    "use a smaller mass ratio: no clip shows so many collisions": {
        Cause.TOO_MANY: "there are some {:.0f} collisions or more: a track does not show how many",
    },
    "give the masses with --masses": {
        Cause.MASSES_WOULD_HELP: "the masses would narrow it down",
    },
    "show nothing but the trial: cut the rest away with --start, --end and --region X,Y,W,H, or "
    "name the side of the wall with --wall": {
        Cause.NEVER_TOUCH: "the two bodies that move never touch: where they turn back, a gap "
        "stays between them",
        Cause.STRAYS: "the cylinder does not move as its swing and these collisions would have it: "
        "some were missed, or something else was taken for a body",
        Cause.SWAYS: "what turns round moves by little of its size, as a person does who walks: it "
        "strikes nothing",
        Cause.SEVERAL_BOUNCE: "{:.0f} bodies each bounce by themselves, and which of them is meant "
        "is not known",
        Cause.OTHERS_MOVE: "one body has impacts ({:.0f}) where more move by themselves ({:.0f}): "
        "it may be the ball of a trial whose cylinder could not be followed",
        Cause.MEETS_OTHERS: "one of the two bodies also bounces off something else",
        Cause.MODEL_FITS_NOTHING: "no motion of two bodies and a wall resembles the track",
        Cause.MODEL_DIFFERS: "the fitted collisions are not those that were seen",
        Cause.MODEL_STRAYS: "the modelled motion strays from the track by {:.2f} px where {:.2f} "
        "are allowed: something else took part than the bodies that were followed",
        Cause.LIGHTER: "by the motion the cylinder is much lighter than the ball, and not fitted",
    },
    CLEARER: {
        Cause.NO_COLLISION: "no collision is seen: no gap between two bodies closes and opens with "
        "a jump",
        Cause.NO_IMPACT: "no impact is seen: what could be followed turns round smoothly, if at "
        "all, and jumps nowhere; if it is the cylinder of a trial, its ball could not be followed",
        Cause.TOO_FAINT: "the few turns that are seen are too faint or too short to be called "
        "impacts",
        Cause.STRUCK: "something that could not be followed strikes the body at rest in frame "
        "{:.0f}: it may be the ball of a trial whose cylinder was not found",
        Cause.STRUCK_MOVING: "the body leaves the impact in frame {:.0f} faster than it came: what "
        "it struck moves; it may be the ball of a trial whose cylinder was not found",
        Cause.HEAVY_UNSEEN: "the cylinder could not be followed: it is known only by what it does "
        "to the ball",
        Cause.MOVES_BESIDE: "something that could not be followed moves where the body turns in "
        "frame {:.0f}: the body may be one of a trial whose other body was not found",
        Cause.PARTNER_UNSEEN: "one body alone turns round: with a probability of {:.0%} it "
        "is the cylinder of a trial whose ball was not found",
        Cause.LOST: "one of the bodies could not be followed beyond frame {:.0f}, though it does "
        "not leave the picture there: more collisions may have happened",
        Cause.PARTS_OF_BODIES: "what was followed as ball and cylinder may be parts of them: their "
        "outlines do not meet where they collide, and their motion shows no momentum to be kept",
        Cause.OUTLINES_LEAVE_OPEN: "one of the bodies is not outlined rightly, which makes "
        "collisions between the frames less sure",
    },
    "compare the clip with the collisions listed": {
        Cause.TURNS_OPEN: "whether {turns} at the stop may be called impacts is not clear",
        Cause.NOT_TURNED: "by all flights together the body does not surely turn round in "
        "{frames}: other impacts may be missed there",
        Cause.DIES_OUT: "the last bounces are lower than the pictures show: they are not counted",
        Cause.OTHERS_LIKELY: "that the impacts seen ({:.0f}) are all of them is {:.0%} probable",
    },
    "": {
        Cause.GAP_MADE_UP_FOR: "frames are left out after frame {0:.0f} (about {1:.0f})",
        Cause.OTHER_SHOTS: "the clip is cut: of its shots only the longest is counted, frames "
        "{:.0f} to {:.0f}; choose another with --start and --end",
        Cause.STANDS_STILL: "the bodies stand still but for frames {:.0f} to {:.0f}, which alone "
        "are counted",
        Cause.RATE_CHANGES: "the rate of the footage changes at {changes}, by a factor of {0:.0f}: "
        "no rate gives times, and velocities are those of the frames next to each collision",
        Cause.UNEVEN_STAMPS: "the frames were taken at uneven times, those of their time stamps: "
        "velocities are those of the frames next to each collision",
        Cause.OUTLINES_APART: "the outlines of ball and cylinder {apart} px where they touch: the "
        "ball's width is not sure enough for a scale in millimetres",
        Cause.ENERGY_GAINED: "by the fitted motion the bodies gain energy (up to {:.0%} of the "
        "first state's): the rate of the frames may change within the clip, and then velocities, "
        "restitution and mass ratio are wrong",
        Cause.MASSES_UNUSED: "--masses is not used: no ball and cylinder at a wall were found",
        Cause.MASSES_CONTRADICT: "the masses given have the ratio {given}, the motion shows "
        "{measured}: check --masses, the cylinder's first",
    },
}
"""Sentences for causes, by what a person can do about them, in the order in which that is said;
nothing is to be done about the last."""
_SENTENCES = {cause: text for about in SAID.values() for cause, text in about.items()}


def what_to_do(reasons: Iterable[Reason]) -> str | None:
    """Say what a person can do about reasons, each thing once; None if there are none."""
    causes = {reason.cause for reason in reasons}
    return "; ".join(what for what, about in SAID.items() if what and causes & about.keys()) or None


def sentence(reason: Reason) -> str:
    """Put a reason into words for the user."""
    figures = reason.figures
    first = figures[0] if figures else 0.0
    frames = _frames(figures, ", ")
    return _SENTENCES[reason.cause].format(
        *figures,
        chance=percent(first),
        frames=frames,
        turns=f"the turn{'s'[len(figures) == 1 :]} in {frames}",
        missing=f"{plural(round(first), 'frame')} {'is' if round(first) == 1 else 'are'}",
        changes=_frames(figures[1:], " and "),
        given=shortened(first),
        measured=_with_sigma(*figures[1:3], "+-") if len(figures) == 3 else "",
        apart=f"{'are apart' if first > 0 else 'overlap'} by {abs(first):.0f}",
        open_counts=_open_counts(list(zip(figures[::2], figures[1::2], strict=False))),
    )


def _frames(numbers: Sequence[float], between: str) -> str:
    """Name frames: ``frame 26``, ``frames 26 and 71``."""
    return f"frame{'s'[len(numbers) == 1 :]} {between.join(f'{one:.0f}' for one in numbers)}"


def sentences(reasons: Iterable[Reason]) -> str | None:
    """Put reasons into words, one after the other; None if there are none."""
    return "; ".join(map(sentence, reasons)) or None


def _open_counts(likely: Sequence[tuple[float, float]]) -> str:
    """Say between which counts, each with its probability, the fit cannot decide."""
    counts = [count for count, _ in likely]
    if not likely:
        return "by a model of the motion no count is likely"
    if len(likely) > 10:  # only about where they are, for the ends were not searched
        about = round(sum(counts) / len(counts), -1)
        return f"a model of the motion leaves open how many there are, about {about:.0f}"
    if len(likely) > 4:
        low, high = min(counts), max(counts)
        return f"a model of the motion allows every count from {low:.0f} to {high:.0f}"
    *others, last = (f"{count:.0f} ({chance:.0%})" for count, chance in likely)
    listed = f"{', '.join(others)} or {last}" if others else last
    return f"by a model of the motion the count is {listed}"

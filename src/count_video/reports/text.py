"""The result for a person: the count first, then what it rests on, then the collisions."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np

from count_video.physics.theory import pi_bounds
from count_video.planning.comparison import Expected, expected_counts, ratio_range
from count_video.planning.variations import RESOLVED_FRAMES
from count_video.records import SURE, ComparedQuantity, PlanComparison, TrialResult
from count_video.reports.exports import collisions_array
from count_video.reports.words import (
    KINDS,
    WIDTH,
    Note,
    answer_text,
    chances_words,
    counts_words,
    plural,
    printable,
    ratio_words,
    shortened,
)

_ENDINGS = {
    "geometric": "geometric: both move away, the ball no faster than the cylinder",
    "pendulum": "by the threads: they turn the cylinder before the ball meets anything",
    "dissipative": "dissipative: the energy is used up",
}
_RATE_SOURCES = {"option": "as given", "metadata": "from the clip", "unknown": "of unknown source"}


def result_text(result: TrialResult, width: int = WIDTH) -> str:
    """Write the result as plain text, sentences in lines of at most ``width`` columns.

    Tables take 80. There is no line's end at the end.
    """
    tables = comparison_lines(result.comparison), collision_lines(result)
    return answer_text(headline(result), result_notes(result), *tables, width=width)


def headline(result: TrialResult) -> str:
    """Say the answer in a few words: the clip's name, its count, and that after review."""
    return f"{printable(Path(result.clip).name)}: {answer_words(result)}{review_words(result)}"


def answer_words(result: TrialResult) -> str:
    """Say the count, with a word of doubt where it is not likely."""
    if result.count is None:
        return "not counted"
    likely = result.probability.get(result.count, 1.0) >= SURE
    return f"{'' if likely else 'probably '}{plural(result.count, 'collision')}"


def review_words(result: TrialResult) -> str:
    """Say the count after review, to be added to the answer; empty where nobody reviewed it."""
    return "" if result.reviewed_count is None else f", {result.reviewed_count} after review"


def result_notes(result: TrialResult) -> list[Note]:
    """List all that is to be said of a result, in order: the lines of text and page."""
    notes = (*_answer_notes(result), *_collision_notes(result), *_scene_notes(result))
    return [(label, printable(sentence)) for label, sentence in notes if sentence]


def _answer_notes(result: TrialResult) -> Iterator[Note]:
    """Yield why there is a doubt, what a person changed, and what was planned."""
    counted = result.status == "counted"
    yield ("In doubt" if counted else "Why"), result.reason or ""
    yield "What to do", result.what_to_do or ""
    if result.reviewed_count is not None:
        changes = []
        for one in result.corrections:
            words, wrong = KINDS[one.kind], one.action == "wrong"
            what = f"no. {one.number} {words} is wrong" if wrong else f"one {words} was missed"
            beyond = "" if one.changes_count else ", after the burst"
            changes.append(f"{what} (frame {one.frame:.1f}{beyond})")
        listed = "; ".join(changes) or "nothing"
        yield "Reviewed", f"{result.reviewed_count}; changed by a person: {listed}"
    for key, note in result.notes.items():
        number, _, place = key.partition("/")
        on = f"no. {number}" if place else "the clip"
        if place and number == "+":
            on = f"the one that was missed in frame {place.rpartition('/')[2]}"
        yield "Note", f"on {on}: {' '.join(note.split())}"
    yield "Plan", comparison_sentence(result.comparison, result.count)


def _collision_notes(result: TrialResult) -> Iterator[Note]:
    """Yield the kinds of collisions, how sure they are, and what follows from them."""
    burst = [c for c in result.collisions if result.count is None or c.number <= result.count]
    kinds = [(sum(c.kind == kind for c in burst), words) for kind, words in KINDS.items()]
    yield "Kinds", ", ".join(f"{number} {words}" for number, words in kinds if number)
    if result.count and result.seen is not None:
        closest = min((b.frame - a.frame for a, b in pairwise(burst)), default=math.inf)
        said = "all seen in the frames"
        if result.between_frames:
            said = f"{result.seen} seen in the frames, {result.between_frames} inferred between"
            said += " them"
        elif closest < RESOLVED_FRAMES:
            said = "all followed from the motion in the frames; some are too close to see one by "
            said += f"one, {closest:.1f} frames at the closest"
        yield "Evidence", said
    chances = result.probability
    likeliest = max(chances, key=lambda count: chances[count], default=0)
    beyond = ", with what follows after the clip" if likeliest > len(result.collisions) else ""
    yield "Probability", f"{chances_words(chances)}{beyond}"
    if result.count_after_burst:
        more = plural(result.count_after_burst, "more collision")
        yield "Afterwards", f"{more} after the cylinder turned back, which the count leaves out"
    yield "Mass ratio", "" if result.ratio is None else ratio_words(result.ratio, "+-")
    yield "Expected", _expected(expected_counts(result), result.count)
    bounds, held = pi_words(result)
    yield "Pi", bounds and f"between {bounds} by the count and the mass ratio; {held}"
    places = ("between the bodies", "at the wall")
    measured = zip((result.restitution_bodies, result.restitution_wall), places, strict=True)
    words = [f"{e.value:.4f} +- {e.sigma:.4f} {where}" for e, where in measured if e]
    yield "Restitution", ", ".join(words)
    ending = result.ending
    if ending is not None:
        yield (
            "Ending",
            f"{_ENDINGS[ending.kind]}; {ending.energy_kept:.0%} of the energy is left; of the "
            f"cylinder's first speed it has {ending.heavy_speed:z.2f} away from the wall, "
            f"the ball {ending.ball_speed:z.2f}",
        )


def _expected(expected: Expected | None, count: int | None) -> str:
    """Say which counts the masses, the threads and the losses lead to, beside the counted one."""
    if expected is None or not count:
        return ""
    (low, high), hanging, lossy = expected.free, expected.hanging, expected.with_losses
    text = f"{counts_words(low, high)} for free bodies without losses"
    if low == high == hanging and lossy in (None, low):
        text = f"{low}, for free bodies without losses and on these threads with these gaps alike"
    elif hanging is not None:
        text += f", {hanging} on these threads with these gaps"
    if lossy not in (None, hanging):
        text += f", {lossy} with these losses as well"
    if low <= count <= high or hanging is None:
        return text
    if count == hanging:
        how = "drive the cylinder back sooner" if count < low else "bring the bodies together again"
        return f"{text}; the threads {how}, and make it {count}"
    if count == lossy:
        return f"{text}; threads and losses make it {count}"
    each = "neither" if lossy in (None, hanging) else "none of them"
    return f"{text}; {each} explains the {count} counted"


def pi_words(result: TrialResult) -> tuple[str, str]:
    """Give the bounds on pi, and say whether it lies inside; empty where there are none."""
    low, high, count = result.pi_low, result.pi_high, result.count or 0
    if low is None or high is None or result.ratio is None:
        return "", ""
    lightest, heaviest = ratio_range(result.ratio)
    held = "pi lies outside"
    if low <= math.pi <= high:
        held = "pi lies inside"
    elif pi_bounds(count, heaviest).low <= math.pi <= pi_bounds(count, lightest).high:
        held = "within the uncertainty of the mass ratio pi lies inside"
    return f"{low:#.5g} and {high:#.5g}", held


def _scene_notes(result: TrialResult) -> Iterator[Note]:
    """Yield what the picture shows, how it was filmed, and what to beware of."""
    scene = []
    if result.wall_side is not None:
        sides = {"left": "above", "right": "below"} if result.upright else {}
        scene.append(f"wall {sides.get(result.wall_side, f'on the {result.wall_side}')}")
    elif any(c.kind == "wall" for c in result.collisions):
        scene.append("a stop at either end")
    if result.ball_diameter_px is not None:
        scene.append(f"ball {result.ball_diameter_px:.1f} px across")
    if result.millimetres_per_px is not None:
        scene.append(f"{result.millimetres_per_px:.3g} mm a pixel")
    yield "Scene", ", ".join(scene)
    if result.frames_decoded is not None:
        rate = "; capture rate unknown, so no times (give it with --capture-fps)"
        if not result.even_rate:
            rate = "; their rate changes, so no times"
        elif result.capture_fps is not None:
            source = _RATE_SOURCES[result.capture_fps_source]
            rate = f", captured at {shortened(result.capture_fps, 6)} frames a second ({source})"
        yield "Footage", plural(result.frames_decoded, "frame") + rate
    for warning in result.warnings:
        yield "Warning", warning


# ---- a plan beside what the clip shows of it ---------------------------------------------------

NAMES = {
    "gap_mm": ("gap", "mm", 1),
    "release_mm": ("release", "mm", 1),
    "bodies_gap_mm": ("gap between the bodies", "mm", 2),
    "heavy_period_s": ("period of the cylinder", "s", 3),
    "ball_period_s": ("period of the ball", "s", 3),
    "mass_ratio": ("mass ratio", "", 3),
    "restitution_bodies": ("restitution of the bodies", "", 4),
    "restitution_wall": ("restitution at the wall", "", 4),
}
"""What the quantities are called, their units, and their decimals."""
_COMPARED = "  {:<28} {:>9} {:>9} {:>8} {:>12} {}"


def comparison_sentence(comparison: PlanComparison | None, count: int | None) -> str:
    """Say what was planned, what was found, and what explains the difference."""
    if comparison is None:
        return ""
    text = f"{comparison.planned_count} collisions, theory {comparison.theory}"
    if count is None:
        return f"{text}; the clip is not counted"
    if not comparison.quantities:
        return f"{text}; the frames do not show the set-up"
    if comparison.found_count is not None:
        text += f"; the set-up that was found gives {comparison.found_count}"
    return f"{text}; {_reason(comparison, count)}"


def _reason(comparison: PlanComparison, count: int) -> str:
    """Say why the count is the planned one, or which difference makes it another."""
    names = [NAMES[name][0] for name in comparison.explained_by]
    if count == comparison.planned_count:
        if others := [NAMES[one.name][0] for one in comparison.quantities if _differs(one)]:
            return f"{count} is what was planned, but not with this {', '.join(others)}"
        otherwise = f"{count} is what was planned: the swing and the losses differ from the theory"
        return "it came out as planned" if count == comparison.theory else otherwise
    if len(names) == len(comparison.quantities) and len(names) > 1:
        return f"all differences together make it {count}, none alone does"
    if names:
        listed = " or ".join(filter(None, (", ".join(names[:-1]), names[-1])))
        return f"the {listed} alone makes it {count}"
    if count == comparison.theory:
        return "it came out as the theory has it"
    return f"no single difference explains {count}"


def comparison_lines(comparison: PlanComparison | None) -> list[str]:
    """Write the table of quantities; no line where nothing was found."""
    if comparison is None or not comparison.quantities:
        return []
    lines = [_COMPARED.format("set-up", "planned", "found", "+-", "alone gives", "")]
    for one in comparison.quantities:
        (name, unit, decimals), found = NAMES[one.name], one.found
        values = (f"{value:.{decimals}f}" for value in (one.planned, found.value, found.sigma))
        count = NOT_KNOWN if one.count is None else str(one.count)
        words = f"{name}{unit and f', {unit}'}"
        lines.append(_COMPARED.format(words, *values, count, "differs" if _differs(one) else ""))
    return [line.rstrip() for line in lines]


def _differs(one: ComparedQuantity) -> bool:
    """Whether what was found is surely not what was planned."""
    return abs(one.found.value - one.planned) > 2 * one.found.sigma


# ---- the collisions ----------------------------------------------------------------------------

NOT_KNOWN = "-"
_NUMBERS = (
    ("", "frame", 9, 2, ("frame",)),
    ("", "time/s", 9, 5, ("time_s",)),
    ("", "ball/px", 8, 1, ("ball_px",)),
    ("ball px/frame", "before    after", 17, 3, ("ball_before_px_frame", "ball_after_px_frame")),
    ("heavy px/frame", "before    after", 17, 3, ("heavy_before_px_frame", "heavy_after_px_frame")),
)
"""Two headings of each column of numbers, its width, decimals, and the columns of the array."""


def collision_lines(result: TrialResult) -> list[str]:
    """Lay the collisions out in rows; those after the counted ones follow under a line of words.

    Columns of which nothing is known (times without a capture rate, a heavy body that is not
    there) are left out.
    """
    if not result.collisions:
        return []
    table, above, headings = collisions_array(result), " " * 15, "   no.  kind   "
    rows = [f" {c.number:>5}  {c.kind + '*' * (not c.seen):<7}" for c in result.collisions]
    for over, heading, width, decimals, names in _NUMBERS:
        values = np.array([table[name] for name in names]).T
        if np.isfinite(values).any():
            above, headings = f"{above} {over:>{width}}", f"{headings} {heading:>{width}}"
            for k, known in enumerate(values):
                numbers = (f"{v:z.{decimals}f}" if math.isfinite(v) else NOT_KNOWN for v in known)
                # A cell wider than its column keeps its gap: the numbers never touch.
                rows[k] += f" {' '.join(f'{number:>8}' for number in numbers).strip():>{width}}"
    if result.count is not None and result.count < len(rows):
        rows.insert(result.count, "  after the cylinder turned back:")
    inferred = [] if table["seen"].all() else ["  * inferred between frames"]
    return [*filter(None, [above.rstrip()]), headings, *map(str.rstrip, rows), *inferred]

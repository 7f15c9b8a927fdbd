"""The result for a person: the count first, then what it rests on, then the collisions."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

from count_video.physics.theory import pi_bounds
from count_video.planning.comparison import Expected, expected_counts, ratio_range
from count_video.records import (
    Collision,
    ComparedQuantity,
    Correction,
    Ending,
    Estimate,
    PlanComparison,
    TrialResult,
)
from count_video.reports.tables import NOT_KNOWN, Column, collision_lines, text_table
from count_video.reports.words import (
    WIDTH,
    Note,
    answer_text,
    counts_words,
    fixed,
    percent,
    plural,
    printable,
    ratio_words,
)

_CLOSE_FRAMES = 2.5
"""Collisions closer than this follow from fits on both sides, not from frames between them."""
_LIKELY = 0.9
"""A count less probable than this does not stand in the first line without a word of doubt."""
_ENDING_IN_WORDS = {
    "geometric": "geometric: both move away, the ball no faster than the heavy body",
    "pendulum": "by the threads: they turn the heavy body before the ball meets anything",
    "dissipative": "dissipative: the energy is used up",
}
_KIND_IN_WORDS = {"bodies": "between the bodies", "wall": "with the wall"}
_WALL_IN_WORDS = {
    (False, "left"): "wall on the left",
    (False, "right"): "wall on the right",
    (True, "left"): "wall above",
    (True, "right"): "wall below",
}
"""By whether the bodies move up and down, and the side that the wall is on."""


def result_text(result: TrialResult, width: int = WIDTH) -> str:
    """Write the result as plain text, in lines of at most ``width`` columns.

    A table that is wider goes on below itself. There is no line's end at the end.
    """
    tables = comparison_lines(result.comparison, width), collision_lines(result, width)
    return answer_text(headline(result), result_notes(result), *tables, width=width)


def headline(result: TrialResult) -> str:
    """Say the answer in a few words: the clip's name and its count."""
    clip = printable(Path(result.clip).name)
    reviewed = f", {result.reviewed_count} after review" if _is_reviewed(result) else ""
    if result.count is None or result.status == "not_counted":
        return f"{clip}: not counted{reviewed}"
    count = plural(result.count, "collision")
    likely = result.probability.get(result.count, 1.0) >= _LIKELY
    return f"{clip}: {'' if likely else 'probably '}{count}{reviewed}"


def _is_reviewed(result: TrialResult) -> bool:
    return result.reviewed_count is not None


def result_notes(result: TrialResult) -> list[Note]:
    """List all that is to be said of a result, in order: the lines of text and page."""
    notes = [
        ("Why" if result.status == "not_counted" else "In doubt", result.reason or ""),
        ("What to do", _advice(result)),
        ("Reviewed", _reviewed(result)),
        ("Plan", comparison_sentence(result.comparison, result.count)),
        ("Kinds", _kinds(result)),
        ("Evidence", _evidence(result)),
        ("Probability", _probability(result)),
        ("Afterwards", _afterwards(result)),
        ("Mass ratio", _mass_ratio(result)),
        ("Expected", _expected(result)),
        ("Pi", _pi(result)),
        ("Restitution", _restitution(result)),
        ("Ending", _ending(result.ending)),
        ("Scene", _scene(result)),
        ("Footage", _footage(result)),
        *(("Warning", warning) for warning in result.warnings),
    ]
    return [(label, printable(sentence)) for label, sentence in notes if sentence]


def _advice(result: TrialResult) -> str:
    if result.status == "counted":
        return ""
    return (
        "The clip must show the trial from before the first collision until the heavy body "
        "turns back. Cut away what does not belong to it with --start, --end and "
        "--region X,Y,W,H, or name the side of the wall with --wall."
    )


def _reviewed(result: TrialResult) -> str:
    if not _is_reviewed(result):
        return ""
    changes = [_change(correction) for correction in result.corrections]
    return f"{result.reviewed_count}; changed by a person: {'; '.join(changes) or 'nothing'}"


def _change(correction: Correction) -> str:
    words = _KIND_IN_WORDS[correction.kind]
    beyond = "" if correction.changes_count else ", after the burst"
    if correction.action == "wrong":
        return f"no. {correction.number} {words} is wrong (frame {correction.frame:.1f}{beyond})"
    return f"one {words} was missed (frame {correction.frame:.1f}{beyond})"


def _kinds(result: TrialResult) -> str:
    burst = _burst(result)
    numbers = {kind: sum(c.kind == kind for c in burst) for kind in _KIND_IN_WORDS}
    return ", ".join(f"{n} {_KIND_IN_WORDS[kind]}" for kind, n in numbers.items() if n)


def _burst(result: TrialResult) -> tuple[Collision, ...]:
    return tuple(c for c in result.collisions if result.count is None or c.number <= result.count)


def _evidence(result: TrialResult) -> str:
    if not result.count or result.seen is None:
        return ""
    between = result.between_frames or 0
    if between:
        return f"{result.seen} seen in the frames, {between} inferred between them"
    frames = [collision.frame for collision in _burst(result)]
    closest = min((later - earlier for earlier, later in pairwise(frames)), default=math.inf)
    if closest >= _CLOSE_FRAMES:
        return "all seen in the frames"
    return (
        f"all followed from the motion in the frames; some are too close to see one by one, "
        f"{closest:.1f} frames at the closest"
    )


def _probability(result: TrialResult) -> str:
    chances = sorted(result.probability.items(), key=lambda item: -item[1])
    return ", ".join(f"{count}: {percent(chance)}" for count, chance in chances if chance >= 0.005)


def _afterwards(result: TrialResult) -> str:
    if not result.count_after_burst:
        return ""
    found = plural(result.count_after_burst, "more collision")
    return f"{found} after the heavy body turned back, which the count leaves out"


def _mass_ratio(result: TrialResult) -> str:
    if result.mass_ratio is None:
        return ""
    return ratio_words(Estimate(result.mass_ratio, result.mass_ratio_sigma or 0.0), "+-")


def _expected(result: TrialResult) -> str:
    """Say which counts the masses, the threads and the losses lead to, beside the counted one."""
    expected = expected_counts(result)
    if expected is None or not result.count:
        return ""
    low, high = expected.free
    free = counts_words(low, high)
    if low == high == expected.hanging and expected.with_losses in (None, low):
        return f"{free}, for free bodies without losses and on these threads with these gaps alike"
    parts = [f"{free} for free bodies without losses"]
    if expected.hanging is not None:
        parts.append(f"{expected.hanging} on these threads with these gaps")
    if expected.with_losses not in (None, expected.hanging):
        parts.append(f"{expected.with_losses} with these losses as well")
    return f"{', '.join(parts)}{_explained(expected, result.count)}"


def _explained(expected: Expected, count: int) -> str:
    """Say what makes the count another than that of free bodies; empty if it is none."""
    low, high = expected.free
    if low <= count <= high:
        return ""
    if count == expected.hanging:
        how = "drive the cylinder back sooner" if count < low else "bring the bodies together again"
        return f"; the threads {how}, and make it {count}"
    if count == expected.with_losses:
        return f"; threads and losses make it {count}"
    return "" if expected.hanging is None else f"; neither explains the {count} counted"


def _pi(result: TrialResult) -> str:
    low, high = result.pi_low, result.pi_high
    if low is None or high is None:
        return ""
    lightest, heaviest = ratio_range(result)
    count = result.count or 0
    if low <= math.pi <= high:
        held = "pi lies inside"
    elif pi_bounds(count, heaviest).low <= math.pi <= pi_bounds(count, lightest).high:
        held = "within the uncertainty of the mass ratio pi lies inside"
    else:
        held = "pi lies outside"
    return f"between {low:.5g} and {high:.5g} by the count and the mass ratio; {held}"


def _restitution(result: TrialResult) -> str:
    parts = [("between the bodies", result.restitution_bodies)]
    parts.append(("at the wall", result.restitution_wall))
    return ", ".join(f"{e.value:.4f} +- {e.sigma:.4f} {where}" for where, e in parts if e)


def _ending(ending: Ending | None) -> str:
    if ending is None:
        return ""
    return (
        f"{_ENDING_IN_WORDS[ending.kind]}; {ending.energy_kept:.0%} of the energy is left, and of "
        f"the first speed the heavy body has {fixed(ending.heavy_speed, 2)}, the ball "
        f"{fixed(ending.ball_speed, 2)} (away from the wall)"
    )


def _scene(result: TrialResult) -> str:
    parts = []
    if result.wall_side is not None:
        parts.append(_WALL_IN_WORDS[bool(result.upright), result.wall_side])
    if result.ball_diameter_px is not None:
        parts.append(f"ball {result.ball_diameter_px:.1f} px across")
    if result.millimetres_per_px is not None:
        parts.append(f"{result.millimetres_per_px:.3g} mm a pixel")
    return ", ".join(parts)


def _footage(result: TrialResult) -> str:
    if result.frames_decoded is None:
        return ""
    frames = plural(result.frames_decoded, "frame")
    if result.capture_fps is None:
        return f"{frames}; capture rate unknown, so no times (give it with --capture-fps)"
    source = {"option": "as given", "metadata": "from the clip", "unknown": "of unknown source"}
    rate = f"{result.capture_fps:.6g} frames a second"
    return f"{frames}, captured at {rate} ({source[result.capture_fps_source]})"


# ---- a plan beside what the clip shows of it ---------------------------------------------------

NAMES = {
    "gap_mm": ("gap", "mm"),
    "release_mm": ("release", "mm"),
    "bodies_gap_mm": ("gap between the bodies", "mm"),
    "heavy_period_s": ("period of the cylinder", "s"),
    "ball_period_s": ("period of the ball", "s"),
    "mass_ratio": ("mass ratio", ""),
    "restitution_bodies": ("restitution, bodies", ""),
    "restitution_wall": ("restitution, wall", ""),
}
"""What the quantities are called, and their units."""
_DECIMALS = {"mm": 1, "s": 3, "": 3}
DIFFERENT_SIGMAS = 2.0
"""A difference of more standard uncertainties than this is marked."""
_COMPARED = (
    *(Column(" set-up", 30, align="<"), Column("planned", 11), Column("found", 11)),
    *(Column("+-", 9), Column("alone gives", 13), Column("", 2, align="<")),
)


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
    names = [NAMES[name][0] for name in comparison.explained_by]
    if count == comparison.planned_count:
        if count == comparison.theory:
            return "it came out as planned"
        return f"{count} is what was planned: the swing and the losses differ from the theory"
    if len(names) == len(comparison.quantities) and len(names) > 1:
        return f"all differences together make it {count}, none alone does"
    if names:
        return f"the {_listed(names)} alone makes it {count}"
    if count == comparison.theory:
        return "it came out as the theory has it"
    return f"no single difference explains {count}"


def _listed(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} or {names[-1]}"


def comparison_lines(comparison: PlanComparison | None, width: int = WIDTH) -> list[str]:
    """Write the table of quantities; no line where nothing was found."""
    if comparison is None or not comparison.quantities:
        return []
    return text_table(_COMPARED, [_cells(one) for one in comparison.quantities], width)


def _cells(one: ComparedQuantity) -> list[str]:
    name, unit = NAMES[one.name]
    values = (one.planned, one.found.value, one.found.sigma)
    off = abs(one.found.value - one.planned) > DIFFERENT_SIGMAS * one.found.sigma
    return [
        f" {name}, {unit}" if unit else f" {name}",
        *(f"{value:.{_DECIMALS[unit]}f}" for value in values),
        NOT_KNOWN if one.count is None else str(one.count),
        "*" if off else "",
    ]

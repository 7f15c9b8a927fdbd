"""From what the frames show to the answer: counted or not, how sure, and what to do."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction

from count_video.between.infer import Between, Misfit
from count_video.between.rivals import Knowledge
from count_video.collisions.burst import Rival
from count_video.collisions.seen import SeenCollisions
from count_video.collisions.weighing import SeenImpacts
from count_video.footage.clock import real_time_s
from count_video.physics.theory import pi_bounds
from count_video.records import (
    Collision,
    FootageInfo,
    FootageReport,
    Track,
    TrialResult,
)

PROBABILITY_RESOLVED = 0.98
"""Share of resolved clips that come out right, not above what tests have shown."""
MASS_RATIO_SIGMA_AT_MOST = 0.1
"""A measured mass ratio is told only if it is known to this share."""


PROBABILITY_AT_LEAST = 0.5
"""A count that is inferred must be more probable than all others together, ..."""
INTERVAL_SHARE = 0.01
"""... or, in a burst of hundreds, right to this share of it, ..."""
INTERVAL_PROBABILITY = 0.95
"""... with this probability."""
LIKELY_ABOVE = 0.02
"""Less likely counts are not named ..."""
LISTED_AT_MOST = 4
"""... of more than so many only the range, ..."""
RANGED_AT_MOST = 10
"""... and of more than so many only about where they are: the ends were not looked for."""
MASS_RELATIVE_SIGMA = 0.002
"""Standard uncertainty of a mass ratio that the user gives: kitchen scales and a ring of thread."""
IMPACTS_PROBABILITY_AT_LEAST = 0.25
"""A smaller number of impacts is a lower bound, no count: more of them are likely not seen."""
IMPACTS_OF_ONE_ALONE = 3
"""So many impacts at one stop are those of one body that bounces, not of one of two in a trial."""
MADE_UP_FOR = "the clip ends"
"""How the shortcomings begin that a fitted model can make up for: it knows what follows."""


def counted(
    info: FootageInfo,
    report: FootageReport,
    track: Track,
    found: SeenCollisions,
    masses: tuple[Fraction, Fraction] | None,
    ball_diameter_mm: float,
) -> TrialResult:
    """Judge what was found in a clip with both bodies."""
    collisions = tuple(_timed(collision, info.capture_fps) for collision in found.collisions)
    reason = why_not(found)
    count = None if reason else found.burst
    ratio = _ratio(found, masses)
    pi = pi_bounds(count, *ratio) if count and ratio else None
    return replace(
        nothing_to_count(info, report, reason or ""),
        status="not_counted" if reason else "counted",
        reason=reason or _open(found),
        count=count,
        seen=found.burst,
        between_frames=None if reason else 0,
        probability={} if count is None else probabilities(count, found.rival),
        count_after_burst=len(collisions) - found.burst,
        collisions=collisions,
        wall_side=track.wall_side,
        ball_diameter_px=track.ball_diameter_px,
        millimetres_per_px=ball_diameter_mm / track.ball_diameter_px,
        pi_low=None if pi is None else pi.low,
        pi_high=None if pi is None else pi.high,
        mass_ratio=None if ratio is None else float(ratio[0] / ratio[1]),
        warnings=(*report.warnings, *track.warnings),
    )


def impacts_counted(
    info: FootageInfo, report: FootageReport, track: Track, found: SeenImpacts
) -> TrialResult:
    """Judge what was found in a clip of one body alone, or of two without a wall."""
    collisions = tuple(_timed(collision, info.capture_fps) for collision in found.collisions)
    chance = found.probability.get(len(collisions), 0.0)
    likely = chance >= max(IMPACTS_PROBABILITY_AT_LEAST, *found.probability.values(), 0.0)
    counts = likely and not found.shortcomings
    reasons = found.shortcomings or found.doubts
    if not (likely or found.shortcomings):
        likelier = max(found.probability, key=found.probability.__getitem__)
        reasons = (*reasons, f"{len(collisions)} impacts are seen, but {likelier} are likelier")
    return replace(
        nothing_to_count(info, report, ""),
        status="counted" if counts else "not_counted",
        reason="; ".join(reasons) or None,
        count=len(collisions) if counts else None,
        seen=len(collisions),
        between_frames=0 if counts else None,
        probability=found.probability if counts else {},
        count_after_burst=0,
        collisions=collisions,
        wall_side=track.wall_side if track.heavy is None else None,
        ball_diameter_px=track.ball_diameter_px,
        warnings=(*report.warnings, *track.warnings),
    )


def is_settled(result: TrialResult, *, at_wall: bool) -> bool:
    """Whether a count of two bodies needs no other look at the clip.

    Without a wall many impacts may be those of one body alone on its mirror image.
    """
    return result.count is not None and (at_wall or result.count < IMPACTS_OF_ONE_ALONE)


def is_better(result: TrialResult, track: Track | None, pair: Track | None) -> bool:
    """Whether what the second look tells comes before what the first told of a pair."""
    if result.count is None or track is None:
        return False
    if track.heavy is None and result.count >= IMPACTS_OF_ONE_ALONE:
        return True
    return pair is None or not pair.wall_seen


def nothing_to_count(info: FootageInfo, report: FootageReport, reason: str) -> TrialResult:
    """Answer for a clip that was read but shows nothing that can be counted."""
    return TrialResult(
        clip=str(info.path),
        status="not_counted",
        reason=reason,
        count=None,
        seen=None,
        between_frames=None,
        probability={},
        count_after_burst=None,
        collisions=(),
        capture_fps=info.capture_fps,
        capture_fps_source=info.capture_fps_source,
        frames_decoded=report.frames_decoded,
        frames_promised=report.frames_promised,
        wall_side=None,
        ball_diameter_px=None,
        millimetres_per_px=None,
        pi_low=None,
        pi_high=None,
        mass_ratio=None,
        warnings=report.warnings,
    )


def why_not(found: SeenCollisions) -> str | None:
    """Why the burst cannot be counted, as one sentence; None if it can."""
    if found.burst == 0:
        return "no collision is seen: no gap between two bodies closes and opens with a jump"
    reasons: Sequence[str] = (*found.shortcomings, *found.doubts)
    return "; ".join(reasons) if reasons else None


def _open(found: SeenCollisions) -> str | None:
    """Say what leaves a count open between two that are both likely."""
    likely = found.rival is not None and found.rival.probability > LIKELY_ABOVE
    return found.rival.reason if found.rival and likely else None


def leaves_room(found: SeenCollisions) -> bool:
    """Whether collisions may lie where no frame shows them, and the beginning is there."""
    doubtful = bool(found.doubts or found.shortcomings)
    whole = all(shortcoming.startswith(MADE_UP_FOR) for shortcoming in found.shortcomings)
    return found.burst > 1 and doubtful and whole


def knowledge(info: FootageInfo, masses: tuple[Fraction, Fraction] | None) -> Knowledge:
    """Tell a fit what is known besides the track."""
    if masses is None:
        return Knowledge(info.capture_fps)
    ratio = float(masses[0] / masses[1])
    return Knowledge(info.capture_fps, ratio, MASS_RELATIVE_SIGMA * ratio)


def inferred(result: TrialResult, found: SeenCollisions, between: Between | Misfit) -> TrialResult:
    """Complete the answer by what lies between the frames, or say why nothing can be said."""
    if isinstance(between, Misfit):
        return replace(result, reason=f"{result.reason}; {between.reason}")
    count = between.count
    least = min(found.burst, found.rival.count) if found.rival else found.burst
    if count < least:
        return replace(
            result,
            reason=f"{result.reason}; the model of the motion that describes the track best has "
            f"only {count} where the frames show {least} collisions",
        )
    if not sure_enough(between):
        return replace(
            result,
            reason=f"{result.reason}; {left_open(between, result.mass_ratio)}",
            probability=between.probability,
        )
    burst = tuple(_timed(collision, result.capture_fps) for collision in between.collisions)
    after = result.collisions[min(count, found.burst) :]
    later = tuple(replace(c, number=count + place) for place, c in enumerate(after, 1))
    seen = sum(collision.seen for collision in burst)
    ratio = result.mass_ratio or between.mass_ratio.value
    pi = pi_bounds(count, ratio, 1)
    doubtful = between.probability[count] < PROBABILITY_AT_LEAST
    counted_now = replace(
        result,
        status="counted",
        reason=left_open(between, result.mass_ratio) if doubtful else None,
        count=count,
        seen=seen,
        between_frames=count - seen,
        probability=between.probability,
        count_after_burst=len(later),
        collisions=(*burst, *later),
        pi_low=pi.low,
        pi_high=pi.high,
        mass_ratio=ratio,
    )
    return measured(counted_now, between)


def left_open(between: Between, mass_ratio: float | None) -> str:
    """Say between which counts the fit cannot decide."""
    likely = {n: p for n, p in between.probability.items() if p > LIKELY_ABOVE}
    if len(likely) > RANGED_AT_MOST:
        about = round(sum(likely) / len(likely), -1)
        which = f"a model of the motion tells no more than that there are about {about:.0f}"
    elif len(likely) > LISTED_AT_MOST:
        which = f"a model of the motion only tells that it is one of {min(likely)} to {max(likely)}"
    else:
        listed = ", ".join(f"{n} ({p:.0%})" for n, p in likely.items())
        which = f"a model of the motion leaves open which of {listed} it is"
    return which if mass_ratio else f"{which}; the masses, given with --masses, narrow it down"


def sure_enough(between: Between) -> bool:
    """Whether a count may be told: probable by itself, or within a narrow interval."""
    count, chances = between.count, between.probability
    near = sum(p for n, p in chances.items() if abs(n - count) <= INTERVAL_SHARE * count)
    return chances[count] >= PROBABILITY_AT_LEAST or near >= INTERVAL_PROBABILITY


def measured(result: TrialResult, between: Between | Misfit) -> TrialResult:
    """Add what the fit tells of the physics; nothing where it does not describe the track."""
    if isinstance(between, Misfit):
        return result
    return replace(
        result,
        energy_kept=between.energy_kept,
        restitution_bodies=between.restitution_bodies,
        restitution_wall=between.restitution_wall,
        ending=between.ending,
    )


def probabilities(count: int, rival: Rival | None = None) -> dict[int, float]:
    """Probability of each count where all collisions are resolved.

    What is left to doubt is shared between one more and one fewer, of both counts if a rival to
    the one told is open.
    """
    shares = {count: 1.0} if rival is None else {count: 1 - rival.probability}
    if rival is not None:
        shares[rival.count] = rival.probability
    rest = (1 - PROBABILITY_RESOLVED) / 2
    chances: dict[int, float] = {}
    for number, share in shares.items():
        for near, part in ((-1, rest), (0, PROBABILITY_RESOLVED), (1, rest)):
            chances[number + near] = chances.get(number + near, 0.0) + share * part
    return dict(sorted(chances.items()))


def _ratio(
    found: SeenCollisions, masses: tuple[Fraction, Fraction] | None
) -> tuple[Fraction | float, Fraction | float] | None:
    if masses is not None:
        return masses
    swing = found.swing
    if swing is None or swing.mass_ratio_relative_sigma > MASS_RATIO_SIGMA_AT_MOST:
        return None
    return swing.mass_ratio, 1


def _timed(collision: Collision, capture_fps: float | None) -> Collision:
    if capture_fps is None:
        return collision
    return replace(collision, time_s=real_time_s(collision.frame, capture_fps))

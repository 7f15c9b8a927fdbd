"""From the explanation that stands to the answer: every field is read off it once."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path

from count_video.explanations import Explanation, doubted_for_missing
from count_video.motion.parameters import Knowledge
from count_video.motion.priors import SWING_RATIO_SHARE
from count_video.physics.theory import pi_bounds
from count_video.reasons import UNEVEN_TIMES, Cause, Reason
from count_video.records import Estimate, FootageInfo, FootageReport, Track, TrialResult, WallSide
from count_video.reports.words import CLEARER, sentence, sentences, what_to_do
from count_video.scenes import turns_on_both_sides
from count_video.settings import TrialSettings
from count_video.tracking.pairing import contradiction

GAINED_AT_MOST = 0.1
"""Bodies gain no energy. By uncertainties, and a lens, a fitted motion does so by less than this
share: of 876 clips that were counted rightly in all but two, whose rate changes unnoticed."""
RELATIVE_SIGMA_AT_MOST = 0.1
"""A measured mass ratio is given only if it is known to this share."""


@dataclass(frozen=True)
class Followed:
    """One clip: the answer, and the motion that it rests on, from which evidence can be drawn."""

    result: TrialResult
    track: Track | None = None
    """None where no bodies could be followed."""

    @property
    def path(self) -> Path:
        """The clip's file."""
        return Path(self.result.clip)


def knowledge(info: FootageInfo, settings: TrialSettings) -> Knowledge:
    """Say what is known besides the track."""
    ratio = float(settings.masses[0] / settings.masses[1]) if settings.masses else None
    return Knowledge(info.capture_fps, ratio, settings.seen_only)


def nothing_to_count(info: FootageInfo, report: FootageReport, reason: str) -> TrialResult:
    """Answer for a clip that was read but shows nothing that can be counted."""
    to_do = CLEARER
    if report.frames_decoded == 1:
        reason = "one picture alone could be read, in which nothing moves"
        to_do = "give the whole clip"
    return TrialResult(
        clip=str(info.path),
        status="not_counted",
        reason=reason,
        what_to_do=to_do,
        capture_fps=info.capture_fps,
        capture_fps_source=info.capture_fps_source,
        frames_decoded=report.frames_decoded,
        frames_promised=report.frames_promised,
        warnings=report.warnings,
    )


def answer(
    explained: Explanation, info: FootageInfo, report: FootageReport, settings: TrialSettings
) -> TrialResult:
    """Read the answer off an explanation."""
    explained = doubted_for_missing(explained, report)
    track, count, fit = explained.track, explained.count, explained.fit
    even_rate = UNEVEN_TIMES.isdisjoint(note.cause for note in explained.notes)
    if not even_rate:  # no rate is that of all frames
        info = replace(info, capture_fps=None, capture_fps_source="unknown")
    fps = info.capture_fps
    collisions = tuple(
        replace(one, number=number, time_s=None if fps is None else one.frame / fps)
        for number, one in enumerate(explained.collisions, 1)
    )
    seen = sum(collision.seen for collision in collisions[:count])
    at_wall, counts = explained.scene == "wall", explained.counts
    why = explained.against or explained.doubts
    scaled = at_wall and not explained.outlines_apart
    unused = not at_wall and settings.masses is not None
    notes = (*explained.notes, *([Reason(Cause.MASSES_UNUSED)] if unused else ()))
    most = max((1.0,) if fit is None else fit.energy_kept, default=1.0)
    if most > 1 + GAINED_AT_MOST:
        notes = (*notes, Reason(Cause.ENERGY_GAINED, (most,)))
    result = replace(
        nothing_to_count(info, report, ""),
        status="counted" if counts else "not_counted",
        reason=sentences(why),
        what_to_do=what_to_do(why),
        count=count if counts else None,
        seen=seen,
        between_frames=count - seen if counts else None,
        probability={} if explained.against else explained.probability,
        count_after_burst=len(collisions) - count,
        collisions=collisions,
        wall_side=_wall_shown(explained, settings),
        upright=track.line.upright,
        even_rate=even_rate,
        ball_diameter_px=track.ball_diameter_px,
        millimetres_per_px=settings.ball_diameter_mm / track.ball_diameter_px if scaled else None,
        warnings=(
            *report.warnings,
            *track.warnings,
            *contradiction(settings.wall, track.wall_side if at_wall else None),
            *map(sentence, notes),
        ),
    )
    if fit is not None:
        result = replace(
            result,
            energy_kept=fit.energy_kept,
            restitution_bodies=fit.restitution_bodies,
            restitution_wall=fit.restitution_wall,
            ending=fit.ending if counts else None,
            setup=fit.setup,
        )
    if unused:
        return result
    measured = measured_ratios(explained) if counts else []
    return weighed(result, measured, settings.masses)


def _wall_shown(explained: Explanation, settings: TrialSettings) -> WallSide | None:
    """Side of the wall; None where none is shown, or a body alone turns at both ends of its way."""
    both = explained.track.heavy is None and turns_on_both_sides(explained)
    shown = any(one.kind == "wall" for one in explained.collisions) or settings.wall is not None
    return None if both or not shown or explained.scene == "bodies" else explained.track.wall_side


def measured_ratios(explained: Explanation) -> list[Estimate]:
    """Mass ratios that the motion gives, as far as it determines them: the fit's, the swing's."""
    found, fit = explained.found, explained.fit
    swing = None if found is None else found.swing
    ratios = [] if fit is None else [fit.mass_ratio]
    if swing is not None:
        ratio = float(swing.mass_ratio)
        share = math.hypot(swing.mass_ratio_relative_sigma, SWING_RATIO_SHARE)
        ratios.append(Estimate(ratio, ratio * share))
    return [one for one in ratios if one.sigma <= RELATIVE_SIGMA_AT_MOST * one.value]


def weighed(
    result: TrialResult, measured: list[Estimate], masses: tuple[Fraction, Fraction] | None
) -> TrialResult:
    """Complete an answer by the masses, exact and in any one unit, or else by a measured ratio.

    The best of ``measured`` comes first. Pi is bounded by N theta and (N + 1) theta.
    """
    heavy: Fraction | float
    light: Fraction | float
    sigma, other = None, None
    if masses is not None:
        heavy, light = masses
        given = float(heavy / light)
        if measured and Knowledge(mass_ratio=given).contradicts(measured[0]):
            other = measured[0]
            clash = Reason(Cause.MASSES_CONTRADICT, (given, other.value, other.sigma))
            result = replace(result, warnings=(*result.warnings, sentence(clash)))
    elif measured:
        heavy, light, sigma = measured[0].value, 1.0, measured[0].sigma
    else:
        return result
    pi = pi_bounds(result.count, heavy, light) if result.count else None
    return replace(
        result,
        mass_ratio=float(heavy / light),
        contradicting_ratio=other,
        mass_ratio_sigma=sigma,
        pi_low=pi.low if pi else None,
        pi_high=pi.high if pi else None,
    )

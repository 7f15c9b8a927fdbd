"""A plan for a person: the count first, then what the camera sees, how sure it is, what to change.

The sentences are here alone; terminal and page show the same. The theory of two masses, which needs
no set-up, stands below.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from fractions import Fraction

from count_video.physics.theory import Mass, collision_count, pi_bounds, theory_of
from count_video.planning import variations
from count_video.planning.plan import PICTURE_WIDTH_PX, CameraView, Plan
from count_video.planning.request import PlanRequest
from count_video.reports.campaign import entry, histogram_lines, paper_lines
from count_video.reports.words import (
    RARE,
    WIDTH,
    Note,
    answer_text,
    percent,
    plural,
    share_words,
    shortened,
)

GOOD_BALL_PX = 60
"""A ball this wide or wider is followed well."""


def plan_text(plan: Plan, width: int = WIDTH) -> str:
    """Write the plan as plain text, in sentences of at most ``width`` columns."""
    table = table_lines(plan.table)
    return answer_text(plan_headline(plan), plan_notes(plan), table, width=width)


def plan_headline(plan: Plan) -> str:
    """Say the answer in one line."""
    request = plan.request
    return (
        f"{plain(request.heavy)} and {plain(request.light)}, gap {_mm(request.gap_m)}, release "
        f"{_mm(request.release_m)}: {plural(plan.burst.count, 'collision')}"
    )


def plan_notes(plan: Plan) -> list[Note]:
    """Label and sentence of everything that is said, in order."""
    return [*_burst_notes(plan), *_camera_notes(plan), *_spread_notes(plan)]


def _burst_notes(plan: Plan) -> Iterator[Note]:
    burst = plan.burst
    here = "the same as" if burst.count == burst.theory else str(burst.count)
    yield "Theory", f"{burst.theory} for free bodies without losses; {here} here"
    walls = burst.count - burst.bodies
    yield "Kinds", f"{burst.bodies} between the bodies, {walls} with the wall"
    shortest = burst.shortest_s
    text = f"{1e3 * shortest:.3g} ms" if shortest < 1.0 else f"{shortest:.3g} s"
    text += " from one collision to the next where they follow each other fastest"
    yield "Shortest", "there is one collision alone" if math.isinf(shortest) else text
    where = "at the wall" if burst.last_m == 0 else f"{_mm(burst.last_m)} from the wall"
    speed = f"{shortened(1e3 * burst.last_speed_m_s, 3)} mm/s"
    yield "Last", f"with the ball {where}, where the two close in at {speed}"
    text = f"from {burst.first_s:.2f} s to {burst.last_s:.2f} s after the release "
    text += f"({burst.last_s - burst.first_s:.2f} s); the cylinder "
    if math.isinf(burst.turn_s):
        text += "does not turn round"
    else:
        text += f"turns round at {burst.turn_s:.2f} s, {_mm(burst.swing_back_m)} beyond its rest: "
        text += "let the camera run from before the release until then"
    yield "Burst", text


def _camera_notes(plan: Plan) -> Iterator[Note]:
    framing = plan.framing
    yield "Camera", _camera_words(plan.camera)
    yield "Film at", f"{framing.rate_needed_fps:.0f} frames a second to see each collision"
    least = math.ceil(framing.ball_at_least_px)
    most, hop = f"{framing.ball_at_most_px:.0f} px", f"{framing.smallest_hop_px:.3g} px"
    text = f"the ball at least {least} px across"
    if least < GOOD_BALL_PX:
        text += f", better {GOOD_BALL_PX}"
    if least > framing.ball_at_most_px:
        text = f"none that is {PICTURE_WIDTH_PX} px wide shows it: the ball must be at least "
        text += f"{least} px across and can be at most {most}, with a smallest hop of {hop}"
    elif math.isfinite(framing.smallest_hop_px):
        text += f"; in a picture {PICTURE_WIDTH_PX} px wide at most {most}, and then the ball's "
        text += f"smallest hop is {hop}"
    yield "Picture", text


def _camera_words(camera: CameraView | None) -> str:
    """Say what the frames show, what is inferred, and how often such clips were counted exactly."""
    if camera is None:
        return "no rate given (--capture-fps)"
    text = f"{shortened(camera.capture_fps, 6)} frames a second: "
    if camera.way == "seen":
        text += "the frames show every collision"
    else:
        text += f"{plural(camera.close, 'collision')} closer than "
        text += f"{variations.RESOLVED_FRAMES:g} frames to the one before, "
        text += f"{camera.shortest_frames:.2g} at the closest; "
        text += "these are inferred" if camera.way == "inferred" else ""
    measured = camera.measured
    if measured is None:
        return f"{text}whether such a clip is counted was never measured"
    return (
        f"{text}; counted exactly with a chance of {percent(measured.chance)} ({measured.exact} of "
        f"{measured.clips} {measured.kind} were, {measured.wrong or 'none'} wrongly)"
    )


def _spread_notes(plan: Plan) -> Iterator[Note]:
    spread, off = plan.spread, plan.request.tolerances
    low, high = variations.restitution_range(plan.request)
    text = _counts(spread)
    text += f", with gaps +-{_mm(off.gap_m)}, releases +-{_mm(off.release_m)}, masses "
    text += f"+-{100 * off.mass:g}%, threads +-{_mm(off.thread_m)} (standard deviations) and "
    text += f"restitutions from {low:.3g} to {high:.3g} that scatter by {off.scatter:g}"
    yield "How sure", text
    if not spread.mostly_endless:
        (low, high), (least, most) = spread.table_mean, spread.table_sd
        text = f"of {spread.table_trials} such trials has a mean of {low:.2f} to {high:.2f} and a "
        text += f"standard deviation of {least:.2f} to {most:.2f} (95 in 100 tables)"
        yield "A table", text
    yield "Change", _change(plan)


def _counts(spread: variations.Spread) -> str:
    """List the counts, or where there are many their range, or say how few trials have one."""
    trials = f"of {spread.trials} simulated trials"
    if spread.mostly_endless:
        some = sum(spread.histogram.values())
        text = f"{some or 'none'} {trials} {'have' if some > 1 else 'has'} a count; in "
        text += f"{'the others' if some else 'each'} the ball rattles to rest"
        return f"{text} and nothing is counted"
    shares = {count: number / spread.trials for count, number in spread.histogram.items()}
    listed = {count: share for count, share in shares.items() if share >= RARE}
    ordered = sorted(listed.items(), key=lambda item: -item[1])
    text = ", ".join(f"{count} in {share_words(share)}" for count, share in ordered)
    if len(listed) > 5:
        text = f"counts from {min(listed)} to {max(listed)} in most"
    text = f"{text or f'no count in {percent(RARE)} or more'} {trials}"
    if spread.endless_share:
        text += f"; in {spread.endless_share:.0%} the ball rattles to rest and nothing is counted"
    return text


def _change(plan: Plan) -> str:
    """Say what to change for the theory's count with a safe margin, and for the camera."""
    theory = plan.burst.theory
    if plan.spread.theory_share >= variations.ENOUGH:
        text = f"nothing, it gives {theory} with a safe margin"
    elif plan.proposals:
        words = [_proposal(plan.request, proposal) for proposal in plan.proposals]
        text = f"for {theory} with a safe margin {', or '.join(words)}"
    else:
        text = f"no gap, release or clay gives {theory} in {variations.ENOUGH:.0%} of such trials"
        text += "; take harder bodies or a smaller mass ratio"
    if plan.camera is None or plan.camera.way == "seen":
        return text
    text += f"; film at {plan.framing.rate_needed_fps:.0f} frames a second"
    if plan.camera.way == "inferred":
        return f"{text} to see each collision, else count with --masses"
    return f"{text}, or take a smaller mass ratio or a larger gap"


def _proposal(request: PlanRequest, proposal: variations.Proposal) -> str:
    """Say a change as an instruction, with what comes of it."""
    value, heavy = proposal.value, plain(request.heavy)
    if proposal.change == "gap":
        text = f"hang the ball {_mm(value)} from the wall"
    elif proposal.change == "release":
        text = f"let the cylinder go from {_mm(value)}"
    elif value > 0:
        text = f"add {shortened(value, 3)} of clay to the cylinder's {heavy}"
    else:
        text = f"take {shortened(-value, 3)} off the cylinder's {heavy}"
    return f"{text} ({proposal.share:.0%} of trials, film at {proposal.rate_needed_fps:.0f}/s)"


def table_lines(table: variations.TrialTable | None) -> list[str]:
    """Write the table of trials, as that of a campaign; no line where there is none."""
    if table is None:
        return []
    lines = paper_lines(table, (str(table.theory), ""))
    return [*(entry(*line) for line in lines), *histogram_lines(table.histogram, [table.theory])]


def _mm(length_m: float) -> str:
    return f"{shortened(1e3 * length_m, 3)} mm"


def plain(mass: Mass) -> str:
    """Write a mass or a ratio of masses without needless digits."""
    return f"{float(mass):.10g}"


# ---- the theory alone ------------------------------------------------------------------------


def theory_text(heavy: Fraction, light: Fraction) -> str:
    """Write count, angles and bounds on pi as plain text, then the table for 1:100^n."""
    theory = theory_of(heavy, light)
    count, bounds, ratios = theory.count, theory.pi_bounds, theory.same_count
    angles = (theory.theta_rad, 2 * theory.theta_rad)
    theta, alpha = (f"{angle:.10g} rad ({math.degrees(angle):.6g}°)" for angle in angles)
    facts = {
        "Mass ratio": f"M : m = {plain(heavy / light)} : 1",
        "Exact count": f"{count} = ⌈π/θ⌉ − 1",
        "θ": f"{theta} = arctan √(m/M)",
        "α = 2θ": f"{alpha} = arccos((M − m)/(M + m))",
        "Interval of π": f"{bounds.low:.10g} to {bounds.high:.10g}, {count} θ to {count + 1} θ",
        "Same count": f"for M/m above {ratios.low:.10g} up to {ratios.high:.10g}",
    }
    lines = [f"{plain(heavy)} and {plain(light)}: {plural(count, 'collision')}", ""]
    lines += [f"  {label:<15}{words}" for label, words in facts.items()]
    lines += ["", "  m : M = 1 : 100^n", "    n  collisions  pi lies between"]
    for power in range(8):
        count, decimals = collision_count(100**power), power + 2
        bounds, unit = pi_bounds(count, 100**power), 10**decimals
        # Rounded outward, so that what is printed still holds pi between it.
        low, high = math.floor(bounds.low * unit) / unit, math.ceil(bounds.high * unit) / unit
        lines.append(f"    {power}{count:>12}  {low:.{decimals}f} and {high:.{decimals}f}")
    return "\n".join(lines)

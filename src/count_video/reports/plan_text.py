"""A plan for a person: the count first, then what the camera sees, how sure it is, what to change.

The sentences are here alone; terminal and page show the same. The theory of two masses, which needs
no set-up, stands below.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from fractions import Fraction

from count_video.physics.theory import Mass, collision_count, pi_bounds, theory_of
from count_video.planning.plan import PICTURE_WIDTH_PX, CameraView, Plan
from count_video.planning.request import PlanRequest
from count_video.planning.spread import (
    ENOUGH,
    RESOLVED_FRAMES,
    Proposal,
    Spread,
    TrialTable,
    restitution_range,
)
from count_video.reports.campaign import entry, histogram_lines, paper_lines
from count_video.reports.words import WIDTH, Note, answer_text, percent, plural

LISTED_AT_MOST = 5
"""Where there are more counts than this, only their range is given."""
RARE = 0.005
"""Counts that fewer trials have are not listed."""
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
    return [
        ("Theory", _theory(plan)),
        ("Kinds", _kinds(plan)),
        ("Shortest", _shortest(plan)),
        ("Last", _last(plan)),
        ("Burst", _burst(plan)),
        ("Camera", _camera(plan)),
        ("Film at", _film_at(plan)),
        ("Picture", _picture(plan)),
        ("How sure", _how_sure(plan)),
        ("A table", _a_table(plan.spread)),
        ("Change", change_words(plan)),
    ]


def table_lines(table: TrialTable | None) -> list[str]:
    """Write the table of trials, as that of a campaign; no line where there is none."""
    if table is None:
        return []
    counted = ("with a count", len(table.counts))
    lines = paper_lines(table, counted, (str(table.theory), ""))
    return [*(entry(*line) for line in lines), *histogram_lines(table.histogram, [table.theory])]


def proposal_words(request: PlanRequest, proposal: Proposal) -> str:
    """Say a change as an instruction, with what comes of it."""
    effect = f"({proposal.share:.0%} of trials, film at {proposal.rate_needed_fps:.0f}/s)"
    if proposal.change == "gap":
        return f"hang the ball {_mm(proposal.value)} from the wall {effect}"
    if proposal.change == "release":
        return f"let the cylinder go from {_mm(proposal.value)} {effect}"
    amount, heavy = f"{abs(proposal.value):.3g}", plain(request.heavy)
    if proposal.value > 0:
        return f"add {amount} of clay to the cylinder's {heavy} {effect}"
    return f"take {amount} off the cylinder's {heavy} {effect}"


def _theory(plan: Plan) -> str:
    burst = plan.burst
    same = "the same as here" if burst.count == burst.theory else f"{burst.count} here"
    return f"{burst.theory} for free bodies without losses; {same}"


def _kinds(plan: Plan) -> str:
    burst = plan.burst
    return f"{burst.bodies} between the bodies, {burst.count - burst.bodies} with the wall"


def _shortest(plan: Plan) -> str:
    shortest = plan.burst.shortest_s
    if math.isinf(shortest):
        return "there is one collision alone"
    duration = f"{1e3 * shortest:.3g} ms" if shortest < 1.0 else f"{shortest:.3g} s"
    return f"{duration} from one collision to the next where they follow each other fastest"


def _last(plan: Plan) -> str:
    burst = plan.burst
    where = "at the wall" if burst.last_m == 0 else f"{_mm(burst.last_m)} from the wall"
    return f"with the ball {where}, where the two close in at {1e3 * burst.last_speed_m_s:.3g} mm/s"


def _burst(plan: Plan) -> str:
    burst = plan.burst
    text = (
        f"from {burst.first_s:.2f} s to {burst.last_s:.2f} s after the release "
        f"({burst.last_s - burst.first_s:.2f} s)"
    )
    if math.isinf(burst.turn_s):
        return f"{text}; the cylinder does not turn round"
    return (
        f"{text}; the cylinder turns round at {burst.turn_s:.2f} s, {_mm(burst.swing_back_m)} "
        "beyond its rest: let the camera run from before the release until then"
    )


def _camera(plan: Plan) -> str:
    camera = plan.camera
    if camera is None:
        return "no rate given (--capture-fps)"
    text = f"{camera.capture_fps:g} frames a second: {camera_words(camera)}"
    if camera.way == "not measured":
        return text
    return f"{text}; {_measured(camera)}"


def camera_words(camera: CameraView) -> str:
    """Say what the frames show, and what is inferred."""
    if camera.way == "seen":
        return "the frames show every collision"
    close = (
        f"{plural(camera.close, 'collision')} closer than {RESOLVED_FRAMES:g} frames to the one "
        f"before, {camera.shortest_frames:.2g} at the closest"
    )
    if camera.way == "inferred":
        return f"{close}; these are inferred"
    return f"{close}; whether such a clip is counted was never measured"


def _measured(camera: CameraView) -> str:
    measured = camera.measured
    if measured is None:
        return ""
    text = f"counted exactly with a chance of {percent(measured.chance)} (of {measured.clips} "
    return f"{text}{measured.kind} {measured.exact} were, {measured.wrong or 'none'} wrongly)"


def _film_at(plan: Plan) -> str:
    return f"{plan.framing.rate_needed_fps:.0f} frames a second to see each collision"


def _picture(plan: Plan) -> str:
    framing = plan.framing
    least = math.ceil(framing.ball_at_least_px)
    better = f", better {GOOD_BALL_PX}" if least < GOOD_BALL_PX else ""
    text = f"the ball at least {least} px across{better}"
    if not math.isfinite(framing.smallest_hop_px):
        return text
    return (
        f"{text}; in a picture {PICTURE_WIDTH_PX} px wide at most "
        f"{framing.ball_at_most_px:.0f} px, and then the ball's smallest hop is "
        f"{framing.smallest_hop_px:.3g} px"
    )


def _how_sure(plan: Plan) -> str:
    spread, off = plan.spread, plan.request.tolerances
    text = f"{_counts(spread.histogram, spread.trials)} of {spread.trials} simulated trials"
    if spread.endless_share:
        text += f"; in {spread.endless_share:.0%} the ball rattles to rest and nothing is counted"
    low, high = restitution_range(plan.request)
    return (
        f"{text}, with gaps +-{_mm(off.gap_m)}, releases +-{_mm(off.release_m)}, masses "
        f"+-{100 * off.mass:g}%, threads +-{_mm(off.thread_m)} (standard deviations) and "
        f"restitutions from {low:.3g} to {high:.3g} that scatter by {off.scatter:g}"
    )


def _counts(histogram: Mapping[int, int], trials: int) -> str:
    shares = {count: number / trials for count, number in histogram.items()}
    listed = {count: share for count, share in shares.items() if share >= RARE}
    if not listed:
        return "no count stands out" if shares else "no count at all"
    if len(listed) > LISTED_AT_MOST:
        return f"counts from {min(listed)} to {max(listed)} in most"
    ordered = sorted(listed.items(), key=lambda item: -item[1])
    return ", ".join(f"{count} in {share:.0%}" for count, share in ordered)


def _a_table(spread: Spread) -> str:
    (low, high), (least, most) = spread.table_mean, spread.table_sd
    if math.isnan(low):
        return "has no counts"
    return (
        f"of {spread.table_trials} such trials has a mean of {low:.2f} to {high:.2f} and a "
        f"standard deviation of {least:.2f} to {most:.2f} (95 in 100 tables)"
    )


def change_words(plan: Plan) -> str:
    """Say what to change for the theory's count with a safe margin, and for the camera."""
    spread, theory = plan.spread, plan.burst.theory
    words = [proposal_words(plan.request, proposal) for proposal in plan.proposals]
    if spread.theory_share >= ENOUGH:
        text = f"nothing, it gives {theory} with a safe margin"
    elif words:
        text = f"for {theory} with a safe margin {', or '.join(words)}"
    else:
        text = f"no gap, release or clay gives {theory} in {ENOUGH:.0%} of such trials"
        text += "; take harder bodies or a smaller mass ratio"
    return f"{text}{_camera_change(plan)}"


def _camera_change(plan: Plan) -> str:
    if plan.camera is None or plan.camera.way == "seen":
        return ""
    needed = f"{plan.framing.rate_needed_fps:.0f} frames a second"
    if plan.camera.way == "inferred":
        return f"; film at {needed} to see each collision, else count with --masses"
    return f"; film at {needed}, or take a smaller mass ratio or a larger gap"


def _mm(length_m: float) -> str:
    return f"{1e3 * length_m:.3g} mm"


def plain(mass: Mass) -> str:
    """Write a mass or a ratio of masses without needless digits."""
    return f"{float(mass):.10g}"


# ---- the theory alone ------------------------------------------------------------------------

POWERS = range(8)
"""Exponents n of the table for 1:100^n."""


def theory_text(heavy: Fraction, light: Fraction) -> str:
    """Write count, angles and bounds on pi as plain text, then the table for 1:100^n."""
    count = plural(collision_count(heavy, light), "collision")
    lines = [f"{plain(heavy)} and {plain(light)}: {count}", ""]
    lines += [f"  {label:<15}{words}" for label, words in facts(heavy, light)]
    lines += ["", "  m : M = 1 : 100^n", "    n  collisions  pi lies between"]
    lines += [
        f"    {power}{count:>12}  {low} and {high}" for power, count, low, high in powers_table()
    ]
    return "\n".join(lines)


def facts(heavy: Fraction, light: Fraction) -> list[tuple[str, str]]:
    """Label and words of all that the theory says of two masses."""
    theory = theory_of(heavy, light)
    theta, count = theory.theta_rad, theory.count
    bounds, ratios = theory.pi_bounds, theory.same_count
    return [
        ("Mass ratio", f"M : m = {plain(heavy / light)} : 1"),
        ("Exact count", f"{count} = ⌈π/θ⌉ − 1"),
        ("θ", f"{_angle(theta)} = arctan √(m/M)"),
        ("α = 2θ", f"{_angle(2 * theta)} = arccos((M − m)/(M + m))"),
        ("Interval of π", f"{bounds.low:.10g} to {bounds.high:.10g}, {count} θ to {count + 1} θ"),
        ("Same count", f"for M/m above {ratios.low:.10g} up to {ratios.high:.10g}"),
    ]


def powers_table() -> list[tuple[int, int, str, str]]:
    """Rows of n, count and bounds on pi for the mass ratios 1:100^n."""
    rows = []
    for power in POWERS:
        heavy = 100**power
        count = collision_count(heavy)
        bounds = pi_bounds(count, heavy)
        decimals = power + 2
        # Rounded outward, so that what is printed still holds pi between it.
        low = math.floor(bounds.low * 10**decimals) / 10**decimals
        high = math.ceil(bounds.high * 10**decimals) / 10**decimals
        rows.append((power, count, f"{low:.{decimals}f}", f"{high:.{decimals}f}"))
    return rows


def _angle(radians: float) -> str:
    return f"{radians:.10g} rad ({math.degrees(radians):.6g}°)"

"""What a plan says, against the simulator and the published figures."""

from __future__ import annotations

import math
import subprocess
import sys
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

import count_video
from count_video.errors import UsageError
from count_video.physics.setup import Setup
from count_video.physics.simulator import NO_COUNT, simulate
from count_video.physics.theory import collision_count
from count_video.planning.plan import Plan, make_plan
from count_video.planning.request import PlanRequest, Tolerances
from count_video.planning.variations import (
    ENOUGH,
    adjustments_of,
    changed,
    chart_of,
    shares_of,
    spread_of,
    table_of,
)
from count_video.reports.plan_text import plan_notes

PAPER = PlanRequest(1050, 10.5, capture_fps=240.0)
STEEL = Tolerances(restitution=0.0, scatter=0.0)
CELLS = 40
CHECK_TRIALS = 1500
SAMPLING_SIGMAS = 4.0


@pytest.fixture(scope="module")
def plan() -> Plan:
    return make_plan(PAPER)


@pytest.mark.parametrize(("gap_m", "count"), [(0.03, 31), (0.04, 30), (0.05, 29), (0.07, 27)])
def test_the_papers_bodies_count_what_is_known_of_them(gap_m: float, count: int) -> None:
    planned = make_plan(replace(PAPER, gap_m=gap_m), with_table=False, with_chart=False)
    assert (planned.burst.count, planned.burst.theory) == (count, 31)


def test_the_answer_is_that_of_the_simulated_trial(plan: Plan) -> None:
    motion = simulate(Setup(wall_gap_m=0.03))  # the paper's masses, threads and release
    times = [bounce.time_s for bounce in motion.burst]
    burst = plan.burst
    assert burst.count == motion.count
    assert burst.bodies == sum(bounce.kind == "bodies" for bounce in motion.burst)
    assert burst.shortest_s == pytest.approx(min(b - a for a, b in pairwise(times)))
    assert (burst.first_s, burst.last_s) == pytest.approx((times[0], times[-1]))
    assert burst.turn_s == pytest.approx(motion.burst_end_s)
    turned = motion.sample(np.array([burst.turn_s]))
    assert turned.heavy_velocity_m_s[0] == pytest.approx(0.0, abs=1e-9)
    assert burst.swing_back_m == pytest.approx(turned.heavy_face_m[0] - motion.setup.heavy_rest_m)
    last = motion.burst[-1]
    assert burst.last_speed_m_s == pytest.approx(last.light_before_m_s - last.heavy_before_m_s)


def test_lossless_bodies_swing_back_nearly_as_far_as_they_came(plan: Plan) -> None:
    # What is missing is the energy that the ball has in the end.
    assert 0.95 * PAPER.release_m < plan.burst.swing_back_m <= PAPER.release_m


def test_the_needed_rate_shows_every_collision_and_a_slower_one_does_not(plan: Plan) -> None:
    needed = plan.framing.rate_needed_fps
    enough = make_plan(replace(PAPER, capture_fps=needed), with_table=False, with_chart=False)
    less = make_plan(replace(PAPER, capture_fps=needed - 20), with_table=False, with_chart=False)
    assert enough.camera is not None
    assert less.camera is not None
    assert (enough.camera.way, enough.camera.close) == ("seen", 0)
    assert less.camera.way == "inferred"
    assert less.camera.close > 0


def test_without_a_rate_nothing_is_said_of_a_camera() -> None:
    assert make_plan(PlanRequest(16, 1), with_table=False, with_chart=False).camera is None


def test_thirty_trials_of_the_paper_have_a_mean_like_its_table() -> None:
    tables = [table_of(replace(PAPER, seed=seed), 31) for seed in range(20)]
    means = [table.mean for table in tables]
    assert all(mean is not None and 29.5 <= mean <= 31 for mean in means)
    assert len(set(means)) > 1


def test_a_table_is_like_the_distribution_it_is_drawn_from(plan: Plan) -> None:
    spread = plan.spread
    trials = 3000
    table = table_of(replace(PAPER, trials=trials), 31)
    assert table.mean is not None
    off = SAMPLING_SIGMAS * spread.sd * math.sqrt(1 / trials + 1 / spread.trials)
    assert abs(table.mean - spread.mean) <= off
    assert spread.table_mean[0] < spread.mean < spread.table_mean[1]


def test_the_same_seed_gives_the_same_trials_and_another_gives_others() -> None:
    assert table_of(PAPER, 31) == table_of(PAPER, 31)
    assert table_of(PAPER, 31).counts != table_of(replace(PAPER, seed=1), 31).counts


def test_hands_that_never_err_repeat_the_same_trial() -> None:
    never = Tolerances(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    table = table_of(replace(PAPER, tolerances=never), 31)
    assert table.histogram == {31: PAPER.trials}
    assert table.sd_population == 0.0


def test_what_is_proposed_gives_the_theorys_count_with_a_margin() -> None:
    for gap_m in (0.03, 0.04, 0.05):
        planned = make_plan(replace(PAPER, gap_m=gap_m), with_table=False, with_chart=False)
        assert {proposal.change for proposal in planned.proposals} >= {"gap", "release"}
        for proposal in planned.proposals:
            better = replace(changed(planned.request, proposal.change, proposal.value), seed=99)
            assert simulate(better.setup()).count == 31
            assert collision_count(better.heavy, better.light) == 31
            (share,) = shares_of([better], 31, CHECK_TRIALS)
            # A share of one in twenty, of a hundred trials, is known to this much.
            assert share >= ENOUGH - SAMPLING_SIGMAS * math.sqrt(ENOUGH * (1 - ENOUGH) / 100)


def test_no_clay_is_proposed_that_no_mass_could_have() -> None:
    heaviest = PlanRequest(10**100, 10**98, gap_m=0.05)
    planned = make_plan(heaviest, with_table=False, with_chart=False)
    clay = [one.value for one in planned.proposals if one.change == "heavy mass"]
    assert planned.proposals
    assert all(value < 0 for value in clay)


def test_a_set_up_with_a_margin_is_left_alone() -> None:
    planned = make_plan(PlanRequest(16, 1), with_table=False, with_chart=False)
    assert planned.spread.theory_share >= ENOUGH
    assert planned.proposals == ()


def test_losses_that_squeeze_the_ball_to_rest_are_named_as_such() -> None:
    spread = spread_of(PlanRequest(10_000, 1), 314)
    assert spread.endless_share > 0.5
    hard = spread_of(PlanRequest(10_000, 1, tolerances=STEEL), 314)
    assert hard.endless_share == 0.0


@pytest.mark.parametrize(
    ("histogram", "share", "said"),
    [
        ({}, 1.0, "none of 251 simulated trials has a count; in each the ball rattles to rest"),
        ({1400: 2}, 0.99, "2 of 251 simulated trials have a count; in the others the ball rattles"),
        (dict.fromkeys(range(251), 1), 0.0, "no count in 0.5% or more of 251 simulated trials"),
    ],
)
def test_a_plan_promises_no_table_of_trials_that_mostly_have_no_count(
    plan: Plan, histogram: dict[int, int], share: float, said: str
) -> None:
    spread = replace(plan.spread, trials=251, histogram=histogram, endless_share=share)
    notes = dict(plan_notes(replace(plan, spread=spread)))
    assert notes["How sure"].startswith(said)
    assert ("A table" in notes) == (share < 0.5)


def test_a_picture_that_cannot_show_the_smallest_hop_is_not_asked_for(plan: Plan) -> None:
    framing = replace(plan.framing, ball_at_least_px=2000.0, ball_at_most_px=1038.0)
    words = dict(plan_notes(replace(plan, framing=framing)))["Picture"]
    assert words.startswith("none that is 1920 px wide shows it: the ball must be at least 2000 px")


def test_the_map_is_the_simulator_at_every_cell(plan: Plan) -> None:
    chart = plan.chart
    assert chart is not None
    first, last = chart[0, 0], chart[-1, -1]
    assert (first["gap_m"], first["release_m"]) == pytest.approx((0.005, 0.02))
    assert (last["gap_m"], last["release_m"]) == pytest.approx((0.1, 0.2))
    rng = np.random.default_rng(4)
    for _ in range(CELLS):
        cell = rng.choice(chart.ravel())
        gap_m, release_m = float(cell["gap_m"]), float(cell["release_m"])
        if gap_m > release_m:
            assert np.isnan(cell["count"])
            continue
        motion = simulate(Setup(wall_gap_m=gap_m, release_m=release_m))
        assert cell["count"] == motion.count
        times = [bounce.time_s for bounce in motion.burst]
        shortest = min(b - a for a, b in pairwise(times))
        assert cell["shortest_s"] == pytest.approx(shortest, rel=1e-6)


def test_a_map_of_many_collisions_has_larger_cells() -> None:
    coarse = chart_of(PlanRequest(200_000, 1), collision_count(200_000))
    assert coarse.size < chart_of(PAPER, 31).size
    assert coarse["gap_m"][0, [0, -1]] == pytest.approx([0.005, 0.1])


def test_the_table_of_adjustments_is_the_simulator_at_any_scale() -> None:
    request = PlanRequest(1050, 10.5, 0.025, 0.11, light_thread_m=0.8, restitution=0.99)
    table = adjustments_of(request, 31)
    assert 1.0 in table["heavy_share"]
    assert request.gap_m / request.release_m in table["gap_share"]
    rng = np.random.default_rng(5)
    for _ in range(CELLS):
        row, column = rng.integers(len(table["heavy_share"])), rng.integers(len(table["gap_share"]))
        heavy, release_m = 1050 * table["heavy_share"][row], rng.uniform(0.02, 0.2)
        gap_m = release_m * table["gap_share"][column]
        one = replace(request, heavy=heavy, gap_m=gap_m, release_m=release_m)
        motion = simulate(one.setup())
        assert table["count"][row, column] == motion.count
        assert table["shortest_s"][row, column] == pytest.approx(motion.shortest_s, rel=1e-6)
        assert table["theory"][row] == collision_count(one.heavy, one.light)


def test_no_cylinder_lighter_than_the_ball_has_a_count() -> None:
    table = adjustments_of(PlanRequest(1, 1), 3)
    lighter = table["heavy_share"] < 1.0
    assert (table["count"][lighter] == NO_COUNT).all()
    assert (table["count"][~lighter] != NO_COUNT).all()


@pytest.mark.parametrize(
    "wrong",
    [
        {"gap_m": 0.0},
        {"gap_m": -0.03},
        {"gap_m": 0.1},
        {"gap_m": math.nan},
        {"release_m": -0.09},
        {"heavy_thread_m": 0.0},
        {"light_thread_m": math.inf},
        {"capture_fps": 0.0},
        {"capture_fps": -240.0},
        {"restitution": 1.01},
        {"restitution": -0.1},
        {"damping_per_s": -1.0},
        {"damping_per_s": 3.2},
        {"heavy": 10.0},
        {"heavy": 0},
        {"light": -1},
        {"light": 1e-6},
        {"ball_diameter_m": 0.0},
        {"trials": 1},
        {"trials": 10**6},
        {"seed": -1},
    ],
)
def test_nonsense_gets_one_clear_line(wrong: dict[str, float]) -> None:
    with pytest.raises(UsageError) as refusal:
        replace(PAPER, **wrong)  # type: ignore[arg-type]
    assert str(refusal.value).splitlines() == [str(refusal.value)]


@pytest.mark.parametrize(
    "wrong", [{"gap_m": -0.001}, {"mass": 1.5}, {"scatter": math.nan}, {"restitution": 2.0}]
)
def test_impossible_tolerances_get_one_clear_line(wrong: dict[str, float]) -> None:
    with pytest.raises(UsageError, match=next(iter(wrong))):
        Tolerances(**wrong)


def test_another_program_gets_the_same_plan(plan: Plan) -> None:
    asked = count_video.plan(1050, 10.5, capture_fps=240.0)
    assert asked.burst == plan.burst
    assert asked.spread == plan.spread
    assert asked.proposals == plan.proposals
    assert count_video.plan(1050, 10.5, chart=False).chart is None


def test_importing_the_package_imports_nothing_heavy() -> None:
    code = "import sys, count_video; print(sorted({'numpy', 'scipy', 'cv2'} & set(sys.modules)))"
    answer = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert answer.stdout.strip() == "[]"

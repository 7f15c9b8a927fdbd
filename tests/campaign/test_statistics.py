from __future__ import annotations

import math
from collections.abc import Iterator
from statistics import pstdev, stdev

import pytest
from hypothesis import given
from hypothesis import strategies as st
from table_rows import row, rows_of

from count_video.campaign.statistics import summarise
from count_video.reports.campaign_rows import Spread

PAPER = {31: 22, 30: 4, 29: 3, 28: 1}
ROUNDING = 1e-12
"""Of sums of some thirty floats of size 31 at most."""


def tables_with_the_papers_range() -> Iterator[dict[int, int]]:
    """All ways to share 30 trials out over the counts 28 to 31, both ends taken."""
    for lowest in range(1, 30):
        for low in range(30 - lowest):
            for high in range(30 - lowest - low):
                yield {28: lowest, 29: low, 30: high, 31: 30 - lowest - low - high}


def counts_in(table: dict[int, int]) -> list[int]:
    return [count for count, many in table.items() for _ in range(many)]


def tables_that_print_like_the_paper(deviation: object) -> list[dict[int, int]]:
    assert callable(deviation)
    return [
        table
        for table in tables_with_the_papers_range()
        if f"{sum(counts_in(table)) / 30:.2f}" == "30.57"
        and f"{deviation(counts_in(table)):.2f}" == "0.80"
    ]


def test_the_papers_figures_fit_a_population_deviation_and_two_tables_only() -> None:
    assert tables_that_print_like_the_paper(pstdev) == [
        {28: 1, 29: 3, 30: 4, 31: 22},
        {28: 2, 29: 0, 30: 7, 31: 21},
    ]


def test_no_table_fits_the_papers_figures_with_a_sample_deviation() -> None:
    assert tables_that_print_like_the_paper(stdev) == []


def test_the_summary_of_such_counts_is_the_papers_table() -> None:
    summary = summarise(rows_of(PAPER))
    assert (summary.trials, summary.counted) == (30, 30)
    assert (summary.maximum, summary.minimum) == (31, 28)
    assert summary.mean == pytest.approx(917 / 30, abs=31 * ROUNDING)
    assert f"{summary.sd_population:.2f} {summary.sd_sample:.2f}" == "0.80 0.82"
    assert summary.histogram == {28: 1, 29: 3, 30: 4, 31: 22}


@given(st.lists(st.integers(0, 400), min_size=2, max_size=40))
def test_the_two_deviations_differ_by_the_root_of_n_over_n_less_1(counts: list[int]) -> None:
    summary = summarise([row(str(k), count) for k, count in enumerate(counts)])
    assert summary.sd_population is not None
    assert summary.sd_sample is not None
    n = len(counts)
    assert summary.sd_sample == pytest.approx(
        summary.sd_population * math.sqrt(n / (n - 1)), rel=ROUNDING
    )


def test_only_counted_trials_enter_the_figures() -> None:
    summary = summarise([row("a", 31), row("b", None), row("c", 29)])
    assert (summary.trials, summary.counted, summary.mean) == (3, 2, 30.0)


def test_without_a_count_there_are_no_figures() -> None:
    summary = summarise([row("a", None, mass_ratio=None)])
    assert (summary.trials, summary.counted) == (1, 0)
    assert summary.maximum is summary.mean is summary.sd_population is summary.theory is None
    assert summarise([]).trials == 0


def test_a_single_count_has_no_sample_deviation() -> None:
    summary = summarise([row()])
    assert (summary.sd_population, summary.sd_sample) == (0.0, None)


def test_sure_counts_leave_the_mean_no_uncertainty() -> None:
    assert summarise(rows_of(PAPER)).mean_uncertainty == 0.0


def test_doubts_that_lean_to_no_side_add_up_as_variances() -> None:
    rows = [row(str(k), 31, chances={30: 0.1, 31: 0.8, 32: 0.1}) for k in range(4)]
    summary = summarise(rows)
    # Each count has the variance 0.2; the mean of 4 has 0.2 / 4.
    assert summary.mean_uncertainty == pytest.approx(math.sqrt(0.05), rel=ROUNDING)
    assert summary.mean_expected == pytest.approx(31, rel=ROUNDING)


def test_doubts_that_lean_to_one_side_add_up_as_they_are() -> None:
    rows = [row(str(k), 31, chances={30: 0.5, 31: 0.5}) for k in range(100)]
    summary = summarise(rows)
    # Off by a half each, all the same way, beside the variance of a quarter each.
    assert summary.mean_uncertainty == pytest.approx(math.hypot(0.5, 0.05), rel=ROUNDING)
    assert summary.mean_expected == pytest.approx(30.5, rel=ROUNDING)


def test_probabilities_that_are_cut_off_are_taken_as_shares() -> None:
    whole = summarise([row(chances={30: 0.25, 31: 0.75})])
    part = summarise([row(chances={30: 0.2, 31: 0.6})])
    assert part.mean_expected == pytest.approx(whole.mean_expected, rel=ROUNDING)


def test_the_theory_is_that_of_the_masses_given() -> None:
    summary = summarise([row("a", theory=31, mass_ratio=90.0), row("b", None, theory=31)])
    assert (summary.theory, summary.theory_source) == (31, "masses")


def test_trials_of_different_masses_have_no_theory_in_common() -> None:
    summary = summarise([row("a", theory=31), row("b", theory=12)])
    assert (summary.theory, summary.theory_source) == (None, None)


def test_without_masses_the_theory_is_that_of_the_middle_measured_ratio() -> None:
    rows = [row(str(k), mass_ratio=ratio) for k, ratio in enumerate((99.0, 100.5, 100.0, 20.0))]
    assert (summarise(rows).theory, summarise(rows).theory_source) == (31, "measured")


def test_measured_ratios_of_different_bodies_have_no_theory_in_common() -> None:
    rows = [row(str(k), mass_ratio=16.0 + 3 * k) for k in range(6)]
    assert summarise(rows).theory is None


def test_what_the_physics_tells_is_averaged_over_those_that_tell_it() -> None:
    rows = [
        row("a", restitution_wall=0.98, ending="geometric"),
        row("b", restitution_wall=0.96, ending="dissipative"),
        row("c"),
    ]
    summary = summarise(rows)
    assert summary.restitution_wall is not None
    assert summary.restitution_wall == Spread(
        2,
        pytest.approx(0.97),
        pytest.approx(0.01),  # type: ignore[arg-type]
    )
    assert summary.restitution_bodies is summary.energy_kept is None
    assert summary.geometric_share == 0.5

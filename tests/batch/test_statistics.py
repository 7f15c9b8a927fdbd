from __future__ import annotations

import json
import math
from collections.abc import Iterator, Sequence
from fractions import Fraction
from statistics import pstdev, stdev

import pytest
from hypothesis import given
from hypothesis import strategies as st

from count_video.batch.summary import summarise
from count_video.records import Estimate
from count_video.reports.campaign import Spread, Summary, TrialRow, campaign_text
from count_video.reports.exports import campaign_json
from table_rows import row, rows_of

PAPER = {31: 22, 30: 4, 29: 3, 28: 1}
ROUNDING = 1e-12
"""Of sums of some thirty floats of size 31 at most."""
HUNDRED = (Fraction(100), Fraction(1))
SIXTEEN = (Fraction(16), Fraction(1))


def whole(rows: Sequence[TrialRow]) -> Summary:
    return summarise(rows).whole


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
    summary = whole(rows_of(PAPER))
    assert (summary.trials, summary.counted) == (30, 30)
    assert (summary.maximum, summary.minimum) == (31, 28)
    assert summary.mean == pytest.approx(917 / 30, abs=31 * ROUNDING)
    assert f"{summary.sd_population:.2f} {summary.sd_sample:.2f}" == "0.80 0.82"
    assert summary.histogram == {28: 1, 29: 3, 30: 4, 31: 22}


@given(st.lists(st.integers(0, 400), min_size=2, max_size=40))
def test_the_two_deviations_differ_by_the_root_of_n_over_n_less_1(counts: list[int]) -> None:
    summary = whole([row(str(k), count) for k, count in enumerate(counts)])
    assert summary.sd_population is not None
    assert summary.sd_sample is not None
    n = len(counts)
    assert summary.sd_sample == pytest.approx(
        summary.sd_population * math.sqrt(n / (n - 1)), rel=ROUNDING
    )


def test_only_counted_trials_enter_the_figures() -> None:
    summary = whole([row("a", 31), row("b", None), row("c", 29)])
    assert (summary.trials, summary.counted, summary.mean) == (3, 2, 30.0)


def test_without_a_count_there_are_no_figures() -> None:
    summary = whole([row("a", None)])
    assert (summary.trials, summary.counted) == (1, 0)
    assert summary.maximum is summary.mean is summary.sd_population is summary.theory is None
    assert whole([]).trials == 0


def test_a_single_count_has_no_sample_deviation() -> None:
    summary = whole([row()])
    assert (summary.sd_population, summary.sd_sample) == (0.0, None)


def test_sure_counts_leave_the_mean_no_uncertainty() -> None:
    assert whole(rows_of(PAPER)).mean_uncertainty == 0.0


def test_doubts_that_lean_to_no_side_add_up_as_variances() -> None:
    rows = [row(str(k), 31, probability={30: 0.1, 31: 0.8, 32: 0.1}) for k in range(4)]
    summary = whole(rows)
    # Each count has the variance 0.2; the mean of 4 has 0.2 / 4.
    assert summary.mean_uncertainty == pytest.approx(math.sqrt(0.05), rel=ROUNDING)
    assert summary.mean_expected == pytest.approx(31, rel=ROUNDING)


def test_doubts_that_lean_to_one_side_add_up_as_they_are() -> None:
    rows = [row(str(k), 31, probability={30: 0.5, 31: 0.5}) for k in range(100)]
    summary = whole(rows)
    # Off by a half each, all the same way, beside the variance of a quarter each.
    assert summary.mean_uncertainty == pytest.approx(math.hypot(0.5, 0.05), rel=ROUNDING)
    assert summary.mean_expected == pytest.approx(30.5, rel=ROUNDING)


def test_probabilities_that_are_cut_off_are_taken_as_shares() -> None:
    every = whole([row(probability={30: 0.25, 31: 0.75})])
    part = whole([row(probability={30: 0.2, 31: 0.6})])
    assert part.mean_expected == pytest.approx(every.mean_expected, rel=ROUNDING)


def test_the_theory_is_that_of_the_masses_given() -> None:
    summary = whole([row("a", masses=HUNDRED, mass_ratio=90.0), row("b", None, masses=HUNDRED)])
    assert (summary.theory, summary.theory_source) == (31, "masses")


def test_trials_of_different_masses_are_summed_up_apart() -> None:
    rows = [
        row("a", 31, masses=HUNDRED),
        row("b", 12, masses=SIXTEEN),
        row("c", 30, masses=HUNDRED),
    ]
    summary = summarise(rows)
    assert (summary.whole.theory, summary.whole.trials) == (None, 3)
    light, heavy = summary.groups
    assert (light.theory, light.mean, light.trials) == (12, 12.0, 1)
    assert (heavy.theory, heavy.mean, heavy.trials) == (31, 30.5, 2)
    text = campaign_text(rows, summary)
    assert text.index("Mass ratio 16") < text.index("Mass ratio 100")
    assert [group["theory"] for group in json.loads(campaign_json(rows, summary))["groups"]] == [
        12,
        31,
    ]


def test_trials_of_one_mass_ratio_are_one_group() -> None:
    summary = summarise(rows_of(PAPER))
    assert summary.groups == (summary.whole,)
    assert "Mass ratio 1" not in campaign_text(rows_of(PAPER), summary)


def test_without_masses_the_theory_is_that_of_the_mean_measured_ratio() -> None:
    rows = [row(str(k), mass_ratio=ratio) for k, ratio in enumerate((99.0, 100.5, 100.0))]
    summary = whole(rows)
    assert (summary.theory, summary.theory_source) == (31, "measured")
    assert summary.mass_ratio == Estimate(
        pytest.approx(99.0 / 3 + 200.5 / 3, rel=ROUNDING),  # type: ignore[arg-type]
        pytest.approx(1 / math.sqrt(3), rel=ROUNDING),  # type: ignore[arg-type]
    )


def test_measured_ratios_that_differ_by_more_than_their_uncertainty_are_of_other_bodies() -> None:
    rows = [row(str(k), mass_ratio=16.0 + 3 * k, mass_ratio_sigma=0.2) for k in range(6)]
    assert len(summarise(rows).groups) == 6


def test_a_vague_ratio_joins_the_nearest_group_and_does_not_join_two() -> None:
    sure = [row("a", mass_ratio=16.0, mass_ratio_sigma=0.1), row("b", mass_ratio=100.0)]
    vague = row("c", mass_ratio=80.0, mass_ratio_sigma=60.0)
    light, heavy = summarise([vague, *sure]).groups
    assert (light.counted, heavy.counted) == (1, 2)


def test_an_uncertain_ratio_gives_all_counts_that_the_theory_may_have() -> None:
    rows = [row("a", 3, mass_ratio=1.001, mass_ratio_sigma=0.004)]
    summary = whole(rows)
    assert (summary.theory, summary.theory_low, summary.theory_high) == (None, 3, 4)
    assert "3 or 4" in campaign_text(rows, summarise(rows))


def test_ratios_that_scatter_more_than_they_say_are_not_taken_at_their_word() -> None:
    rows = [row(str(k), mass_ratio=100.0 + (-4) ** k, mass_ratio_sigma=2.0) for k in range(2)]
    ratio = whole(rows).mass_ratio
    assert ratio is not None
    # Two values 5 apart: their mean is uncertain by 5 / 2, not by 2 / sqrt(2).
    assert ratio.sigma == pytest.approx(2.5, rel=ROUNDING)


def test_what_the_physics_gives_is_averaged_over_those_that_give_it() -> None:
    rows = [
        row("a", restitution_wall=0.98, ending="geometric"),
        row("b", restitution_wall=0.96, ending="dissipative"),
        row("c"),
    ]
    summary = whole(rows)
    assert summary.restitution_wall is not None
    assert summary.restitution_wall == Spread(
        2,
        pytest.approx(0.97),
        pytest.approx(0.01),  # type: ignore[arg-type]
    )
    assert summary.restitution_bodies is summary.energy_kept is None
    assert summary.geometric_share == 0.5

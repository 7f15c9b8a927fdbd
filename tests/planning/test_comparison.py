"""A result held against its plan: what differs, and what explains the count."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from count_video.errors import UsageError
from count_video.physics.setup import Setup
from count_video.physics.simulator import simulate
from count_video.planning.comparison import compared
from count_video.planning.request import (
    PLAN_VERSION,
    PlanRequest,
    Tolerances,
    read_request,
    request_object,
)
from count_video.records import Estimate, FittedSetup, TrialResult
from count_video.reports.exports import json_object
from count_video.reports.text import comparison_lines, comparison_sentence, result_text

PLANNED = PlanRequest(1050, 10.5, gap_m=0.03, capture_fps=960.0)
PX_PER_MM, FPS = 2.0, 960.0
SIGMA_PX, SIGMA_FRAMES = 0.01, 0.5


def found(really: Setup, **changes: object) -> TrialResult:
    """Return the result of a clip of a set-up, fitted without an error."""

    def px(length_m: float) -> Estimate:
        return Estimate(1e3 * length_m * PX_PER_MM, SIGMA_PX)

    def period(thread_m: float) -> Estimate:
        natural = math.sqrt(really.gravity_m_s2 / thread_m)
        return Estimate(2 * math.pi / natural * FPS, SIGMA_FRAMES)

    result = TrialResult(
        clip="trial.mp4",
        status="counted",
        reason=None,
        count=simulate(really).count,
        seen=0,
        between_frames=0,
        probability={},
        count_after_burst=0,
        collisions=(),
        capture_fps=FPS,
        capture_fps_source="option",
        frames_decoded=None,
        frames_promised=None,
        wall_side="left",
        ball_diameter_px=1e3 * really.ball_diameter_m * PX_PER_MM,
        millimetres_per_px=1 / PX_PER_MM,
        pi_low=None,
        pi_high=None,
        mass_ratio=really.heavy_mass_kg / really.light_mass_kg,
        mass_ratio_sigma=0.1,
        restitution_bodies=Estimate(really.restitution_bodies, 0.001),
        restitution_wall=Estimate(really.restitution_wall, 0.001),
        setup=FittedSetup(
            gap_px=px(really.wall_gap_m),
            release_px=px(really.release_m),
            bodies_gap_px=px(really.bodies_gap_m),
            heavy_period_frames=period(really.heavy_thread_m),
            ball_period_frames=period(really.light_thread_m),
        ),
        warnings=(),
    )
    return replace(result, **changes)  # type: ignore[arg-type]


def test_a_clip_of_the_plan_itself_differs_in_nothing() -> None:
    comparison = compared(found(PLANNED.setup()), PLANNED).comparison
    assert comparison is not None
    assert len(comparison.quantities) == 8
    for one in comparison.quantities:
        assert one.found.value == pytest.approx(one.planned, abs=1e-9)
        assert one.count == 31
    counts = (comparison.planned_count, comparison.found_count, comparison.theory)
    assert counts == (31, 31, 31)
    assert comparison.explained_by == ()


@pytest.mark.parametrize(
    ("change", "name"),
    [
        ({"wall_gap_m": 0.05}, "gap_mm"),
        ({"release_m": 0.06}, "release_mm"),
        ({"heavy_mass_kg": 90.0}, "mass_ratio"),
    ],
)
def test_what_was_set_up_otherwise_explains_the_count(change: dict[str, float], name: str) -> None:
    really = replace(PLANNED.setup(), **change)  # type: ignore[arg-type]
    result = compared(found(really), PLANNED)
    comparison = result.comparison
    assert comparison is not None
    assert result.count != 31
    assert comparison.found_count == result.count
    assert comparison.explained_by[0] == name
    assert f"alone makes it {result.count}" in comparison_sentence(comparison, result.count)


def test_small_differences_may_explain_it_only_together() -> None:
    # Each keeps 31, both together give 30.
    really = replace(PLANNED.setup(), wall_gap_m=0.0304, release_m=0.0888)
    assert simulate(really).count == 30
    comparison = compared(found(really), PLANNED).comparison
    assert comparison is not None
    assert {one.count for one in comparison.quantities} == {31}
    assert len(comparison.explained_by) == 8
    assert "all differences together make it 30" in comparison_sentence(comparison, 30)


def test_the_scales_uncertainty_goes_into_that_of_a_length() -> None:
    comparison = compared(found(PLANNED.setup()), PLANNED).comparison
    assert comparison is not None
    by_name = {one.name: one.found for one in comparison.quantities}
    alone_mm = SIGMA_PX / PX_PER_MM
    assert by_name["release_mm"].sigma > 10 * alone_mm
    ratio = by_name["release_mm"].sigma / by_name["gap_mm"].sigma
    assert ratio == pytest.approx(3.0, rel=0.01)  # both are shares of the lengths, 90 and 30 mm
    assert by_name["bodies_gap_mm"].sigma == pytest.approx(alone_mm)


def test_what_is_not_known_is_left_out() -> None:
    unscaled = compared(found(PLANNED.setup(), millimetres_per_px=None), PLANNED).comparison
    timeless = compared(found(PLANNED.setup(), capture_fps=None), PLANNED).comparison
    nothing = compared(found(PLANNED.setup(), setup=None), PLANNED).comparison
    assert unscaled is not None
    assert timeless is not None
    assert nothing is not None
    assert not {one.name for one in unscaled.quantities} & {"gap_mm", "release_mm"}
    assert not {one.name for one in timeless.quantities} & {"heavy_period_s", "ball_period_s"}
    assert (nothing.quantities, nothing.found_count) == ((), None)


def test_a_set_up_that_cannot_be_is_not_counted() -> None:
    result = found(PLANNED.setup())
    assert result.setup is not None
    inside = replace(result.setup, bodies_gap_px=Estimate(-400.0, 1.0))
    comparison = compared(replace(result, setup=inside), PLANNED).comparison
    assert comparison is not None
    (bodies,) = [one for one in comparison.quantities if one.name == "bodies_gap_mm"]
    assert (bodies.count, comparison.found_count) == (None, None)
    (line,) = [text for text in comparison_lines(comparison) if "between the bodies" in text]
    assert line.split()[-2:] == ["-", "differs"]


def test_a_clip_without_a_count_is_compared_all_the_same() -> None:
    refused = found(PLANNED.setup(), status="not_counted", count=None, setup=None)
    comparison = compared(refused, PLANNED).comparison
    assert comparison is not None
    assert "not counted" in comparison_sentence(comparison, None)


def test_text_and_json_say_the_comparison() -> None:
    really = replace(PLANNED.setup(), wall_gap_m=0.05)
    result = compared(found(really), PLANNED)
    text = result_text(result)
    assert max(map(len, text.splitlines())) <= 80
    (line,) = [line for line in text.splitlines() if line.split()[:2] == ["gap,", "mm"]]
    assert line.split()[2:4] == ["30.0", "50.0"]
    assert line.endswith("29 differs")
    answers = json_object(result)["plan"]
    assert isinstance(answers, dict)
    assert (answers["planned_count"], answers["explained_by"]) == (31, ["gap_mm"])
    assert json_object(replace(result, comparison=None))["plan"] is None


def test_the_planned_count_by_another_set_up_is_said_to_be_so() -> None:
    as_planned = compared(found(PLANNED.setup()), PLANNED)
    assert comparison_sentence(as_planned.comparison, as_planned.count).endswith("as planned")
    nearer = replace(PLANNED.setup(), wall_gap_m=PLANNED.gap_m - 0.003)
    result = compared(found(nearer), PLANNED)
    assert result.count == result.comparison.planned_count  # type: ignore[union-attr]
    assert comparison_sentence(result.comparison, result.count).endswith("but not with this gap")


def write(path: Path, stored: object) -> Path:
    path.write_text(json.dumps(stored), "utf-8")
    return path


def test_a_stored_request_comes_back(tmp_path: Path) -> None:
    request = replace(PLANNED, tolerances=Tolerances(gap_m=0.002), light_thread_m=1.01, seed=3)
    stored = {"plan_version": PLAN_VERSION, "request": request_object(request), "count": 31}
    assert read_request(write(tmp_path / "plan.json", stored)) == replace(
        request, heavy=1050.0, light=10.5
    )


BROKEN: dict[str, Callable[[dict[str, object]], object]] = {
    "a list": lambda stored: [stored],
    "another version": lambda stored: {**stored, "plan_version": 2},
    "no request": lambda stored: {"plan_version": PLAN_VERSION},
    "a value of another kind": lambda stored: with_value(stored, gap_m="3 cm"),
    "true for a number": lambda stored: with_value(stored, gap_m=True),
    "nonsense": lambda stored: with_value(stored, gap_m=-1.0),
    "trials in parts": lambda stored: with_value(stored, trials=2.5),
    "something unknown": lambda stored: with_value(stored, colour=1.0),
    "tolerances of another kind": lambda stored: with_value(stored, tolerances=[1]),
    "no mass": lambda stored: {"plan_version": PLAN_VERSION, "request": {"heavy": 1.0}},
}


def with_value(stored: dict[str, object], **values: object) -> dict[str, object]:
    request = stored["request"]
    assert isinstance(request, dict)
    return {**stored, "request": {**request, **values}}


@pytest.mark.parametrize("breaks", BROKEN.values(), ids=BROKEN.keys())
def test_a_file_that_holds_no_plan_is_refused_in_one_line_that_names_it(
    breaks: Callable[[dict[str, object]], object], tmp_path: Path
) -> None:
    sound = {"plan_version": PLAN_VERSION, "request": request_object(PLANNED)}
    path = write(tmp_path / "plan.json", breaks(sound))
    with pytest.raises(UsageError) as refusal:
        read_request(path)
    assert str(path) in str(refusal.value)
    assert str(refusal.value).splitlines() == [str(refusal.value)]


@pytest.mark.parametrize("content", [b"", b"\xff\xfe", b"{", b"[" * 100_000])
def test_a_file_that_is_no_json_is_refused(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "plan.json"
    path.write_bytes(content)
    with pytest.raises(UsageError, match=r"plan\.json"):
        read_request(path)


def test_a_file_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="cannot be read"):
        read_request(tmp_path / "plan.json")

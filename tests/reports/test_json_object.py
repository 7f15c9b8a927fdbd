from __future__ import annotations

import json
import math
from dataclasses import asdict, fields, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from count_video.records import Collision, Ending, Estimate, TrialResult, Velocities
from count_video.reports.exports import SIGNIFICANT_DIGITS, json_line, json_object

KEYS = [
    "schema_version",
    "clip",
    "status",
    "reason",
    "what_to_do",
    "count",
    "seen",
    "between_frames",
    "probability",
    "count_after_burst",
    "collisions",
    "capture_fps",
    "capture_fps_source",
    "even_rate",
    "frames_decoded",
    "frames_promised",
    "wall_side",
    "upright",
    "ball_diameter_px",
    "millimetres_per_px",
    "pi_low",
    "pi_high",
    "mass_ratio",
    "mass_ratio_sigma",
    "contradicting_ratio",
    "energy_kept",
    "restitution",
    "ending",
    "fitted_setup",
    "warnings",
    "reviewed_count",
    "corrections",
    "notes",
    "plan",
]
COLLISION_KEYS = [
    "number",
    "kind",
    "frame",
    "frame_sigma",
    "time_s",
    "seen",
    "position_px",
    "velocity_before_px_frame",
    "velocity_after_px_frame",
]
VELOCITY_KEYS = ["ball", "heavy", "ball_sigma", "heavy_sigma"]

# Text as file names bring it: any code point, lone surrogates and line ends among them.
any_text = st.text(st.characters(exclude_categories=()))
any_result = st.builds(
    TrialResult,
    clip=any_text,
    reason=st.none() | any_text,
    collisions=st.lists(st.builds(Collision), max_size=3).map(tuple),
    warnings=st.lists(any_text, max_size=2).map(tuple),
)


def strict(line: str) -> dict[str, object]:
    """Parse as a reader of JSON does that knows neither NaN nor infinity."""

    def refuse(constant: str) -> None:
        pytest.fail(f"{constant} is not JSON")

    parsed = json.loads(line, parse_constant=refuse)
    assert isinstance(parsed, dict)
    return parsed


@given(any_result)
def test_every_result_is_one_line_of_strict_json_in_ascii(result: TrialResult) -> None:
    line = json_line(result)
    assert line.isascii()
    assert line.splitlines() == [line]
    strict(line)


@given(any_result)
def test_no_key_is_ever_left_out(result: TrialResult) -> None:
    parsed = strict(json_line(result))
    assert list(parsed) == KEYS
    assert parsed["schema_version"] == 1
    for collision in json_object(result)["collisions"]:  # type: ignore[attr-defined]
        assert list(collision) == COLLISION_KEYS
        assert list(collision["velocity_before_px_frame"]) == VELOCITY_KEYS


WRITTEN_DIFFERENTLY = {
    *("clip", "reason", "what_to_do", "probability", "collisions", "warnings", "corrections"),
    *("energy_kept", "restitution_bodies", "restitution_wall", "ending"),
    *("setup", "comparison"),
}


@given(any_result)
def test_what_is_known_is_written_unchanged_and_the_rest_is_null(result: TrialResult) -> None:
    parsed = strict(json_line(result))
    for field in fields(TrialResult):
        value = getattr(result, field.name)
        if field.name in WRITTEN_DIFFERENTLY:
            continue
        if isinstance(value, float):
            value = float(f"{value:.{SIGNIFICANT_DIGITS}g}") if math.isfinite(value) else None
        assert parsed[field.name] == value


@given(any_result)
def test_every_string_can_be_written_as_utf_8(result: TrialResult) -> None:
    parsed = strict(json_line(result))
    for text in (parsed["clip"], parsed["reason"] or "", *parsed["warnings"]):  # type: ignore[misc]
        assert isinstance(text.encode("utf-8"), bytes)


@given(st.text(st.characters(exclude_categories=("Cs",))))
def test_a_clip_is_named_as_it_was_given(name: str) -> None:
    result = replace(MADE, clip=name, reason=name, warnings=(name,))
    parsed = strict(json_line(result))
    assert (parsed["clip"], parsed["reason"], parsed["warnings"]) == (name, name, [name])


def test_a_velocity_that_was_not_seen_is_null() -> None:
    line = json_line(MADE)
    (collision,) = strict(line)["collisions"]  # type: ignore[misc]
    before, after = (collision[f"velocity_{side}_px_frame"] for side in ("before", "after"))
    assert (before["ball"], before["heavy"], before["heavy_sigma"]) == (0.0, None, None)
    assert (after["ball"], after["heavy"], after["heavy_sigma"]) == (-4.5, None, None)
    assert "NaN" not in line


def test_the_probabilities_are_keyed_by_the_count_as_text() -> None:
    parsed = strict(json_line(replace(MADE, probability={31: 0.75, 30: 0.25})))
    assert parsed["probability"] == {"30": 0.25, "31": 0.75}


def test_no_number_shows_the_rounding_of_a_sum() -> None:
    assert '{"30": 0.01, "31": 0.99}' in json_line(
        replace(MADE, probability={31: 0.99, 30: 1 - 0.99})
    )


def test_numbers_of_numpy_are_written_like_those_of_python() -> None:
    by_numpy = replace(
        MADE,
        count=np.int64(1),
        probability={np.int64(1): np.float64(1.0)},
        ball_diameter_px=np.float32(40.5),
        collisions=(replace(MADE.collisions[0], number=np.int32(1), seen=np.bool_(True)),),
    )
    assert json_line(by_numpy) == json_line(MADE)


MADE = TrialResult(
    clip="clips/ball.mp4",
    status="counted",
    reason=None,
    count=1,
    seen=1,
    between_frames=0,
    probability={1: 1.0},
    count_after_burst=0,
    collisions=(
        Collision(
            number=1,
            kind="wall",
            frame=17.25,
            frame_sigma=0.05,
            time_s=None,
            seen=True,
            position_px=120.5,
            velocity_before=Velocities(0.0, math.nan),
            velocity_after=Velocities(-4.5, math.nan),
        ),
    ),
    capture_fps=None,
    capture_fps_source="unknown",
    frames_decoded=100,
    frames_promised=None,
    wall_side="left",
    ball_diameter_px=40.5,
    millimetres_per_px=None,
    pi_low=None,
    pi_high=None,
    mass_ratio=None,
    warnings=(),
)


def test_what_the_fit_measured_is_written_with_its_uncertainty() -> None:
    ending = Ending("geometric", energy_kept=0.625, heavy_speed=0.75, ball_speed=0.5)
    fitted = replace(
        MADE,
        energy_kept=(0.75, 0.625),
        restitution_bodies=Estimate(0.96875, 0.0078125),
        ending=ending,
    )
    parsed = strict(json_line(fitted))
    assert parsed["energy_kept"] == [0.75, 0.625]
    bodies = {"value": 0.96875, "sigma": 0.0078125}
    assert parsed["restitution"] == {"bodies": bodies, "wall": None}
    assert parsed["ending"] == asdict(ending)


def test_what_no_fit_measured_is_null() -> None:
    parsed = strict(json_line(MADE))
    assert (parsed["energy_kept"], parsed["restitution"], parsed["ending"]) == (None, None, None)

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from count_video.records import Collision, TrialResult, Velocities
from count_video.reports.text import result_text
from count_video.reports.words import plural, printable

TERMINAL_WIDTH = 80


def made_collision(number: int, **changes: object) -> Collision:
    collision = Collision(
        number=number,
        kind="bodies" if number % 2 else "wall",
        frame=100.0 + number,
        frame_sigma=0.02,
        time_s=(100.0 + number) / 960,
        seen=True,
        position_px=412.0 - number,
        velocity_before=Velocities(12.5, -6.25),
        velocity_after=Velocities(-11.5, -5.75),
    )
    return replace(collision, **changes)  # type: ignore[arg-type]


def made_result(count: int, after: int = 0, **changes: object) -> TrialResult:
    result = TrialResult(
        clip="clips/trial.mp4",
        status="counted",
        reason=None,
        count=count,
        seen=count,
        between_frames=0,
        probability={count: 1.0},
        count_after_burst=after,
        collisions=tuple(made_collision(number) for number in range(1, count + after + 1)),
        capture_fps=960.0,
        capture_fps_source="option",
        frames_decoded=600,
        frames_promised=600,
        wall_side="right",
        ball_diameter_px=40.5,
        millimetres_per_px=0.988,
        pi_low=None,
        pi_high=None,
        mass_ratio=None,
        warnings=(),
    )
    return replace(result, **changes)  # type: ignore[arg-type]


def made_refusal(**changes: object) -> TrialResult:
    refusal = replace(made_result(0), status="not_counted", count=None, probability={})
    return replace(refusal, **changes)  # type: ignore[arg-type]


def rows(text: str) -> list[list[str]]:
    """Split the table's rows, which begin with a number, into cells."""
    lines = [line.split() for line in text.splitlines()]
    return [cells for cells in lines if cells and cells[0].isdecimal()]


@pytest.mark.parametrize(
    ("count", "words"), [(0, "no collision"), (1, "1 collision"), (31, "31 collisions")]
)
def test_the_first_line_is_the_count_in_plain_words(count: int, words: str) -> None:
    assert result_text(made_result(count)).splitlines()[0] == f"trial.mp4: {words}"


def test_a_doubtful_count_is_not_stated_as_certain() -> None:
    text = result_text(made_result(3, probability={3: 0.625, 4: 0.375}, reason="a blurred frame"))
    assert text.splitlines()[0] == "trial.mp4: probably 3 collisions"
    assert "3: 62%, 4: 38%" in text
    assert "In doubt     a blurred frame" in text


def test_the_kinds_of_the_burst_are_counted_apart() -> None:
    assert "3 between the bodies, 2 with the wall" in result_text(made_result(5, after=4))


def test_every_collision_has_its_row_with_kind_and_frame() -> None:
    result = made_result(5, after=2)
    said = [cells[:3] for cells in rows(result_text(result))]
    assert said == [[str(c.number), c.kind, f"{c.frame:.2f}"] for c in result.collisions]


def test_collisions_after_the_burst_stand_under_a_line_of_their_own() -> None:
    lines = result_text(made_result(3, after=1)).splitlines()
    border = lines.index("  after the cylinder turned back:")
    assert lines[border - 1].split()[0] == "3"
    assert lines[border + 1].split()[0] == "4"
    assert "1 more collision after the cylinder turned back" in "\n".join(lines)


def test_an_inferred_collision_is_marked() -> None:
    inferred = (made_collision(1), made_collision(2, seen=False))
    text = result_text(made_result(2, seen=1, between_frames=1, collisions=inferred))
    assert [cells[1] for cells in rows(text)] == ["bodies", "wall*"]
    assert "* inferred between frames" in text
    assert "1 seen in the frames, 1 inferred between them" in text


@pytest.mark.parametrize(
    ("apart", "words"), [(2.5, "all seen in the frames"), (0.9, "0.9 frames at the closest")]
)
def test_where_all_was_seen_no_mark_is_explained(apart: float, words: str) -> None:
    later = made_collision(2, frame=101.0 + apart)
    text = result_text(made_result(2, collisions=(made_collision(1), later)))
    assert words in " ".join(text.split())
    assert "*" not in text


@pytest.mark.parametrize("width", [40, 60, 100])
def test_sentences_are_as_wide_as_is_asked_for(width: int) -> None:
    result = made_result(2, warnings=(" ".join(["word"] * 60),), collisions=())
    longest = max(map(len, result_text(result, width).splitlines()))
    assert width - len(" words") < longest <= width


@pytest.mark.parametrize("width", range(30, 100, 7))
def test_the_name_of_an_option_is_never_parted(width: int) -> None:
    text = result_text(made_result(1, capture_fps=None), width)
    assert any("--capture-fps" in line for line in text.splitlines())


def test_without_a_capture_rate_no_time_is_shown_and_the_option_is_named() -> None:
    timeless = tuple(made_collision(number, time_s=None) for number in (1, 2))
    text = result_text(
        made_result(2, capture_fps=None, capture_fps_source="unknown", collisions=timeless)
    )
    assert "time/s" not in text
    assert "--capture-fps" in text


def test_a_clip_with_one_body_has_no_columns_for_another() -> None:
    alone = made_collision(
        1,
        kind="wall",
        velocity_before=Velocities(3.0, math.nan),
        velocity_after=Velocities(-2, math.nan),
    )
    text = result_text(made_result(1, collisions=(alone,)))
    assert "ball px/frame" in text
    assert "heavy px/frame" not in text
    assert "nan" not in text


@pytest.mark.parametrize(
    ("side", "upright", "words"),
    [
        ("left", False, "wall on the left"),
        ("right", None, "wall on the right"),
        ("left", True, "wall above"),
        ("right", True, "wall below"),
    ],
)
def test_the_wall_is_where_one_sees_it(side: str, upright: bool | None, words: str) -> None:
    assert words in result_text(made_result(3, wall_side=side, upright=upright))


def test_a_single_velocity_that_was_not_seen_is_a_dash() -> None:
    half = (made_collision(1), made_collision(2, velocity_after=Velocities(math.nan, 1.0)))
    assert rows(result_text(made_result(2, collisions=half)))[1][-3] == "-"


@pytest.mark.parametrize(("count", "place"), [(31, "inside"), (30, "outside"), (32, "outside")])
def test_the_bounds_on_pi_are_held_against_pi(count: int, place: str) -> None:
    theta = math.atan(math.sqrt(1 / 100))
    bounds = {"pi_low": count * theta, "pi_high": (count + 1) * theta}
    text = result_text(made_result(count, mass_ratio=100.0, **bounds))
    unwrapped = " ".join(text.split())
    assert f"between {count * theta:.5g} and {(count + 1) * theta:.5g}" in unwrapped
    assert f"pi lies {place}" in unwrapped


@pytest.mark.parametrize(
    ("ratio", "words"), [(1 / 3, "0.3333"), (101.93098, "101.9"), (100.0, "100"), (1e6, "1000000")]
)
def test_the_mass_ratio_is_written_without_digits_that_nobody_measured(
    ratio: float, words: str
) -> None:
    assert f"  Mass ratio   {words}\n" in result_text(made_result(1, mass_ratio=ratio))


@pytest.mark.parametrize(
    ("ratio", "sigma", "words"),
    [
        (101.93098, 0.2913, "101.93 +- 0.29"),
        (2.40668, 0.0042, "2.4067 +- 0.0042"),
        (9873.1, 412.0, "9873 +- 412"),
    ],
)
def test_a_measured_mass_ratio_has_the_digits_that_its_uncertainty_leaves(
    ratio: float, sigma: float, words: str
) -> None:
    text = result_text(made_result(1, mass_ratio=ratio, mass_ratio_sigma=sigma))
    assert f"  Mass ratio   {words}\n" in text


def test_a_clip_that_is_not_counted_says_why_and_what_to_do() -> None:
    refusal = made_refusal(reason="the ball moves at frame 0", what_to_do="start it earlier")
    text = result_text(refusal)
    assert text.splitlines()[0] == "trial.mp4: not counted"
    assert "Why          the ball moves at frame 0" in text
    assert "What to do   start it earlier" in text


def test_what_was_found_is_shown_also_where_nothing_is_counted() -> None:
    found = tuple(made_collision(number) for number in (1, 2, 3))
    text = result_text(made_refusal(collisions=found))
    assert len(rows(text)) == 3
    assert "after the cylinder turned back" not in text


def test_every_warning_is_given() -> None:
    warnings = ("12 frames are missing", "8 frames are copies")
    text = result_text(made_result(1, warnings=warnings))
    assert all(f"  Warning      {warning}" in text for warning in warnings)


px_frame = st.floats(-999, 999)
ordinary_collision = st.builds(
    made_collision,
    st.integers(1, 9999),
    frame=st.floats(0, 99999),
    time_s=st.none() | st.floats(0, 999),
    seen=st.booleans(),
    position_px=st.floats(0, 8000),
    velocity_before=st.builds(Velocities, px_frame, px_frame),
    velocity_after=st.builds(Velocities, px_frame, px_frame),
)
sentence = st.text(st.characters(codec="ascii"), max_size=60).map(lambda words: f"why: {words}")


@given(
    st.lists(ordinary_collision, max_size=5).map(tuple),
    sentence,
    st.sampled_from(["counted", "not_counted"]),
)
def test_eighty_columns_are_enough(
    collisions: tuple[Collision, ...], words: str, status: str
) -> None:
    result = made_result(
        len(collisions), status=status, collisions=collisions, reason=words, warnings=(words,) * 2
    )
    lines = result_text(result).splitlines()
    assert max(map(len, lines)) <= TERMINAL_WIDTH
    assert all(line == line.rstrip() for line in lines)


@given(st.text(st.characters(exclude_categories=())))
def test_nothing_that_a_terminal_obeys_gets_through(text: str) -> None:
    assert printable(text).isprintable()
    headline = result_text(made_result(1, clip=f"clips/{text}x.mp4")).splitlines()[0]
    assert headline.isprintable()


@given(st.text().filter(str.isprintable))
def test_harmless_text_is_left_alone(text: str) -> None:
    assert printable(text) == text


@pytest.mark.parametrize(("number", "words"), [(0, "no frame"), (1, "1 frame"), (2, "2 frames")])
def test_a_noun_follows_its_number(number: int, words: str) -> None:
    assert plural(number, "frame") == words


def test_a_fast_camera_has_its_rate_in_digits() -> None:
    text = result_text(made_result(3, capture_fps=1e6), TERMINAL_WIDTH)
    assert "captured at 1000000 frames a second" in " ".join(text.split())


def test_where_the_rate_changes_no_rate_is_asked_for() -> None:
    text = result_text(made_result(3, capture_fps=None, even_rate=False), TERMINAL_WIDTH)
    assert "their rate changes, so no times" in text
    assert "--capture-fps" not in text

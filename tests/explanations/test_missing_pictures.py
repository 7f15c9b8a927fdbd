"""A count of a clip that lacks pictures is as sure as what may have happened in them allows."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from explained import bouncing
from hypothesis import given
from hypothesis import strategies as st

from count_video.explanations import doubted_for_missing, with_missing
from count_video.reasons import Cause, Reason
from count_video.records import FootageReport
from count_video.video.reader import open_footage
from count_video.video.writer import write_clip

SURE = {1: 0.01, 2: 0.98, 3: 0.01}


def report(decoded: int, missing: int) -> FootageReport:
    return FootageReport(decoded, None, (), missing)


@given(st.integers(0, 40), st.integers(1, 10_000), st.integers(0, 10_000))
def test_probabilities_stay_probabilities(count: int, decoded: int, missing: int) -> None:
    changed = with_missing(SURE, count, report(decoded, missing))
    assert sum(changed.values()) == pytest.approx(1.0)
    assert all(0 <= chance <= 1 for chance in changed.values())


def test_without_missing_pictures_nothing_changes() -> None:
    assert with_missing(SURE, 2, report(100, 0)) == SURE


def test_the_more_pictures_are_missing_the_less_sure_a_count_is() -> None:
    chances = [with_missing(SURE, 2, report(77, missing))[2] for missing in (0, 1, 22, 77)]
    assert chances == sorted(chances, reverse=True)
    assert chances[1] > 0.9, "one lost picture of many hides hardly anything"
    assert chances[2] < 0.9


def test_a_count_is_doubted_for_what_is_missing_and_a_refusal_stays_one() -> None:
    counted = replace(bouncing(2), probability=SURE)
    doubted = doubted_for_missing(counted, report(77, 22))
    assert doubted.probability[2] < 0.9
    assert doubted.doubts == (Reason(Cause.FRAMES_MISSING, (22,)),)
    assert doubted_for_missing(counted, report(99, 0)) == counted
    refused = replace(counted, against=(Reason(Cause.NO_COLLISION),))
    named = doubted_for_missing(refused, report(77, 22))
    assert named.against == (Reason(Cause.FRAMES_MISSING, (22,)), *refused.against)


def test_pictures_that_a_cut_file_lacks_are_counted(tmp_path: Path) -> None:
    whole, cut = tmp_path / "whole.mp4", tmp_path / "cut.mp4"
    with open_footage(Path(__file__).parents[2] / "fixtures" / "ratio1-count3.mp4") as footage:
        write_clip(whole, (frame.luma.copy() for frame in footage.frames()))
    content = whole.read_bytes()
    cut.write_bytes(content[: len(content) // 2])
    for path, there in ((whole, True), (cut, False)):
        with open_footage(path) as footage:
            decoded = sum(1 for _ in footage.frames())
            missing = footage.report().frames_missing
        assert (missing == 0) == there
        assert decoded + missing == pytest.approx(108, abs=1)

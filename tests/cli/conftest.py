"""The stand-in for the work on one clip, as a fixture."""

from __future__ import annotations

import pytest
from stand_in import StandIn, not_counted

from count_video import pipeline


@pytest.fixture
def stand_in(monkeypatch: pytest.MonkeyPatch) -> StandIn:
    """Replace the counting of one clip for the length of a test."""
    stand_in = StandIn(answers={"still.mp4": not_counted})
    monkeypatch.setattr(pipeline, "work_through", stand_in.work_through)
    return stand_in

"""The pictures that README.md and docs/ show are those that the commands make now."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from types import ModuleType

import cv2
import numpy as np
import pytest

from pages import TOP

SAME_PICTURE_LEVELS = 6.0
"""Mean difference in grey levels that other versions of the drawing library make."""


def refresh() -> ModuleType:
    """Import the program that makes them."""
    spec = importlib.util.spec_from_file_location("refresh", TOP / "docs/refresh.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


REFRESH = refresh()


NAMES = [
    pytest.param(name, marks=pytest.mark.slow if call.startswith(REFRESH.CLIP) else ())
    for name, call in REFRESH.PICTURES.items()
]
"""A clip's picture takes as long as all its evidence."""


@pytest.mark.parametrize("name", NAMES)
def test_a_picture_is_made_by_its_command(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(TOP)
    made, kept = (
        cv2.imread(str(file), cv2.IMREAD_GRAYSCALE)
        for file in (REFRESH.make_picture(name, tmp_path), TOP / "docs/pictures" / name)
    )
    assert made is not None
    assert kept is not None
    assert made.shape == kept.shape
    assert np.abs(made.astype(float) - kept).mean() <= SAME_PICTURE_LEVELS


HEADING = "   no.  kind      frame"
PAGE = "Before\n\n```console\n$ count-video a.mp4\nold\n```\nafter\n"


def test_the_output_below_a_command_is_replaced_and_nothing_else() -> None:
    new = REFRESH.refreshed(PAGE, lambda call: f"{call} was counted\n")
    assert new == PAGE.replace("old", "a.mp4 was counted")


def test_lines_that_were_left_out_stay_left_out() -> None:
    like = ["a: 9 collisions", HEADING, "1", "2", "  ...", "9"]
    now = ["a: 9 collisions", "one line more", HEADING, *"123456789"]
    assert REFRESH.shortened(now, like) == [*now[:3], "1", "2", "  ...", "9"]

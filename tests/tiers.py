"""Which cases of a test run every time, and which with ``-m slow``."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import pytest


def rest_slow(cases: Iterable[Any], quick: int = 1) -> list[Any]:
    """Return all cases; those after the first few run only when the slow tests are asked for."""
    marked, cases = [], list(cases)
    for case in cases:
        values = case.values if hasattr(case, "marks") else case
        marks = [*getattr(case, "marks", ()), pytest.mark.slow]
        marked.append(
            pytest.param(*(values if isinstance(values, tuple) else (values,)), marks=marks)
        )
    return [*cases[:quick], *marked[quick:]]


def known_miss(*case: Any, why: str) -> Any:
    """Return a case that is not met yet; once it is, the mark has to go."""
    return pytest.param(*case, marks=pytest.mark.xfail(reason=why, strict=True))

"""One set of laws for many motions at once and for one alone.

An array operation takes a microsecond however short the array is; a plain number takes a
twentieth of it. A scan over thousands of sets wants arrays, a fit follows one motion at a time.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np

from count_video.records import Floats

Number = TypeVar("Number", float, Floats)


@dataclass(frozen=True)
class Arithmetic(Generic[Number]):
    """Functions on numbers of one kind; what is not defined is NaN."""

    exp: Callable[[Number], Number]
    sin: Callable[[Number], Number]
    cos: Callable[[Number], Number]
    arctan2: Callable[[Number, Number], Number]
    arccos: Callable[[Number], Number]
    hypot: Callable[[Number, Number], Number]
    maximum: Callable[[Number, Number], Number]
    divide: Callable[[Number, Number], Number]
    where: Callable[[object, Number, Number], Number]
    """Of condition, value if it holds, value if not."""
    lost: Callable[[Number], bool]
    """Whether none of the values is finite."""


def _arccos(value: float) -> float:
    return math.acos(value) if -1.0 <= value <= 1.0 else math.nan


def _divide(over: float, under: float) -> float:
    return over / under if under else math.nan


def _where(condition: object, yes: float, no: float) -> float:
    return yes if condition else no


def _maximum(one: float, other: float) -> float:
    return one if one > other or one != one else other  # noqa: PLR0124 - NaN stays NaN


NUMBERS: Arithmetic[float] = Arithmetic(
    exp=math.exp,
    sin=math.sin,
    cos=math.cos,
    arctan2=math.atan2,
    arccos=_arccos,
    hypot=math.hypot,
    maximum=_maximum,
    divide=_divide,
    where=_where,
    lost=lambda value: not math.isfinite(value),
)
ARRAYS: Arithmetic[Floats] = Arithmetic(
    exp=np.exp,
    sin=np.sin,
    cos=np.cos,
    arctan2=np.arctan2,
    arccos=np.arccos,
    hypot=np.hypot,
    maximum=np.maximum,
    divide=np.divide,
    where=lambda condition, yes, no: np.where(np.asarray(condition), yes, no),
    lost=lambda values: not np.isfinite(values).any(),
)

"""What was counted and followed in a clip, so that its evidence can be drawn at any later time.

It is stored as text that only this program reads, in Python's JSON, which has NaN: records as
objects by the names of their fields, arrays as lists. What was written by another version may not
fit, and is then of no use.
"""

from __future__ import annotations

import json
import sys
from dataclasses import asdict, dataclass, is_dataclass
from pathlib import Path
from types import UnionType
from typing import Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

import numpy as np

from count_video.answers import Trial
from count_video.inputs import json_value
from count_video.records import Track, TrialResult
from count_video.reports.material import Pendulum

_Record = TypeVar("_Record")


@dataclass(frozen=True)
class Followed:
    """One clip: the answer, and the motion that it rests on."""

    result: TrialResult
    track: Track | None = None
    """None where no bodies could be followed."""
    pendulum: Pendulum | None = None
    """None where the swing does not show."""

    @property
    def path(self) -> Path:
        """The clip's file."""
        return Path(self.result.clip)


def followed(trial: Trial) -> Followed:
    """Keep what can be drawn of a clip that was worked through."""
    swing = trial.swing
    pendulum = None if swing is None else Pendulum(swing.rate_squared, swing.centre_px)
    return Followed(trial.result, trial.track, pendulum)


def packed(record: Any) -> str:
    """Write a record as text."""
    return json.dumps(asdict(record), default=lambda array: array.tolist())


def unpacked(kind: type[_Record], text: str) -> _Record:
    """Read a record of some kind from text.

    Raises
    ------
    ValueError
        It is no such text, or of another version of the program.
    """
    try:
        found: _Record = _unpacked(kind, json_value(text))
    except (TypeError, LookupError, AttributeError, OverflowError) as error:
        raise ValueError(f"no {kind.__name__}: {error}") from error
    return found


def _unpacked(kind: Any, value: Any) -> Any:  # noqa: PLR0911 - a kind a line
    """Make a value of a kind, as a type hint names it."""
    origin, parts = get_origin(kind), get_args(kind)
    if origin in (Union, UnionType):
        return None if value is None else _unpacked(parts[0], value)
    if kind is float:
        return float(value)
    if isinstance(kind, type) and is_dataclass(kind):
        kinds = get_type_hints(kind)
        return kind(**{name: _unpacked(kinds[name], one) for name, one in value.items()})
    if origin is np.ndarray:
        return np.array(value, np.float64)
    if origin is tuple:
        return tuple(_unpacked(parts[0], one) for one in value)
    if origin is dict:
        return {parts[0](key): _unpacked(parts[1], one) for key, one in value.items()}
    if value not in parts if origin is Literal else not isinstance(value, kind):
        raise ValueError(f"{value!r} is no {kind}")
    if kind is int and abs(value) > sys.maxsize:
        raise ValueError("a number that nothing has")
    return value

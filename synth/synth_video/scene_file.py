"""Scenes as TOML files, and single settings as ``section.key=value``."""

from __future__ import annotations

import dataclasses
import math
import tomllib
from collections.abc import Iterable, Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any, Literal, get_args, get_origin, get_type_hints

from count_video.errors import UsageError
from synth_video.scene import Scene

SCENE_DIRECTORY = files("synth_video") / "scenes"
SECTIONS = tuple(f.name for f in dataclasses.fields(Scene) if f.name not in ("name", "purpose"))


def scene_names() -> list[str]:
    """Names of the scenes that come with the package, sorted."""
    names = (entry.name for entry in SCENE_DIRECTORY.iterdir())
    return sorted(name.removesuffix(".toml") for name in names if name.endswith(".toml"))


def load_scene(name: str, overrides: Iterable[str] = ()) -> Scene:
    """Read a scene by its name, or from the path of a TOML file, and apply overrides.

    Parameters
    ----------
    name
        One of ``scene_names()``, or a path that ends in ``.toml``.
    overrides
        Strings ``section.key=value``; the value is written as in TOML, text also without quotes.

    Raises
    ------
    UsageError
        Unknown scene, section or key; a value of the wrong type or out of range.
    """
    tables = _read_tables(name)
    for override in overrides:
        _apply_override(tables, override)
    return _build_scene(Path(name).stem, tables)


def _read_tables(name: str) -> dict[str, Any]:
    """Parse the TOML of a scene into nested dictionaries."""
    try:
        if name.endswith(".toml"):
            text = Path(name).read_text(encoding="utf-8")
        elif name in scene_names():
            text = (SCENE_DIRECTORY / f"{name}.toml").read_text(encoding="utf-8")
        else:
            raise UsageError(f"no scene {name!r}; there are: {', '.join(scene_names())}")
        return tomllib.loads(text)
    except OSError as error:
        raise UsageError(f"scene file {name}: {error.strerror}") from error
    except ValueError as error:  # broken TOML, or bytes that are not UTF-8
        raise UsageError(f"scene file {name} is not valid TOML: {error}") from error


def _apply_override(tables: dict[str, Any], override: str) -> None:
    """Write one ``section.key=value`` into the tables."""
    path, equals, text = override.partition("=")
    section, dot, key = path.strip().partition(".")
    if not (equals and dot and key):
        raise UsageError(f"setting {override!r}: write it as section.key=value")
    table = tables.setdefault(section, {})
    if not isinstance(table, dict):
        raise UsageError(f"setting {override!r}: {section!r} is no section")
    table[key] = _parse_value(text.strip())


def _parse_value(text: str) -> object:
    """Read a TOML value; what is none (``left``, ``libx265``) is taken as plain text."""
    try:
        parsed = tomllib.loads(f"value = {text}")
    except tomllib.TOMLDecodeError:
        return text
    return parsed["value"] if set(parsed) == {"value"} else text


def _build_scene(name: str, tables: Mapping[str, Any]) -> Scene:
    """Turn checked tables into the frozen records."""
    hints = get_type_hints(Scene)
    parts: dict[str, Any] = {"name": name}
    for section, table in tables.items():
        if section == "purpose":
            parts[section] = _checked("purpose", table, str)
        elif section not in SECTIONS:
            raise UsageError(f"no section {section!r}; there are: {', '.join(SECTIONS)}")
        elif not isinstance(table, Mapping):
            raise UsageError(f"{section} must be a section with keys")
        else:
            parts[section] = _build_section(section, hints[section], table)
    return Scene(**parts)


def _build_section(section: str, kind: type, table: Mapping[str, Any]) -> object:
    """Build one settings record, checking names and types of its keys."""
    hints = get_type_hints(kind)
    keys = [field.name for field in dataclasses.fields(kind)]
    for key in table:
        if key not in keys:
            raise UsageError(f"no setting {section}.{key}; {section} has: {', '.join(keys)}")
    return kind(**{k: _checked(f"{section}.{k}", v, hints[k]) for k, v in table.items()})


def _checked(label: str, value: object, wanted: Any) -> object:
    """Return the value in the wanted type, or raise ``UsageError`` naming what was expected."""
    if get_origin(wanted) is Literal:
        choices = get_args(wanted)
        if value not in choices:
            raise UsageError(f"{label} must be one of {', '.join(choices)}, not {value!r}")
        return value
    if get_origin(wanted) is tuple:
        return _checked_color(label, value)
    if wanted is float and type(value) is int:
        return float(value)
    if type(value) is not wanted:  # exact: bool is a subclass of int, and true is no number
        names = {int: "a whole number", float: "a number", bool: "true or false", str: "text"}
        raise UsageError(f"{label} must be {names.get(wanted, wanted)}, not {value!r}")
    if isinstance(value, float) and not math.isfinite(value):
        raise UsageError(f"{label} must be a finite number, not {value}")
    return value


def _checked_color(label: str, value: object) -> tuple[int, ...]:
    """Three whole numbers from 0 to 255."""
    if isinstance(value, list) and len(value) == 3:
        channels = tuple(c for c in value if type(c) is int and 0 <= c <= 255)
        if len(channels) == 3:
            return channels
    raise UsageError(f"{label} must be a colour [red, green, blue], 0 to 255 each, not {value!r}")

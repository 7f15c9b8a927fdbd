"""What fixtures/README.md says of the fixtures is so, and its commands make them."""

from __future__ import annotations

import json
import re
import shlex
from dataclasses import asdict
from itertools import pairwise
from pathlib import Path

import pytest
from counting import FIXTURES, Truth, fixture_clips, truth_of

from count_video.physics.simulator import simulate
from synth_video import cli as synth_cli
from synth_video import film
from synth_video.scene_file import load_scene

MOST_BYTES = 12_000_000
ROW = re.compile(r"^\| `(?P<clip>[\w.-]+)` \| (?P<count>\d+) \| 1:(?P<ratio>\d+) \| (?P<rest>.*)")


def documented() -> dict[str, re.Match[str]]:
    """Return the rows of the table by the clip's name."""
    lines = (FIXTURES / "README.md").read_text("utf-8").splitlines()
    rows = [row for row in map(ROW.match, lines) if row]
    return {row["clip"]: row for row in rows}


def rendering_commands() -> dict[str, list[str]]:
    """Return the arguments of each ``synth-video`` call by the clip that it makes."""
    (block,) = re.findall(r"```sh\n(.*?)```", (FIXTURES / "README.md").read_text("utf-8"), re.S)
    calls = [shlex.split(line)[1:] for line in block.splitlines()]
    return {arguments[0]: arguments for arguments in calls}


def test_the_table_has_every_clip_with_its_count_and_its_masses() -> None:
    rows = documented()
    assert sorted(rows) == [clip.name for clip in fixture_clips()]
    for clip in fixture_clips():
        row, truth = rows[clip.name], truth_of(clip)
        assert (int(row["count"]), int(row["ratio"])) == (truth["count"], truth["mass_ratio"])
        assert f"{truth['shortest_interval_frames']:.1f} frames" in row["rest"]
        assert ("not resolved" in row["rest"]) == (not truth["resolved"])


def test_every_clip_that_the_project_rendered_has_its_command() -> None:
    rendered = [clip.name for clip in fixture_clips() if "scene" in truth_of(clip)]
    assert sorted(rendering_commands()) == rendered


def test_the_fixtures_stay_small() -> None:
    assert sum(file.stat().st_size for file in FIXTURES.iterdir()) <= MOST_BYTES


@pytest.mark.parametrize("clip", sorted(rendering_commands()))
def test_a_command_names_the_scene_and_the_seed_of_its_clip(clip: str) -> None:
    options = rendering_commands()[clip][1:]
    settings = [value for key, value in pairwise(options) if key == "--set"]
    scene = load_scene(options[options.index("--scene") + 1], settings)
    truth = truth_of(FIXTURES / clip)
    assert truth["seed"] == int(options[options.index("--seed") + 1])
    assert differing_settings(truth["scene"], json.loads(json.dumps(asdict(scene)))) == []
    assert simulate(scene.setup, seed=truth["seed"]).count == truth["count"]


def test_a_clip_made_again_has_the_same_truth(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # The truth is worked out before the pictures, which are drawn as they are written.
    monkeypatch.setattr(film, "write_clip", lambda *_: None)
    arguments = rendering_commands()["ratio1-count3.mp4"]
    again = tmp_path / arguments[0]
    assert synth_cli.main([str(again), *arguments[1:]]) == 0
    new, old = truth_of(again), truth_of(FIXTURES / again.name)
    # What was added to truths since would stand in the new one alone; the rest must be the same.
    assert shared(new, old) == {**old, "scene": None}


def shared(new: Truth, old: Truth) -> Truth:
    """Return the new truth with the keys of the old, also in its events, without the scene."""
    events = [
        {key: event[key] for key in before}
        for event, before in zip(new["events"], old["events"], strict=True)
    ]
    return {**{key: new[key] for key in old}, "scene": None, "events": events}


def differing_settings(stored: Truth, scene: Truth) -> list[str]:
    """Name the settings of a stored scene that a scene does not share."""
    sections = [name for name, settings in stored.items() if isinstance(settings, dict)]
    return [
        f"{section}.{key}"
        for section in sections
        for key, value in stored[section].items()
        if scene[section].get(key) != value
    ]

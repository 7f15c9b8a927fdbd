"""The script of the plan's page, by Node, against the simulator."""

from __future__ import annotations

import json
import math
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import count_video.reports
from count_video.physics.setup import Setup
from count_video.physics.simulator import simulate, simulate_many, varied
from count_video.physics.theory import collision_count
from tiers import rest_slow

NODE = shutil.which("node") or shutil.which("nodejs")
if NODE is None:
    pytest.skip("needs Node.js: apt-get install nodejs", allow_module_level=True)

SCRIPT = Path(count_video.reports.__file__).parent / "templates" / "plan_core.js"
SETUPS = 10_000
ROUNDING = 1e-9
MOST_ENDLESS = 0.01
"""Share of random set-ups in which bodies come to rest on each other, for which the page gives no
count: cylinder and wall squeeze the ball only at high ratios with large losses."""
RUNNER = """
const fs = require('fs');
require('vm').runInThisContext(fs.readFileSync(process.argv[1], 'utf8'));
const { setups, ratios } = JSON.parse(fs.readFileSync(0, 'utf8'));
const answers = setups.map((setup) => {
  const f = planCore.facts(setup);
  const places = f.states.map((s) => planCore.at(f, s.time + 0.001));
  return { count: f.count, bodies: f.bodies, needed: f.needed, endless: f.endless,
    turn: f.turn, last: f.collisions.length ? f.collisions[f.count - 1].time : null,
    ball: setup.sampled ? places.map((p) => p.ball) : [] };
});
process.stdout.write(JSON.stringify({ answers, theory: ratios.map(planCore.theory) }));
"""


def run(setups: list[dict[str, object]], ratios: list[float]) -> dict[str, Any]:
    """Let the script work on set-ups and mass ratios."""
    assert NODE is not None
    answer = subprocess.run(
        [NODE, "-e", RUNNER, str(SCRIPT)],
        input=json.dumps({"setups": setups, "ratios": ratios}),
        capture_output=True,
        text=True,
        check=True,
    )
    answers = json.loads(answer.stdout)
    assert isinstance(answers, dict)
    return answers


def random_setups() -> list[Setup]:
    """Draw set-ups as the sliders allow them, and beyond."""
    rng = np.random.default_rng(11)

    def between(least: float, most: float) -> np.ndarray:
        return rng.uniform(least, most, SETUPS)

    def sometimes(plain: float, drawn: np.ndarray) -> np.ndarray:
        return np.where(rng.random(SETUPS) < 0.3, plain, drawn)

    release = between(0.02, 0.2)
    damping = sometimes(0.0, between(0.0, 0.5))
    return varied(
        Setup(light_mass_kg=1.0),
        heavy_mass_kg=np.exp(between(0.0, np.log(400.0))),
        release_m=release,
        wall_gap_m=np.maximum(0.002, release * between(0.0, 1.0)),
        heavy_thread_m=sometimes(1.0, between(0.2, 3.0)),
        light_thread_m=sometimes(1.0, between(0.2, 3.0)),
        heavy_damping_per_s=damping,
        light_damping_per_s=damping,
        restitution_bodies=sometimes(1.0, between(0.85, 1.0)),
        restitution_wall=sometimes(1.0, between(0.85, 1.0)),
    )


def as_the_page_has_them(setup: Setup) -> dict[str, object]:
    return {
        "ratio": setup.heavy_mass_kg,
        "gap": setup.wall_gap_m,
        "release": setup.release_m,
        "heavyThread": setup.heavy_thread_m,
        "lightThread": setup.light_thread_m,
        "damping": setup.heavy_damping_per_s,
        "restitutionBodies": setup.restitution_bodies,
        "restitutionWall": setup.restitution_wall,
    }


def test_ten_thousand_random_set_ups_come_out_as_in_the_simulator() -> None:
    setups = random_setups()
    answers = run(list(map(as_the_page_has_them, setups)), [])["answers"]
    found = simulate_many(setups)
    assert sum(one["endless"] for one in answers) == int(found.endless.sum())
    assert found.endless.mean() < MOST_ENDLESS
    for row, one in enumerate(answers):
        assert one["endless"] == bool(found.endless[row])
        if one["endless"]:
            continue
        assert one["count"] == found.count[row], setups[row]
        assert one["last"] == pytest.approx(found.last_s[row], rel=ROUNDING)
        assert one["turn"] == pytest.approx(found.turn_s[row], rel=ROUNDING)
        shortest = found.shortest_s[row]
        needed = 10 * math.ceil(0.25 / shortest) if np.isfinite(shortest) else 10
        # A rounding may carry a rate just over a multiple of ten.
        assert one["needed"] == pytest.approx(needed, abs=10)


def test_paths_between_the_collisions_are_those_of_the_simulator() -> None:
    setups = random_setups()[:50]
    asked = [{**as_the_page_has_them(setup), "sampled": True} for setup in setups]
    for setup, one in zip(setups, run(asked, [])["answers"], strict=True):
        if one["endless"]:
            continue
        motion = simulate(setup)
        times = [0.0, *(bounce.time_s for bounce in motion.burst)]
        assert one["bodies"] == sum(bounce.kind == "bodies" for bounce in motion.burst)
        places = motion.sample(np.array(times) + 0.001).ball_far_face_m
        early = np.array(times) + 0.001 < motion.burst_end_s
        assert np.array(one["ball"])[early] == pytest.approx(places[early], abs=1e-7)


@pytest.mark.parametrize("number", rest_slow([300, 3_000]))
def test_the_theory_is_exact(number: int) -> None:
    rng = np.random.default_rng(12)
    ratios = [1.0, 3.0, 16.0, 100.0, 10_000.0, *np.exp(rng.uniform(0, 9, number)).tolist()]
    assert run([], ratios)["theory"] == [collision_count(ratio) for ratio in ratios]

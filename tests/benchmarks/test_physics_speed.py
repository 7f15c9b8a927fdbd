"""How fast the simulator is, in units of plain Python arithmetic on the same machine."""

from __future__ import annotations

import math
import time

import numpy as np
import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from count_video.physics.setup import Setup
from count_video.physics.simulator import simulate, simulate_many, varied

REFERENCE_STEPS = 100_000
ROUNDS = 11
"""The best of so many is taken, of the reference as of the simulator, in turns: what else the
machine does then troubles both alike."""

# In units of the reference, which takes 4 ms where nothing else runs. Measured there, in arrays of
# one trial and of a thousand: 6, and 9.
MOST_FOR_A_SAMPLED_TRIAL = 12.0
MOST_FOR_A_THOUSAND_TRIALS = 18.0

FRAME_TIMES_S = np.linspace(0.0, 1.0, 2000)
pytestmark = pytest.mark.slow


def reference() -> float:
    """Some arithmetic of the kind that the simulator does."""
    x = 0.5
    for _ in range(REFERENCE_STEPS):
        x = math.sin(x) * 1.5 + 0.25 * x
    return x


def reference_s() -> float:
    start = time.perf_counter()
    reference()
    return time.perf_counter() - start


class InTurns:
    """Times the reference before each round of a benchmark."""

    def __init__(self) -> None:
        self.references_s: list[float] = []

    def setup(self) -> None:
        self.references_s.append(reference_s())

    def ratio(self, benchmark: BenchmarkFixture) -> float:
        if benchmark.stats is None:
            pytest.skip("benchmarks are switched off")
        ratio: float = benchmark.stats.stats.min / min(self.references_s)
        benchmark.extra_info["reference_ms"] = 1e3 * min(self.references_s)
        benchmark.extra_info["ratio_to_reference"] = ratio
        return ratio


def test_a_thousand_trials_are_simulated_in_a_moment(benchmark: BenchmarkFixture) -> None:
    turns = InTurns()
    setups = varied(Setup(), wall_gap_m=np.linspace(0.02, 0.04, 1000))
    found = benchmark.pedantic(lambda: simulate_many(setups), setup=turns.setup, rounds=ROUNDS)
    assert found.count.min() >= 30
    assert turns.ratio(benchmark) <= MOST_FOR_A_THOUSAND_TRIALS


def test_a_trial_is_simulated_and_sampled_faster_than_a_frame_is_decoded(
    benchmark: BenchmarkFixture,
) -> None:
    turns = InTurns()
    trial = Setup(wall_gap_m=0.03)
    simulate(trial).sample(FRAME_TIMES_S)  # the first call pays for imports
    sample = benchmark.pedantic(
        lambda: simulate(trial).sample(FRAME_TIMES_S), setup=turns.setup, rounds=5 * ROUNDS
    )
    assert sample.ball_far_face_m.shape == FRAME_TIMES_S.shape
    assert turns.ratio(benchmark) <= MOST_FOR_A_SAMPLED_TRIAL

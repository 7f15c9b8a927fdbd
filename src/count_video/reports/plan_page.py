"""The page of a plan: sliders over the same simulation, in one file, without a network."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass

from count_video.planning import measured
from count_video.planning.measured import Measured
from count_video.planning.request import PlanRequest
from count_video.planning.whole import Plan
from count_video.reports.page import environment, own_file
from count_video.reports.plan_text import change_words, plan_headline, plan_text

MOST_RATIO = 10_000.0
"""Largest mass ratio that the sliders reach, unless a larger one is planned."""
LIGHT_FACTOR = 4.0
RATES_FPS = (24.0, 100_000.0)
THREADS_M = (0.2, 3.0)
RESTITUTION_AT_LEAST = 0.85


@dataclass(frozen=True)
class Slider:
    """One slider; masses and rate by the logarithm to base 10, which their steps are even in."""

    name: str
    label: str
    least: float
    most: float
    step: float
    value: float


def plan_page(plan: Plan) -> str:
    """Write the page."""
    page = environment().get_template("plan.html")
    request = plan.request
    return page.render(
        headline=plan_headline(plan),
        count=plan.burst.count,
        sliders=_sliders(request, _rate(plan)),
        alike=request.heavy_thread_m == request.light_thread_m,
        change=change_words(plan),
        text=plan_text(plan),
        data=_data(plan),
        style=own_file("plan.css"),
        core=own_file("plan_core.js"),
        script=own_file("plan.js"),
    )


def _rate(plan: Plan) -> float:
    """Rate of the planned camera, or the one that is needed."""
    return plan.framing.rate_needed_fps if plan.camera is None else plan.camera.capture_fps


def _sliders(request: PlanRequest, rate: float) -> list[Slider]:
    heavy, light = float(request.heavy), float(request.light)
    most = light * max(MOST_RATIO, request.mass_ratio)
    least_rate, most_rate = min(RATES_FPS[0], rate), max(RATES_FPS[1], rate)
    threads = (
        min(THREADS_M[0], request.heavy_thread_m, request.light_thread_m),
        max(THREADS_M[1], request.heavy_thread_m, request.light_thread_m),
    )
    rest = (min(RESTITUTION_AT_LEAST, request.restitution), 1.0)
    return [
        Slider(
            "gap", "Gap, ball to wall", *_around(request.gap_m, 0.005, 0.1), 0.0005, request.gap_m
        ),
        Slider(
            "release", "Release", *_around(request.release_m, 0.02, 0.2), 0.001, request.release_m
        ),
        _logarithmic("heavy", "Mass of the cylinder", light, most, heavy),
        _logarithmic(
            "light", "Mass of the ball", light / LIGHT_FACTOR, light * LIGHT_FACTOR, light
        ),
        Slider("heavyThread", "Thread of the cylinder", *threads, 0.001, request.heavy_thread_m),
        Slider("lightThread", "Thread of the ball", *threads, 0.001, request.light_thread_m),
        Slider("restitution", "Restitution", *rest, 0.001, request.restitution),
        _logarithmic("rate", "Camera", least_rate, most_rate, rate),
    ]


def _around(value: float, least: float, most: float) -> tuple[float, float]:
    return min(value, least), max(value, most)


def _logarithmic(name: str, label: str, least: float, most: float, value: float) -> Slider:
    ends = (math.log10(least), math.log10(most))
    return Slider(name, label, round(ends[0], 4), round(ends[1], 4), 0.002, math.log10(value))


def _data(plan: Plan) -> dict[str, object]:
    request = plan.request
    return {
        "planned": {
            "gap": request.gap_m,
            "release": request.release_m,
            "heavy": float(request.heavy),
            "light": float(request.light),
            "heavyThread": request.heavy_thread_m,
            "lightThread": request.light_thread_m,
            "restitution": request.restitution,
            "rate": _rate(plan),
        },
        "damping": request.damping_per_s,
        "ballDiameter": request.ball_diameter_m,
        "tolerances": asdict(request.tolerances),
        "seed": request.seed,
        "measured": {
            "resolved": _like(measured.RESOLVED),
            "between": _like(measured.BETWEEN),
            "close": _like(measured.CLOSE),
            "long": _like(measured.LONG),
            "closest_frames": measured.CLOSEST_FRAMES,
            "closer_frames": measured.CLOSER_FRAMES,
            "most_of_a_short_burst": measured.MOST_OF_A_SHORT_BURST,
            "long_burst": list(measured.LONG_BURST),
            "long_burst_fps": measured.LONG_BURST_FPS,
        },
    }


def _like(clips: Measured) -> dict[str, object]:
    return {**asdict(clips), "chance": clips.chance}

"""Conditions of time: uneven rates, copies, and clips that show too much or too little."""

from __future__ import annotations

from synth_video.suite.condition import Condition

RATE = (
    Condition(
        "uneven",
        "a variable rate: exposures off their time by up to 3 or 15 % of a frame, stamped truly",
        ("camera.jitter=0.03", "encoding.variable_rate=true"),
        ("camera.jitter=0.15", "encoding.variable_rate=true"),
    ),
    Condition(
        "copies",
        "every 30th or 5th picture shown twice",
        ("encoding.repeat_every=30",),
        ("encoding.repeat_every=5",),
    ),
    Condition(
        "lost",
        "every 40th or 15th picture lost, a copy of the one before in its place",
        ("encoding.repeat_every=40", "encoding.repeat_lost=true"),
        ("encoding.repeat_every=15", "encoding.repeat_lost=true"),
    ),
    Condition(
        "ramp",
        "a slow-motion export whose rate is 2 or 4 times as high where collisions are dense",
        ("clip.ramp=2", "clip.lead_frames=48", "clip.tail_frames=80"),
        ("clip.ramp=4", "clip.lead_frames=96", "clip.tail_frames=160", "clip.max_frames=900"),
    ),
)

PART = (
    Condition(
        "swing",
        "the clip runs on until the cylinder has turned round, or strikes a second time",
        ("clip.end=turn", "clip.tail_frames=60", "clip.max_frames=900"),
        ("clip.end=all", "clip.max_frames=1200"),
    ),
    Condition(
        "first_frame",
        "the cylinder swings already when the clip starts, 10 or 4 frames before it strikes",
        ("clip.lead_frames=10",),
        ("clip.lead_frames=4",),
    ),
    Condition(
        "late",
        "the clip starts after the middle or just before the second collision: not to be counted",
        ("clip.start=middle", "clip.lead_frames=0"),
        ("clip.start=second", "clip.lead_frames=1"),
    ),
    Condition(
        "early",
        "the clip ends after the middle or the last collision but one: not to be counted",
        ("clip.end=middle", "clip.tail_frames=1"),
        ("clip.end=penultimate", "clip.tail_frames=1"),
    ),
    Condition(
        "nothing",
        "nothing moves: not to be counted",
        ("clip.start=release", "clip.lead_frames=130", "clip.frames=120"),
        (
            "clip.start=release",
            "clip.lead_frames=130",
            "clip.frames=120",
            "camera.read_noise=6",
            "light.flicker_amplitude=0.1",
            "tripod.shake_px=1",
        ),
    ),
)

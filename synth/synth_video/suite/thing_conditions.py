"""Conditions of things in the picture."""

from __future__ import annotations

from synth_video.suite.condition import Condition

THINGS = (
    Condition(
        "clutter",
        "a shelf full of things behind the bodies, out of focus or sharp",
        ("background.kind=shelf", "background.blur_m=0.0015"),
        ("background.kind=shelf",),
    ),
)

"""Conditions of the bodies: other balls, and other things than ball and cylinder."""

from __future__ import annotations

from synth_video.suite.condition import Condition

_ON_A_TRACK = (
    "setup.mounting=free",
    "setup.heavy_velocity_m_s=-0.3",
    "background.kind=plaster",
    "view.width_m=0.36 | 0.42 | 0.50",
)
_HARD = ("camera.read_noise=4", "camera.shutter=1.0", "encoding.crf=32")
_BLOCKS = (
    *_ON_A_TRACK,
    "ball.shape=block",
    "ball.color=[200, 160, 110] | [120, 150, 180]",
    "ball.mark=m",
    "cylinder.shape=block",
    "cylinder.color=[150, 110, 70] | [96, 100, 108]",
    "cylinder.diameter_m=0.04",
)
_CARTS = (
    *_ON_A_TRACK,
    "ball.shape=cart",
    "ball.height_m=0.042",
    "ball.ring_color=[220, 218, 210]",
    "ball.mark=m",
    "cylinder.shape=cart",
    "cylinder.diameter_m=0.042",
    "cylinder.color=[180, 50, 44] | [44, 84, 156] | [60, 120, 70]",
)
_PUCKS = (
    *_ON_A_TRACK,
    "ball.shape=puck",
    "ball.spin_hz=0.5 | 0",
    "ball.mark_color=[240, 238, 230]",
    "cylinder.shape=puck",
    "cylinder.length_m=0.06",
    "cylinder.diameter_m=0.06",
)

BODIES = (
    Condition(
        "white",
        "a white ball before grey, or before bright plaster",
        ("ball.color=[228, 228, 224]", "background.kind=plaster"),
        (
            "ball.color=[228, 228, 224]",
            "background.kind=plaster",
            "background.color=[198, 196, 190]",
            "light.shadow=0.1",
        ),
    ),
    Condition(
        "black",
        "a black ball before grey, or before dark cloth",
        ("ball.color=[34, 34, 38]", "background.kind=plaster"),
        ("ball.color=[34, 34, 38]", "background.kind=cloth", "background.color=[70, 70, 74]"),
    ),
    Condition(
        "striped",
        "a ball of two colours, or with stripes across its way",
        ("ball.pattern=halves", "ball.mark_color=[240, 238, 230]"),
        (
            "ball.pattern=stripes",
            "ball.color=[232, 230, 224]",
            "ball.mark_color=[36, 36, 40]",
            "ball.ring=false",
        ),
    ),
    Condition(
        "spinning",
        "a ball that turns about its thread, with a print or with halves of two colours",
        ("ball.spin_hz=1 | -2", "ball.ring=false"),
        (
            "ball.spin_hz=3 | -5",
            "ball.ring=false",
            "ball.pattern=halves",
            "ball.mark_color=[240, 238, 230]",
        ),
    ),
    Condition("blocks", "wood blocks on a rail; also noisy and blurred", _BLOCKS, _BLOCKS + _HARD),
    Condition("carts", "carts on a rail; also noisy and blurred", _CARTS, _CARTS + _HARD),
    Condition("pucks", "pucks from above; also noisy and blurred", _PUCKS, _PUCKS + _HARD),
)

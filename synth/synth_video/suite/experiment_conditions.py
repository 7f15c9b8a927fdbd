"""Conditions of what is shown: other experiments, with something to count or with nothing."""

from __future__ import annotations

from synth_video.suite.condition import Condition

_HARD = ("camera.read_noise=5", "camera.shutter=1.0", "encoding.crf=32")


def _experiment(name: str, scene: str, sentence: str, *settings: str) -> Condition:
    """Film a scene as it is, and with noise, an open shutter and strong compression."""
    sentence = f"{sentence}; also noisy and blurred"
    return Condition(name, sentence, settings, (*settings, *_HARD), base=scene)


EXPERIMENTS = (
    _experiment(
        "bounce",
        "bounce",
        "a ball bounces on a table, filmed upright or with a rotation flag",
        "encoding.rotation_deg=0 | 90",
    ),
    _experiment(
        "stops",
        "two-stops",
        "a cart, a block or a puck runs to and fro between two stops",
        "ball.shape=cart | block | puck",
    ),
    _experiment("incline", "inclined-track", "a cart rebounds from the stop of an inclined track"),
    _experiment("pendulum", "pendulum-wall", "a ball on a thread swings against the wall"),
    _experiment("airtable", "pucks", "two pucks collide on a table, seen from above"),
    _experiment("twocarts", "carts", "two carts collide on a rail"),
    _experiment("twoballs", "pendulums", "two balls on threads collide, once to three times"),
    _experiment("freeswing", "free-swing", "a pendulum swings freely: not to be counted"),
    _experiment("throw", "throw", "a ball flies through the picture: not to be counted"),
    _experiment("passing", "passing", "two pendulums never touch: not to be counted"),
    _experiment("cradle", "cradle", "five balls in a row: not to be counted"),
)

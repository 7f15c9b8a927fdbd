"""Conditions of what is filmed: other bodies, things in the picture, and other experiments."""

from __future__ import annotations

from synth_video.suite.condition import Condition

# ---- bodies --------------------------------------------------------------------------------------
# Conditions of the bodies: other balls, and other things than ball and cylinder.

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


# ---- things --------------------------------------------------------------------------------------
# Conditions of things in the picture.

THINGS = (
    Condition(
        "clutter",
        "a shelf full of things behind the bodies, out of focus or sharp",
        ("background.kind=shelf", "background.blur_m=0.0015"),
        ("background.kind=shelf",),
    ),
    Condition(
        "behind",
        "boards and bars behind the bodies and across their edges; then some as bright as the ball",
        ("background.kind=boards", "background.texture=0.4", "background.blur_m=0.001"),
        (
            "background.kind=boards",
            "view.width_m=0.6 | 0.36",
            "view.wall_m=0.08",
            "ball.color=[158, 152, 146]",
            "ball.ring=false",
            'ball.mark=""',
            "ball.gloss=0.1",
        ),
    ),
    Condition(
        "second",
        "a second ball like the first lies aside, or close below the first one's way",
        (
            "things.lying_ball=true",
            "things.lying_along_m=0.22 | 0.26",
            "things.lying_up_m=-0.06",
            "background.kind=table",
        ),
        (
            "things.lying_ball=true",
            "things.lying_along_m=0.04 | 0.08 | 0.12",
            "things.lying_up_m=-0.045",
            "background.kind=table",
        ),
    ),
    Condition(
        "mirror",
        "a wall that mirrors the ball: faintly, or like a window at night",
        ("wall.reflection=0.3", "wall.mirror_m=0.02"),
        ("wall.reflection=0.7", "wall.mirror_m=0.05"),
    ),
    Condition(
        "person",
        "a person sways at the edge of the picture, up to 12 or 30 % of its width",
        ("things.person=0.12", "things.person_m_s=0.1"),
        (
            "things.person=0.30 | 0.15",
            "things.person_side=far | near",
            "things.person_m_s=0.3",
        ),
    ),
    Condition(
        "hand",
        "a hand lets the cylinder go, long or just before the first collision",
        ("things.hand_s=0.25", "clip.lead_frames=100"),
        ("things.hand_s=0.46", "clip.lead_frames=100"),
    ),
    Condition(
        "entering",
        "the cylinder comes in from outside a picture that ends 3 or 1 cm beyond the collisions",
        ("view.beyond_m=0.03",),
        ("view.beyond_m=0.01",),
    ),
    Condition(
        "cords",
        "one thin cord or three thick ones cross the picture in front of the bodies",
        ("things.cords=1", "things.cord_m=0.0008"),
        ("things.cords=3", "things.cord_m=0.0015"),
    ),
    Condition(
        "clamp",
        "a clamp at the wall hides a lower part of the ball, or its lower half and its contact",
        ("wall.clamp_m=0.006", "wall.clamp_up_m=-0.008"),
        ("wall.clamp_m=0.012", "wall.clamp_up_m=0.002"),
    ),
    Condition(
        "rim",
        "the cylinder's near rim hides the contact: 2 or 5 mm of the ball",
        ("cylinder.rim_m=0.002",),
        ("cylinder.rim_m=0.005",),
    ),
)


# ---- experiments ---------------------------------------------------------------------------------
# Conditions of what is shown: other experiments, with something to count or with nothing.

_HARD_FILMING = ("camera.read_noise=5", "camera.shutter=1.0", "encoding.crf=32")


def _experiment(name: str, scene: str, sentence: str, *settings: str) -> Condition:
    """Film a scene as it is, and with noise, an open shutter and strong compression."""
    sentence = f"{sentence}; also noisy and blurred"
    return Condition(name, sentence, settings, (*settings, *_HARD_FILMING), base=scene)


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

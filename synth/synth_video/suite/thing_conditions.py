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

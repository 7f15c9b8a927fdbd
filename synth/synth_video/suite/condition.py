"""What a condition is, and the scene that it makes of a seed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal
from zlib import crc32

from synth_video.scene import Scene
from synth_video.scene_file import load_scene
from synth_video.variation import varied

Strength = Literal["ordinary", "full"]
STRENGTHS: tuple[Strength, ...] = ("ordinary", "full")
SCENE = "suite"
PLAIN = (
    "view.width_m=0.36 | 0.32 | 0.44",
    "background.kind=table | plaster | cloth | plaster",
    "ball.color=[226, 103, 28] | [226, 226, 222] | [226, 103, 28] | [60, 110, 190] | [40, 40, 44]",
    "light.shadow=0.45 | 0.2 | 0.3 | 0.5 | 0.1 | 0.4 | 0.25",
)
"""What differs from clip to clip besides the trial; a condition may set the same anew."""


@dataclass(frozen=True)
class Condition:
    """One thing that makes footage hard to count, in two strengths.

    Settings are written ``section.key=value``. Where several values stand side by side, divided by
    ``|``, the clips take them in turn.
    """

    name: str
    sentence: str
    """What it is, for the reader of a table."""
    ordinary: tuple[str, ...]
    """Settings as people meet it now and then."""
    full: tuple[str, ...]
    """Settings at a strength that hurts."""
    suffix: str = ".mp4"
    """Container of the clips."""
    base: str = SCENE
    """Scene that it makes harder; one that is not of the suite keeps its own appearance."""

    def seed(self, number: int) -> int:
        """Seed of a clip by its number: each condition has trials of its own."""
        return crc32(self.name.encode()) % 100_000 * 1000 + number

    def scene(self, strength: Strength, number: int) -> Scene:
        """Scene of one clip: the trial is drawn by its seed, the condition laid over it.

        Raises
        ------
        UsageError
            The settings do not make a scene.
        """
        own = self.ordinary if strength == "ordinary" else self.full
        plain = PLAIN if self.base == SCENE else ()
        scene = load_scene(self.base, [choice(setting, number) for setting in (*plain, *own)])
        drawn = varied(scene, self.seed(number))
        return replace(drawn, name=f"{self.name}-{strength}", purpose=self.sentence)


def choice(setting: str, number: int) -> str:
    """Take the value of a setting that is a clip's turn."""
    key, _, values = setting.partition("=")
    turns: Sequence[str] = [value.strip() for value in values.split("|")]
    return f"{key}={turns[number % len(turns)]}"

"""The settings of a synthetic clip: one frozen record a topic, all of them together a ``Scene``.

Every field has a default, so a scene file names only what makes the scene what it is. Lengths are
metres of the apparatus, so that a scene is the same at every picture size.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from count_video.physics.setup import Setup
from synth_video.appearance import (
    BackgroundSettings,
    BallSettings,
    CylinderSettings,
    LightSettings,
    ThreadSettings,
    WallSettings,
    require,
)

ClipStart = Literal["collision", "release", "second", "middle"]
ClipEnd = Literal["middle", "penultimate", "burst", "turn", "all"]
ExperimentKind = Literal[
    "pi", "bounce", "stops", "pendulum", "pucks", "pendulums", "swing", "throw", "passing", "cradle"
]
NOTHING_TO_COUNT = ("swing", "throw", "passing", "cradle")
"""Experiments in which nothing collides, or more than can be kept apart."""
Side = Literal["far", "near"]


@dataclass(frozen=True)
class ClipSettings:
    """Which part of the trial the clip shows."""

    start: ClipStart = "collision"
    """What ``lead_frames`` precede: the first collision (the cylinder already swings), the release
    (a suspended cylinder is held until then), or the second or middle collision of the burst."""
    lead_frames: int = 24
    """Frames before the event named by ``start``."""
    end: ClipEnd = "burst"
    """What ``tail_frames`` follow: the middle, last but one or last collision of the burst, the
    turn-round, or the last of all collisions."""
    tail_frames: int = 48
    """Frames after the event named by ``end``."""
    frames: int = 0
    """Number of frames regardless of ``end``; 0 leaves it to ``end``."""
    max_frames: int = 20_000
    """A longer clip is refused: it is a mistake more often than a wish."""
    ramp: float = 1.0
    """Where the collisions are far enough apart to stay so, the export takes only one of so many
    pictures: a slow-motion clip that begins and ends faster. 1 takes all."""

    def __post_init__(self) -> None:
        require(1 <= self.ramp <= 16, "clip.ramp must lie between 1 and 16")
        for name in ("lead_frames", "tail_frames", "frames"):
            require(getattr(self, name) >= 0, f"clip.{name} must not be negative")
        require(self.max_frames >= 1, "clip.max_frames must be at least 1")


@dataclass(frozen=True)
class CameraSettings:
    """The camera: picture size, rates, optics and noise."""

    width_px: int = 640
    height_px: int = 240
    capture_fps: float = 2000.0
    """Frames per second of real time."""
    shutter: float = 0.5
    """Part of the frame interval during which the shutter is open, above 0 to 1."""
    jitter: float = 0.0
    """Largest deviation of an exposure from its time, as part of the frame interval, to 0.4."""
    tilt_deg: float = 0.0
    """Turn of the line of motion in the picture, positive when y grows with x; at most 8."""
    blur_px: float = 0.5
    """Standard deviation of the lens blur."""
    read_noise: float = 1.0
    """Standard deviation of the noise in the dark, grey levels."""
    shot_noise: float = 0.02
    """Growth of the noise variance with brightness, grey levels."""
    vignette: float = 0.15
    """Loss of brightness in the corners, 0 to 1."""

    def __post_init__(self) -> None:
        for name in ("width_px", "height_px"):
            size = getattr(self, name)
            require(32 <= size <= 8192 and size % 2 == 0, f"camera.{name} must be even, 32 to 8192")
        require(self.capture_fps > 0, "camera.capture_fps must be positive")
        require(0 < self.shutter <= 1, "camera.shutter must be above 0 and at most 1")
        require(0 <= self.jitter <= 0.4, "camera.jitter must lie between 0 and 0.4")
        require(abs(self.tilt_deg) <= 8, "camera.tilt_deg must lie between -8 and 8")
        for name in ("blur_px", "read_noise", "shot_noise"):
            require(getattr(self, name) >= 0, f"camera.{name} must not be negative")
        require(0 <= self.vignette < 1, "camera.vignette must lie between 0 and 1")


@dataclass(frozen=True)
class LensSettings:
    """Where the camera stands, and what its lens does to straight lines."""

    turn_deg: float = 0.0
    """Turn of the camera about the vertical; where it is not 0 the picture has perspective."""
    distance_m: float = 0.8
    """From the camera to what the picture's centre shows."""
    distortion: float = 0.0
    """Relative change of a corner's distance from the centre: below 0 barrel, above 0 cushion."""

    def __post_init__(self) -> None:
        require(abs(self.turn_deg) <= 30, "lens.turn_deg must lie between -30 and 30")
        require(self.distance_m > 0, "lens.distance_m must be positive")
        require(abs(self.distortion) <= 0.2, "lens.distortion must lie between -0.2 and 0.2")


@dataclass(frozen=True)
class TripodSettings:
    """How the camera moves; frequencies are cycles per second of real time."""

    shake_px: float = 0.0
    """Largest shift of the picture, to each side, by a tripod that trembles."""
    shake_low_hz: float = 5.0
    shake_high_hz: float = 20.0
    """The trembling has frequencies between these two."""
    knock_px: float = 0.0
    """First and largest swing of the picture after one knock against the tripod."""

    def __post_init__(self) -> None:
        for name in ("shake_px", "knock_px"):
            require(0 <= getattr(self, name) <= 64, f"tripod.{name} must lie between 0 and 64")
        ordered = 0 < self.shake_low_hz <= self.shake_high_hz
        require(ordered, "tripod.shake_low_hz must be positive, at most tripod.shake_high_hz")


@dataclass(frozen=True)
class ViewSettings:
    """What part of the apparatus the picture shows."""

    width_m: float = 0.305
    """Width of the picture, measured along the line of motion."""
    wall_m: float = 0.054
    """From the picture's border to the wall's face."""
    line: float = 0.42
    """Height of the line of motion: part of the picture that lies above it."""
    beyond_m: float = 0.0
    """In drawn trials the picture ends so far beyond the farthest collision, and the clip starts
    before the cylinder comes in; 0 leaves both as they are."""
    rising_path: bool = True
    """Draw suspended bodies on the arc of their threads rather than on a straight line."""

    def __post_init__(self) -> None:
        require(self.width_m > 0, "view.width_m must be positive")
        require(self.beyond_m >= 0, "view.beyond_m must not be negative")
        require(0 < self.line < 1, "view.line must lie between 0 and 1")


@dataclass(frozen=True)
class EncodingSettings:
    """The file: its container is named by the clip's suffix."""

    container_fps: float = 30.0
    """Frames per second of footage time (the playing rate)."""
    codec: str = "libx264"
    crf: int = 23
    preset: str = "superfast"
    """Speed of libx264 and libx265. From ``veryfast`` on, x264's macroblock tree takes part, whose
    decisions differ from run to run in common builds: the pictures stay, the bytes do not."""
    pixel_format: str = "yuv420p"
    rotation_deg: int = 0
    """The picture is stored turned, and the file asks for so many degrees counter-clockwise to
    show it upright, as phones do: 0, 90, 180 or 270."""
    variable_rate: bool = False
    """Each picture's footage time follows its exposure; else the rate is constant."""
    repeat_every: int = 0
    """Every so many-th picture is a copy of the one before; 0 for none."""
    repeat_lost: bool = False
    """A copy stands in for a picture that is lost; else it is put in between two."""

    def __post_init__(self) -> None:
        turns = (0, 90, 180, 270)
        require(self.rotation_deg in turns, "encoding.rotation_deg must be 0, 90, 180 or 270")
        require(self.container_fps > 0, "encoding.container_fps must be positive")
        require(
            self.repeat_every == 0 or self.repeat_every >= 2, "encoding.repeat_every is 0 or 2 up"
        )
        require(0 <= self.crf <= 63, "encoding.crf must lie between 0 and 63")


@dataclass(frozen=True)
class ExperimentSettings:
    """What happens; sizes, masses, threads and restitution are those of ``setup``.

    - ``pi``: the ball between cylinder and wall; nothing else of this section matters;
    - ``bounce``: the ball falls on a table;
    - ``stops``: it runs on a level or inclined track, against one stop or between two;
    - ``pendulum``: it swings against the wall;
    - ``pucks``: it slides toward another like it, that lies still;
    - ``pendulums``: it swings toward another like it, that hangs still;
    - ``swing``, ``throw``: it swings or flies, and meets nothing;
    - ``passing``: two like it swing toward each other and back, and never touch;
    - ``cradle``: five like it hang in a row.
    """

    kind: ExperimentKind = "pi"
    start_m: float = 0.3
    """Where the first body starts: height over the table, way to the stop or to the other body, or
    how far a pendulum is drawn aside."""
    speed_m_s: float = 0.0
    """Its velocity at the start, away from the table, the stop or the other body."""
    drift_m_s: float = 0.0
    """Its velocity across, to the right in the picture (``bounce``, ``throw``)."""
    slope: float = 0.0
    """Part of the gravity that drives it to the stop (``stops``): sine of the track's incline. The
    camera is inclined with the track."""
    span_m: float = 0.0
    """From one stop to the other (``stops``); 0 for one stop."""
    offset_m: float = 0.0
    """How far it would miss the other's centre (``pucks``); the least gap (``passing``)."""
    slow_m_s: float = 0.03
    """An impact no faster than this ends the bouncing: the body stays."""
    impacts: int = 0
    """The clip ends half-way to the impact after this one; 0 lets it run for ``duration_s``."""
    duration_s: float = 3.0
    """Longest time that is shown, from the start."""
    held_s: float = 0.0
    """The clip starts so long before the body is let go."""

    def __post_init__(self) -> None:
        for name in ("span_m", "slow_m_s", "impacts", "held_s"):
            require(getattr(self, name) >= 0, f"experiment.{name} must not be negative")
        require(0 <= self.slope <= 1, "experiment.slope must lie between 0 and 1")
        require(self.duration_s > 0, "experiment.duration_s must be positive")


@dataclass(frozen=True)
class ThingsSettings:
    """People and things that have nothing to do with the count."""

    lying_ball: bool = False
    """A second ball like the first lies on the table."""
    lying_along_m: float = 0.16
    """Its distance from the wall."""
    lying_up_m: float = -0.03
    """Height of its centre over the rest line."""
    person: float = 0.0
    """A person at the edge of the picture reaches so far into it: part of its width, 0 for none."""
    person_side: Side = "far"
    """The edge: far from the wall, or near it."""
    person_m_s: float = 0.15
    """The person's greatest speed, to and fro."""
    hand_s: float = 0.0
    """A hand holds the far part of a suspended cylinder, goes with it and lets it go so long after
    the release, in seconds; 0 for none. Before the first collision, or it would disturb it."""
    cords: int = 0
    """Number of cords that cross the picture in front of the bodies."""
    cord_m: float = 0.0012
    """Their thickness."""

    def __post_init__(self) -> None:
        require(0 <= self.person <= 0.6, "things.person must lie between 0 and 0.6")
        for name in ("person_m_s", "hand_s", "cords"):
            require(getattr(self, name) >= 0, f"things.{name} must not be negative")
        require(self.cord_m > 0, "things.cord_m must be positive")


@dataclass(frozen=True)
class Scene:
    """All that a clip depends on, apart from the seed."""

    name: str = "unnamed"
    purpose: str = ""
    """One sentence on what the scene is for."""
    experiment: ExperimentSettings = field(default_factory=ExperimentSettings)
    setup: Setup = field(default_factory=Setup)
    clip: ClipSettings = field(default_factory=ClipSettings)
    camera: CameraSettings = field(default_factory=CameraSettings)
    lens: LensSettings = field(default_factory=LensSettings)
    tripod: TripodSettings = field(default_factory=TripodSettings)
    view: ViewSettings = field(default_factory=ViewSettings)
    ball: BallSettings = field(default_factory=BallSettings)
    cylinder: CylinderSettings = field(default_factory=CylinderSettings)
    threads: ThreadSettings = field(default_factory=ThreadSettings)
    wall: WallSettings = field(default_factory=WallSettings)
    background: BackgroundSettings = field(default_factory=BackgroundSettings)
    light: LightSettings = field(default_factory=LightSettings)
    things: ThingsSettings = field(default_factory=ThingsSettings)
    encoding: EncodingSettings = field(default_factory=EncodingSettings)

"""The records that all stages share, and the conventions, stated once.

Conventions
-----------
- Frames count from 0, in the order in which they were decoded. A *frame coordinate* is a float;
  the integer k is the centre of the exposure of frame k.
- *Footage time* is what the container says (seconds at the playing rate); *real time* is what the
  camera lived through (seconds at the capture rate). Only ``count_video.answers`` converts.
- Image x points right and y down, in px; an integer is the centre of a pixel.
- A *position along the line of motion* is measured in px of image x (y for an upright line), so it
  grows to the right (downward). Metres point away from the wall; only
  ``count_video.motion.gaps`` turns one into the other.
- Not seen is NaN, never 0 or -1.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Pixels = NDArray[np.float32]
Luma = NDArray[np.uint8]
Chroma = NDArray[np.uint8]
Indices = NDArray[np.intp]
Mask = NDArray[np.bool_]
Point = tuple[float, float]
"""Image x and y in px."""
CollisionKind = Literal["bodies", "wall"]
WallSide = Literal["left", "right"]
RateSource = Literal["option", "metadata", "unknown"]
EndingKind = Literal["geometric", "pendulum", "dissipative"]

SURE = 0.9
"""A count less probable than this is given with a word of doubt, and needs a person."""


@dataclass(frozen=True)
class FootageInfo:
    """What a file says about itself before a frame is decoded."""

    path: Path
    width_px: int
    """As displayed, after rotation; so is the height."""
    height_px: int
    rotation_deg: int
    """Counter-clockwise turn that display asks for: 0, 90, 180 or 270."""
    frames_promised: int | None
    """By the container or its packets; None if neither says."""
    container_fps: float | None
    """Frames per second of footage time (the playing rate); None if not stated."""
    capture_fps: float | None
    """Frames per second of real time (the camera's rate); None if unknown."""
    capture_fps_source: RateSource


@dataclass(frozen=True)
class Frame:
    """One decoded picture, upright as displayed."""

    index: int
    """Place in decoding order, from 0; repeated pictures count."""
    luma: NDArray[np.uint8]
    """Brightness, shape (height, width), 0 to 255; 10-bit footage is rounded down to 8."""
    repeats_previous: bool
    """True for a copy of the picture before it."""
    chroma: Chroma | None = None
    """Colour, U and V, at half size, rounded up, shape (2, rows, columns); None if not stored."""


@dataclass(frozen=True)
class FootageReport:
    """What became of the file once it was decoded to the end."""

    frames_decoded: int
    frames_promised: int | None
    warnings: tuple[str, ...]
    """Sentences with numbers for the user; empty when all is well."""
    frames_missing: int = 0
    """Pictures that are known to be missing, within the clip or at its end."""


@dataclass(frozen=True)
class MotionLine:
    """The straight line along which the bodies move, in the image."""

    anchor_x_px: float
    anchor_y_px: float
    """A point of the line."""
    tilt_deg: float
    """Angle from the image's x axis (y axis where ``upright``), positive when y (x) grows."""
    upright: bool
    """True when the bodies move up and down: positions are then image y instead of image x."""


@dataclass(frozen=True)
class BodyTrack:
    """One rigid body along the line of motion; all arrays have shape (n,), one entry a frame."""

    position_px: Floats
    """Place of the body's reference point along the line; NaN where not seen."""
    sigma_px: Floats
    """Standard uncertainty of ``position_px``; NaN where not seen."""
    low_edge_px: float
    """Distance from the reference point to the outline's end at smaller positions (negative)."""
    high_edge_px: float
    """Distance from the reference point to the outline's end at larger positions (positive)."""

    def about(self, point_px: float) -> BodyTrack:
        """Refer its places to another point of it, so far from this one."""
        low_px, high_px = self.low_edge_px - point_px, self.high_edge_px - point_px
        return BodyTrack(self.position_px + point_px, self.sigma_px, low_px, high_px)


@dataclass(frozen=True)
class CameraTurns:
    """How the camera rolled and zoomed."""

    turns: Floats
    """Scale of each picture times cosine and sine of its angle, from x to y, shape (n, 2)."""
    about_px: Point

    def of(self, row: int, point: Point) -> Point:
        """Where a picture shows what would be at a point if it were not turned."""
        middle = complex(*self.about_px)
        shown = middle + complex(*self.turns[row]) * (complex(*point) - middle)
        return shown.real, shown.imag


@dataclass(frozen=True)
class Track:
    """Where the bodies were, frame by frame."""

    frame: Floats
    """Frame coordinates of the rows, shape (n,), increasing; repeated frames are left out."""
    ball: BodyTrack
    """The light body; its reference point is its centre."""
    heavy: BodyTrack | None
    """The heavy body (the cylinder); its reference point is the face turned to the ball.
    None where the clip shows one body alone."""
    wall_side: WallSide
    """``left`` when the wall stands at smaller positions than the bodies."""
    ball_diameter_px: float
    line: MotionLine
    warnings: tuple[str, ...]
    shift_px: Floats | None = None
    """How far each picture lies from where a camera at rest had shown it, by image x and y, shape
    (n, 2); positions and line are freed of it. None where the camera stood."""
    turned: CameraTurns | None = None
    """How the camera turned and scaled each picture, which comes after the shift; positions, line
    and shift are freed of it. None where it did not."""
    beside_px: Floats | None = None
    """How far a body alone is from the line, across it, by image x and y, shape (n, 2); None where
    the bodies stay on it."""
    wall_seen: bool = True
    """False where neither body bounces off anything but the other; ``wall_side`` says nothing then,
    and the ball is the body at smaller positions."""
    stamped: Floats | None = None
    """Time stamps of the rows in usual steps between them, shape (n,); None where these are even.
    """
    lost_beyond: tuple[float, ...] = ()
    """Frames beyond which, to the clip's first or last one, a body is not seen any more although it
    does not leave the picture there."""

    @property
    def bodies(self) -> tuple[BodyTrack, ...]:
        """The ball, and the heavy body if the clip shows it."""
        return (self.ball,) if self.heavy is None else (self.ball, self.heavy)


@dataclass(frozen=True)
class Velocities:
    """Velocities of the two bodies along the line of motion; NaN where unknown."""

    ball_px_frame: float
    heavy_px_frame: float
    ball_sigma_px_frame: float = math.nan
    """Standard uncertainty of the ball's; the other is the heavy body's."""
    heavy_sigma_px_frame: float = math.nan


@dataclass(frozen=True, kw_only=True)
class Collision:
    """One collision: a sign change of the relative velocity, at a contact."""

    number: int = 0
    """Counts from 1, in order of time, through the burst and beyond it; 0 before the answer."""
    kind: CollisionKind
    frame: float
    """Frame coordinate of the contact."""
    frame_sigma: float
    """Standard uncertainty of ``frame`` in frames."""
    time_s: float | None = None
    """Real time since frame 0; None while the capture rate is unknown."""
    seen: bool
    """True if the frames show it; False if it is inferred between frames."""
    position_px: float
    """Place of the ball's centre along the line of motion."""
    velocity_before: Velocities
    velocity_after: Velocities

    @property
    def push(self) -> float:
        """Sign of what it adds to the ball's velocity, of as much as is known; 0 if nothing is."""
        before, after = (v.ball_px_frame for v in (self.velocity_before, self.velocity_after))
        return float(np.sign(np.nan_to_num(after) - np.nan_to_num(before)))


SAME_COLLISION_FRAMES = 1.0
"""A collision is the one that a person meant if it has the kind and lies this close: another
version of the tool may place it a little differently, and give it another number."""


@dataclass(frozen=True)
class Correction:
    """What a person changed who checked the frames."""

    action: Literal["wrong", "missed"]
    """``wrong`` takes a collision of the tool away, ``missed`` adds one."""
    kind: CollisionKind
    frame: float
    """Frame coordinate of the contact."""
    number: int | None
    """Number of the collision that is wrong; None for one that was missed."""
    changes_count: bool
    """False where the collision lies beyond the burst."""


@dataclass(frozen=True)
class Estimate:
    """A measured number, and its standard uncertainty in the same unit."""

    value: float
    sigma: float


@dataclass(frozen=True)
class Ending:
    """How a burst ended."""

    kind: EndingKind
    """``geometric``: ball and heavy body move away, the ball no faster, and nothing can follow;
    ``pendulum``: the threads turn the heavy body before the ball, on its way, meets anything;
    ``dissipative``: the energy is used up."""
    energy_kept: float
    """Energy after the last collision over that before the first: of both bodies' motion and, on
    their threads, of their height."""
    heavy_speed: float
    """Velocity of the heavy body after the last collision, away from the wall, over its speed
    before the first."""
    ball_speed: float
    """That of the ball; between 0 and ``heavy_speed`` in the stopping region."""


@dataclass(frozen=True)
class FittedSetup:
    """How the bodies hung and where the heavy one was let go, by the fitted model."""

    gap_px: Estimate
    """Distance from the wall to the ball where it hangs at rest."""
    release_px: Estimate
    """Distance from where the heavy body hangs to where it was let go: its amplitude."""
    bodies_gap_px: Estimate
    """Between ball and heavy body where both hang at rest; negative where they would overlap."""
    heavy_period_frames: Estimate
    """Time of a full swing of the heavy body on its threads."""
    ball_period_frames: Estimate
    """Time of a full swing of the ball."""


@dataclass(frozen=True)
class ComparedQuantity:
    """One quantity of a planned set-up, and what was found of it."""

    name: str
    """``gap_mm``, ``release_mm``, ``bodies_gap_mm``, ``heavy_period_s``, ``ball_period_s``,
    ``mass_ratio``, ``restitution_bodies`` or ``restitution_wall``."""
    planned: float
    found: Estimate
    count: int | None
    """Count of the planned set-up with this quantity alone as it was found; None if there is no
    such set-up."""


@dataclass(frozen=True)
class PlanComparison:
    """What was planned beside what was counted and fitted."""

    planned_count: int
    theory: int
    """Exact count of the planned masses."""
    found_count: int | None
    """Count of a simulated trial with the set-up that was found; None where none was fitted."""
    quantities: tuple[ComparedQuantity, ...]
    explained_by: tuple[str, ...]
    """Names of the quantities of which each alone turns the planned count into the counted one, the
    surest difference first; all names if only all together do; empty if nothing is to be explained
    or nothing explains it."""


@dataclass(frozen=True)
class TrialResult:
    """The answer for one clip: what ``count-video`` prints; None is what is not known."""

    clip: str
    status: Literal["counted", "not_counted"]
    reason: str | None
    """Why the clip is not counted, or what is doubtful; None if all is well."""
    what_to_do: str | None = None
    count: int | None = None
    """Collisions of the first burst; None unless counted."""
    seen: int | None = None
    between_frames: int | None = None
    probability: dict[int, float] = field(default_factory=dict)
    """Probability of each count, as far as the evidence goes; empty if none comes into question."""
    count_after_burst: int | None = None
    collisions: tuple[Collision, ...] = ()
    """All collisions found; those of the burst first (numbers 1 to ``count``)."""
    capture_fps: float | None = None
    capture_fps_source: RateSource = "unknown"
    even_rate: bool = True
    """False where the rate of the frames changes within the clip."""
    frames_decoded: int | None = None
    frames_promised: int | None = None
    wall_side: WallSide | None = None
    """Along the line of motion; of bodies that move up and down "left" is above."""
    upright: bool | None = None
    """Whether the bodies move up and down; None where none is followed."""
    ball_diameter_px: float | None = None
    millimetres_per_px: float | None = None
    """Scale from the ball's diameter."""
    pi_low: float | None = None
    """Bounds on pi from the count: N times theta and (N + 1) times theta."""
    pi_high: float | None = None
    mass_ratio: float | None = None
    """Heavy over light; given by the user or measured from the motion."""
    mass_ratio_sigma: float | None = None
    """Standard uncertainty of the mass ratio; None where it is given, or not known."""
    contradicting_ratio: Estimate | None = None
    """What the motion shows where it contradicts the masses given."""
    energy_kept: tuple[float, ...] = ()
    """Energy after each collision of the burst over that before the first; empty if not known."""
    restitution_bodies: Estimate | None = None
    restitution_wall: Estimate | None = None
    ending: Ending | None = None
    setup: FittedSetup | None = None
    """By the fitted model."""
    warnings: tuple[str, ...] = ()
    reviewed_count: int | None = None
    """The count after a person's corrections; None where nobody reviewed the clip."""
    corrections: tuple[Correction, ...] = ()
    notes: dict[str, str] = field(default_factory=dict)
    """What a person wrote on the clip (its key is empty) and on collisions (NUMBER/KIND/FRAME; the
    number of one that was missed is +)."""
    comparison: PlanComparison | None = None
    """With the plan that was given."""

    @property
    def ratio(self) -> Estimate | None:
        """The mass ratio, with an uncertainty of 0 where none is known; None if it is not known."""
        ratio = self.mass_ratio
        return None if ratio is None else Estimate(ratio, self.mass_ratio_sigma or 0.0)

    @property
    def chance(self) -> float | None:
        """Probability of the count; None where there is none."""
        return None if self.count is None else self.probability.get(self.count)

    @property
    def burst_size(self) -> int:
        """How many of the collisions found belong to the burst, counted or not."""
        return self.count if self.count is not None else self.seen or 0

    @property
    def beyond_burst(self) -> tuple[Collision, ...]:
        """The collisions found that do not belong to it."""
        return tuple(c for c in self.collisions if c.number > self.burst_size)

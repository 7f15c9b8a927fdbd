"""States and energies after each collision, drawn as the phase circle and against the number.

The coordinates are those of G. Galperin (Playing pool with pi, 2003): V1 = sqrt(M) v1 and
V2 = sqrt(m) v2, in which every collision without loss is a reflection and the energy is the square
of the distance from the origin.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Wedge
from matplotlib.ticker import MaxNLocator

from count_video.physics.theory import Mass, collision_count, state_points, theta_rad
from count_video.planning.comparison import expected_counts
from count_video.records import Floats
from count_video.reports.drawing import (
    BALL,
    BARS,
    BLACK,
    BLUE,
    GREEN,
    GREY,
    HEAVY,
    MARKS,
    PAPER,
    SKY_BLUE,
    VERMILION,
    WHITE,
    number_marks,
)
from count_video.reports.material import Material
from count_video.reports.words import counts_words

MOST_POINTS = 700
"""More points than this cannot be seen one by one; the circle is then drawn alone."""
REACH = 1.24
"""Half the side of the panel, in radii."""
MOST_STATES = 45
"""Where there are more states than this, only every fifth is numbered."""
SWING_WORTH_A_WORD = 0.05
"""Share of the energy in the swing from which on it is mentioned."""


@dataclass(frozen=True)
class States:
    """The state before the first collision of the burst and after each; arrays have shape (n,)."""

    number: Floats
    """0 before the first collision, then the collision's number."""
    scaled_heavy: Floats
    """V1 = sqrt(M) v1, away from the wall, in units of the first state's length; NaN if unknown."""
    scaled_light: Floats
    """V2 = sqrt(m) v2, likewise."""
    heavy_sigma: Floats
    """Standard uncertainty of V1, in the same unit, which counts as exact; NaN if unknown."""
    light_sigma: Floats
    """Standard uncertainty of V2, likewise."""
    swing_energy: Floats
    """Energy stored in the heavy body's swing, in units of the first state's kinetic energy and
    counted from there; 0 where the swing is not known."""


def measured_states(material: Material) -> States | None:
    """States of the burst; None where the mass ratio or the first state is not known."""
    burst, ratio = material.burst, material.result.mass_ratio
    if not burst or ratio is None:
        return None
    velocities = [burst[0].velocity_before, *(c.velocity_after for c in burst)]
    heavy, light, heavy_sigma, light_sigma = np.array(
        [
            (v.heavy_px_frame, v.ball_px_frame, v.heavy_sigma_px_frame, v.ball_sigma_px_frame)
            for v in velocities
        ]
    ).T * np.array([[math.sqrt(ratio)], [1.0]] * 2)
    length = math.hypot(heavy[0], light[0])
    if not (length > 0 and math.isfinite(length)):
        return None
    times = np.array([burst[0].frame, *(c.frame for c in burst)])
    swing = _swing_energy(material, times) * ratio
    return States(
        number=np.arange(len(velocities), dtype=np.float64),
        scaled_heavy=material.outward * heavy / length,
        scaled_light=material.outward * light / length,
        heavy_sigma=heavy_sigma / length,
        light_sigma=light_sigma / length,
        swing_energy=(swing - swing[0]) / length**2,
    )


def _swing_energy(material: Material, frames: Floats) -> Floats:
    """Twice the potential energy of the heavy body a unit of its mass, in (px/frame) squared."""
    pendulum, heavy = material.pendulum, material.track.heavy
    if pendulum is None or heavy is None or not np.isfinite(heavy.position_px).any():
        return np.zeros_like(frames)
    seen = np.isfinite(heavy.position_px)
    face = np.interp(frames, material.track.frame[seen], heavy.position_px[seen])
    return pendulum.rate_squared * (face * material.outward - pendulum.centre_px) ** 2


# ---- phase circle ------------------------------------------------------------------------------


def draw_phase_circle(
    axes: Axes,
    heavy: Mass,
    light: Mass,
    count: int,
    *,
    lines: tuple[str, float] = (VERMILION, 0.7),
    points: bool = True,
) -> Floats:
    """Draw the theory into a panel and return its state points, shape (n, 2); n = 0 if too many.

    The momentum lines have slope -sqrt(M/m), the stopping region lies between the V1 axis and
    the line of slope sqrt(m/M) through the centre.

    Parameters
    ----------
    lines
        Colour and opacity of the momentum lines.
    points
        Draw the state points themselves.
    """
    theta = theta_rad(heavy, light)
    edge = 1.12 * np.array([[0, np.cos(theta)], [0, np.sin(theta)]])
    opening = float(np.degrees(theta))
    axes.add_patch(Wedge((0, 0), 1.0, 0.0, opening, color=SKY_BLUE, alpha=0.35, gid="stopping"))
    axes.plot(*edge, color=SKY_BLUE, linewidth=1.2)
    axes.add_patch(Circle((0, 0), 1.0, fill=False, edgecolor=BLACK, linewidth=1.3, gid="circle"))
    axes.axhline(0.0, color=GREY, linewidth=0.7, zorder=0)
    axes.axvline(0.0, color=GREY, linewidth=0.7, zorder=0)
    states = state_points(heavy, light) if count < MOST_POINTS else np.empty((0, 2))
    for step in range(1, len(states)):
        # Momentum lines slant (odd steps), mirrors at the wall are upright and dashed (even ones).
        gid, colour, dashes = (
            ("momentum", lines[0], "-") if step % 2 else ("mirror", GREY, (0, (3, 2)))
        )
        style: Any = {"color": colour, "linestyle": dashes, "linewidth": 1.0, "alpha": lines[1]}
        axes.plot(*states[step - 1 : step + 1].T, zorder=1, gid=gid, **style)
    if points and len(states):
        axes.plot(*states.T, "o", color=BLACK, markersize=5, gid="state points")
    axes.set(xlim=(-REACH, REACH), ylim=(-REACH, REACH), aspect="equal")
    axes.set_xlabel(r"$V_1 = \sqrt{M}\,v_1$  (in units of the first state)")
    axes.set_ylabel(r"$V_2 = \sqrt{m}\,v_2$")
    return states


def draw_states(axes: Axes, material: Material) -> None:
    """Draw the phase circle: theory and measurement; a sentence where the ratio is not known."""
    axes.set_title("Phase circle: theory (lines) and measured states")
    states, ratio = measured_states(material), material.result.mass_ratio
    expected = expected_counts(material.result)
    if states is None or ratio is None or expected is None:
        _say_instead(axes, material)
        return
    count = collision_count(ratio)
    draw_phase_circle(axes, ratio, 1, count, lines=(GREY, 0.55), points=False)
    points = np.column_stack([states.scaled_heavy, states.scaled_light])
    _draw_points(axes, material, points, np.column_stack([states.heavy_sigma, states.light_sigma]))
    step = 1 if len(points) <= MOST_STATES else 5
    length = np.maximum(np.hypot(*points.T), 1e-9)[:, None]
    texts = [f"{k:.0f}" if k % step == 0 else "" for k in states.number]
    number_marks(axes, points, texts, points / length, size=9)
    words = f"M : m = {ratio:.4g} : 1\ntheory counts {counts_words(*expected.free)}"
    axes.text(0.0, 0.06, words, ha="center", va="bottom", fontsize=11, bbox=PAPER)
    axes.text(0.5, -0.03, "stops here", ha="center", va="top", fontsize=9, color=BLUE)
    if float(states.swing_energy.max()) > SWING_WORTH_A_WORD:
        words = "inside the circle: the swing\nholds part of the energy"
        axes.text(0.0, -0.12, words, ha="center", va="top", fontsize=9, bbox=PAPER)


def _draw_points(axes: Axes, material: Material, points: Floats, sigmas: Floats) -> None:
    """Draw the measured states, their uncertainties and the kinds that led to them, (n, 2) each."""
    (x, y), (x_sigma, y_sigma) = points.T, sigmas.T
    if np.isfinite(sigmas).any():
        axes.errorbar(x, y, y_sigma, x_sigma, fmt="none", ecolor=GREY, zorder=3, **BARS)
    axes.plot(*points[0], "^", color=BLACK, markersize=8, gid="state", zorder=4)
    kinds = np.array([None, *(collision.kind for collision in material.burst)])
    for kind, mark in MARKS.items():
        chosen = points[kinds == kind]
        if len(chosen):
            style: Any = {"color": mark.colour, "markeredgecolor": WHITE, "markersize": 7}
            axes.plot(*chosen.T, mark.shape, gid="state", zorder=4, **style)


def _say_instead(axes: Axes, material: Material) -> None:
    """Fill a panel that cannot be drawn with the reason."""
    one = material.track.heavy is None
    reason = "one body alone" if one else "needs the mass ratio:\ngive --masses HEAVY LIGHT"
    axes.set_axis_off()
    axes.text(0.5, 0.5, reason, transform=axes.transAxes, ha="center", va="center", fontsize=12)


# ---- energy ------------------------------------------------------------------------------------


def draw_energy(axes: Axes, material: Material) -> None:
    """Draw each share of the energy against the collision's number, in % of the first state's."""
    axes.set_title("Energy after each collision; bars: uncertainty")
    states = measured_states(material)
    if states is None:
        _say_instead(axes, material)
        return
    for label, shape, colour, (share, sigma) in _energies(states, material):
        style: Any = {"fmt": f"{shape}-", "color": colour, "ms": 4, "label": label, **BARS}
        drawn = axes.errorbar(
            states.number, share, sigma, lw=2.0 if colour == BLACK else 1.5, **style
        )
        drawn.lines[0].set_gid("total" if colour == BLACK else label)
    axes.axhline(100.0, color=BLACK, linewidth=0.7, linestyle=":")
    axes.set_xlabel("after collision number (0: before the first)")
    axes.set_ylabel("energy (% of the first state's)")
    axes.set_ylim(min(0.0, 110 * float(min(states.swing_energy))), 138.0)
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.legend(loc="upper center", ncols=2, fontsize=9)


def _energies(
    states: States, material: Material
) -> list[tuple[str, str, str, tuple[Floats, Floats]]]:
    """Label, mark, colour, and the share with its uncertainty in %, of each kind of energy.

    Uncertainties are propagated to first order (JCGM 100:2008, 5.1.2): that of a square is twice
    the value times its own. The two bodies' are taken as independent.
    """
    heavy, light = 100 * states.scaled_heavy**2, 100 * states.scaled_light**2
    heavy_sigma = 200 * np.abs(states.scaled_heavy) * states.heavy_sigma
    light_sigma = 200 * np.abs(states.scaled_light) * states.light_sigma
    swing, both_sigma = 100 * states.swing_energy, np.hypot(heavy_sigma, light_sigma)
    shares = [
        ("cylinder, moving", "s", HEAVY, (heavy, heavy_sigma)),
        ("ball, moving", "o", BALL, (light, light_sigma)),
        ("raised by the swing", "^", GREEN, (swing, np.zeros_like(swing))),
        ("all together", "D", BLACK, (heavy + light + swing, both_sigma)),
    ]
    if material.pendulum is None:
        unknown = "both together; the swing is not known"
        return [*shares[:2], (unknown, "D", BLACK, (heavy + light, both_sigma))]
    return shares

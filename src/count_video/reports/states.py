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
    """The state before the first collision of the burst and after each; n states."""

    scaled: Floats
    """V1 = sqrt(M) v1 and V2 = sqrt(m) v2, away from the wall, in units of the first state's
    length, shape (2, n); NaN if unknown."""
    sigma: Floats
    """Standard uncertainties of these, in the same unit, which counts as exact; NaN if unknown."""
    swing_energy: Floats
    """Energy stored in the heavy body's swing, in units of the first state's kinetic energy and
    counted from there, shape (n,); 0 where the swing is not known."""


def measured_states(material: Material) -> States | None:
    """States of the burst; None where the mass ratio or the first state is not known."""
    burst, ratio = material.burst, material.result.mass_ratio
    if not burst or ratio is None:
        return None
    velocities = [burst[0].velocity_before, *(c.velocity_after for c in burst)]
    roots = np.array([[math.sqrt(ratio)], [1.0]])
    scaled = roots * np.transpose([(v.heavy_px_frame, v.ball_px_frame) for v in velocities])
    sigma = roots * np.transpose(
        [(v.heavy_sigma_px_frame, v.ball_sigma_px_frame) for v in velocities]
    )
    length = math.hypot(*scaled[:, 0])
    if not (length > 0 and math.isfinite(length)):
        return None
    swing = np.zeros(len(velocities))
    heavy, pendulum = material.track.heavy, material.pendulum
    if pendulum is not None and heavy is not None and np.isfinite(heavy.position_px).any():
        times, seen = [burst[0].frame, *(c.frame for c in burst)], np.isfinite(heavy.position_px)
        face = np.interp(times, material.track.frame[seen], heavy.position_px[seen])
        height = (face * material.outward - pendulum.centre_px) ** 2
        swing = ratio * pendulum.rate_squared * (height - height[0]) / length**2
    return States(material.outward * scaled / length, sigma / length, swing)


def draw_phase_circle(
    axes: Axes,
    heavy: Mass,
    light: Mass,
    count: int,
    *,
    lines: tuple[str, float] = (VERMILION, 0.7),
) -> Floats:
    """Draw the theory into a panel and return its state points, shape (n, 2); n = 0 if too many.

    The momentum lines have slope -sqrt(M/m), the stopping region lies between the V1 axis and
    the line of slope sqrt(m/M) through the centre. ``lines`` are colour and opacity of the momentum
    lines.
    """
    theta = theta_rad(heavy, light)
    opening = float(np.degrees(theta))
    axes.add_patch(Wedge((0, 0), 1.0, 0.0, opening, color=SKY_BLUE, alpha=0.35, gid="stopping"))
    axes.plot([0, 1.12 * np.cos(theta)], [0, 1.12 * np.sin(theta)], color=SKY_BLUE, linewidth=1.2)
    axes.add_patch(Circle((0, 0), 1.0, fill=False, edgecolor=BLACK, linewidth=1.3, gid="circle"))
    axes.axhline(0.0, color=GREY, linewidth=0.7, zorder=0)
    axes.axvline(0.0, color=GREY, linewidth=0.7, zorder=0)
    states = state_points(heavy, light) if count < MOST_POINTS else np.empty((0, 2))
    for step in range(1, len(states)):
        # Momentum lines slant (odd steps), mirrors at the wall are upright and dashed (even ones).
        odd = step % 2
        style: Any = {"color": lines[0] if odd else GREY, "linestyle": "-" if odd else (0, (3, 2))}
        style |= {"gid": "momentum" if odd else "mirror", "linewidth": 1.0, "alpha": lines[1]}
        axes.plot(*states[step - 1 : step + 1].T, zorder=1, **style)
    axes.set(xlim=(-REACH, REACH), ylim=(-REACH, REACH), aspect="equal", anchor="N")
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
    draw_phase_circle(axes, ratio, 1, collision_count(ratio), lines=(GREY, 0.55))
    x, y = states.scaled
    if np.isfinite(states.sigma).any():
        x_sigma, y_sigma = states.sigma
        axes.errorbar(x, y, y_sigma, x_sigma, fmt="none", ecolor=GREY, zorder=3, **BARS)
    axes.scatter(x[0], y[0], s=64, marker="^", color=BLACK, gid="state", zorder=4)
    for kind, mark in MARKS.items():
        chosen = [k for k, c in enumerate(material.burst, 1) if c.kind == kind]
        style: Any = {"s": 49, "marker": mark.shape, "color": mark.colour, "edgecolor": WHITE}
        axes.scatter(x[chosen], y[chosen], gid="state", zorder=4, **style)
    step = 1 if len(x) <= MOST_STATES else 5
    places = [(float(x[k]), float(y[k])) for k in range(len(x))]
    number_marks(axes, [(str(k), places[k], places[k]) for k in range(0, len(x), step)], size=9)
    words = f"M : m = {ratio:.4g} : 1\ntheory counts {counts_words(*expected.free)}"
    axes.text(0.0, 0.06, words, ha="center", va="bottom", fontsize=11, bbox=PAPER)
    axes.text(0.5, -0.03, "stops here", ha="center", va="top", fontsize=9, color=BLUE)
    if float(states.swing_energy.max()) > SWING_WORTH_A_WORD:
        words = "inside the circle: the swing\nholds part of the energy"
        axes.text(0.0, -0.12, words, ha="center", va="top", fontsize=9, bbox=PAPER)


def _say_instead(axes: Axes, material: Material) -> None:
    """Fill a panel that cannot be drawn with the reason."""
    one = material.track.heavy is None
    reason = "one body alone" if one else "needs the mass ratio:\ngive --masses HEAVY LIGHT"
    axes.set_axis_off()
    axes.text(0.5, 0.5, reason, transform=axes.transAxes, ha="center", va="center", fontsize=12)


def draw_energy(axes: Axes, material: Material) -> None:
    """Draw each share of the energy against the collision's number, in % of the first state's.

    Uncertainties are propagated to first order (JCGM 100:2008, 5.1.2): that of a square is twice
    the value times its own. The two bodies' are taken as independent.
    """
    axes.set_title("Energy after each collision; bars: uncertainty")
    states = measured_states(material)
    if states is None:
        _say_instead(axes, material)
        return
    swing = 100 * states.swing_energy
    moving, sigma = 100 * states.scaled**2, 200 * np.abs(states.scaled) * states.sigma
    known = material.pendulum is not None
    whole = "all together" if known else "both together; the swing is not known"
    for label, shape, colour, energy, bar in (
        ("cylinder, moving", "s", HEAVY, moving[0], sigma[0]),
        ("ball, moving", "o", BALL, moving[1], sigma[1]),
        *([("raised by the swing", "^", GREEN, swing, 0.0 * swing)] if known else []),
        (whole, "D", BLACK, moving.sum(axis=0) + swing, np.hypot(*sigma)),
    ):
        style: Any = {"fmt": f"{shape}-", "color": colour, "ms": 4, "label": label, **BARS}
        drawn = axes.errorbar(np.arange(len(energy)), energy, bar, **style)
        drawn.lines[0].set_gid("total" if label == whole else label)
    axes.axhline(100.0, color=BLACK, linewidth=0.7, linestyle=":")
    axes.set_xlabel("after collision number (0: before the first)")
    axes.set_ylabel("energy (% of the first state's)")
    axes.set_ylim(min(0.0, 1.1 * float(swing.min())), 138.0)
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.legend(loc="upper center", ncols=2, fontsize=9)

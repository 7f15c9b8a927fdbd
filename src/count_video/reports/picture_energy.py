"""The panel with the energy after each collision."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from count_video.reports.material import Material
from count_video.reports.palette import BALL, BLACK, GREEN, HEAVY
from count_video.reports.phase import measured_states
from count_video.reports.picture_phase import say_instead, why_no_states


def draw_energy(axes: Axes, material: Material) -> None:
    """Draw each share of the energy against the collision's number, in % of the first state's."""
    axes.set_title("Energy after each collision")
    states = measured_states(material)
    if states is None:
        say_instead(axes, why_no_states(material))
        return
    heavy, light = 100 * states.scaled_heavy**2, 100 * states.scaled_light**2
    swing = 100 * states.swing_energy
    axes.plot(states.number, heavy, "s-", color=HEAVY, markersize=4, label="cylinder, moving")
    axes.plot(states.number, light, "o-", color=BALL, markersize=4, label="ball, moving")
    if material.pendulum is not None:
        axes.plot(
            states.number, swing, "^-", color=GREEN, markersize=4, label="raised by the swing"
        )
    axes.plot(
        states.number,
        heavy + light + swing,
        "D-",
        color=BLACK,
        markersize=4,
        linewidth=2,
        label="all together" if material.pendulum else "both together; the swing is not known",
        gid="total",
    )
    axes.axhline(100.0, color=BLACK, linewidth=0.7, linestyle=":")
    axes.set_xlabel("after collision number (0: before the first)")
    axes.set_ylabel("energy (% of the first state's)")
    axes.set_ylim(min(0.0, 1.1 * float(min(swing))), 138.0)
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.legend(loc="upper center", ncols=2, fontsize=9)

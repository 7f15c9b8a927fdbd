"""Count the collisions in slow-motion footage of the "pi by collisions" experiment."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from typing import Unpack

    from count_video.physics.theory import Mass
    from count_video.planning.request import PlanDetails
    from count_video.planning.whole import Plan

__version__ = "0.1.0"


def plan(heavy: Mass, light: Mass, *, chart: bool = True, **details: Unpack[PlanDetails]) -> Plan:
    """Say what a set-up will count before it is filmed, as ``count-video --plan`` does.

    Parameters
    ----------
    heavy, light
        The two masses in any one unit.
    chart
        Work out the map as well.
    details
        ``gap_m``, ``release_m``, ``heavy_thread_m``, ``light_thread_m`` and ``ball_diameter_m`` in
        metres, ``capture_fps``, ``restitution``, ``damping_per_s``, ``tolerances`` (a record
        ``count_video.planning.request.Tolerances``), ``trials`` and ``seed``: the fields of
        ``count_video.planning.request.PlanRequest``, which has their defaults.

    Raises
    ------
    UsageError
        If a value makes no sense; the message is one line.
    """
    # Imported here because whoever imports the package need not want a plan.
    from count_video.planning.request import PlanRequest  # noqa: PLC0415
    from count_video.planning.whole import make_plan  # noqa: PLC0415

    return make_plan(PlanRequest(heavy, light, **details), with_chart=chart)

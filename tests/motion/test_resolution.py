from __future__ import annotations

from made_collisions import collision

from count_video.motion.seen import unresolved
from count_video.reasons import Cause


def test_two_collisions_of_a_kind_in_a_row_lack_one_of_the_other() -> None:
    kinds = {"wall": Cause.BODY_MISSED, "bodies": Cause.WALL_MISSED}
    for kind, cause in kinds.items():
        missing = unresolved([collision(kind, frame) for frame in (20.0, 80.0)], 1.0)

        assert [reason.cause for reason in missing] == [cause]


def test_collisions_that_follow_each_other_too_fast_are_unresolved() -> None:
    missing = unresolved([collision("bodies", 20.0), collision("wall", 22.0)], 1.0)

    assert [reason.cause for reason in missing] == [Cause.UNRESOLVED]

"""Count one clip, say what the theory expects, and keep the evidence.

python examples/one_clip.py CLIP [HEAVY LIGHT]
"""

from __future__ import annotations

import sys

import count_video


def main(clip: str, *masses: float) -> None:
    """Print the count of a clip and write its page, picture and tables into a folder here."""
    result = count_video.count(clip, masses=(masses[0], masses[1]) if masses else None)
    print(result.text())
    print()
    if result.mass_ratio is not None:
        expected = count_video.theory(result.mass_ratio.value)
        print(f"  theory: {expected.count} collisions of free bodies at this mass ratio")
    collisions = result.collisions_table()
    for kind in ("bodies", "wall"):
        errors = collisions["frame_sigma"][collisions["kind"] == kind]
        if len(errors):
            print(f"  {kind}: times are known to {errors.max():.2f} frames or better")
    files = result.save("evidence")
    print("  written:", *(file.name for file in files))


if __name__ == "__main__":
    if len(sys.argv) not in (2, 4):
        raise SystemExit(__doc__)
    try:
        given = [float(mass) for mass in sys.argv[2:]]
    except ValueError as error:
        raise SystemExit("HEAVY and LIGHT must be two numbers, for example 16 1") from error
    try:
        main(sys.argv[1], *given)
    except count_video.CountVideoError as error:
        raise SystemExit(str(error)) from error

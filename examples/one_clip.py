"""Count one clip, say what the theory expects, and keep the evidence.

python examples/one_clip.py CLIP [HEAVY LIGHT]
"""

from __future__ import annotations

import sys

import count_video


def main(clip: str, *masses: str) -> None:
    """Print the count of a clip and write its page, picture and tables into a folder here."""
    given = (float(masses[0]), float(masses[1])) if masses else None
    result = count_video.count(clip, masses=given)
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
        main(*sys.argv[1:])
    except (count_video.CountVideoError, ValueError) as error:
        raise SystemExit(str(error)) from error

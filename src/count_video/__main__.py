"""The beginning of the command ``count-video``, which is ``python -m count_video`` as well."""

from __future__ import annotations

import sys


def run() -> None:
    """Run the command; Ctrl-C ends it in one line, also while it is being loaded."""
    try:
        from count_video import cli  # noqa: PLC0415
    except KeyboardInterrupt:
        sys.stderr.write("count-video: interrupted\n")  # noqa: TID251 - of the command
        sys.exit(130)
    cli.run()


if __name__ == "__main__":
    run()

"""``python -m count_video`` is the command ``count-video``."""

from __future__ import annotations

from count_video.cli import run

run()

"""``python -m synth_video``: the command without an installed script."""

from synth_video.cli import run

run()

"""The command with the work on a clip replaced; see ``stub_work.py``.

Workers import this file again as they start, so the replacement holds in them too.
"""

from __future__ import annotations

from stub_work import work_through

from count_video import cli, pipeline
from count_video.batch import executor

# One version, whoever edits the tool while the tests run. What asks for it is imported later.
executor.tool_version = lambda: "stub"  # type: ignore[assignment]
pipeline.work_through = work_through  # type: ignore[assignment]

if __name__ == "__main__":
    cli.run()

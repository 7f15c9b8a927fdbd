"""A stub campaign as a fixture."""

from __future__ import annotations

from pathlib import Path

import pytest
from stub_campaign import StubCampaign


@pytest.fixture
def campaign(tmp_path: Path) -> StubCampaign:
    """Return an empty campaign in a folder of its own."""
    return StubCampaign(tmp_path)

"""A page that is open in a browser, and what it complained about."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from playwright import sync_api

PHONE = {"width": 390, "height": 844}
DESK = {"width": 1280, "height": 900}
LINES_OF_OPTIONS = """() => [...document.querySelectorAll(".option")].map(
  (option) => [option.textContent, option.getClientRects().length])"""
"""Each option of a command that a page shows, and on how many lines it stands."""
PATIENCE = 200
"""Waits of 50 ms each: what should happen at once may take long on a busy machine."""


@dataclass
class Visit:
    """One open page."""

    page: sync_api.Page
    complaints: list[str] = field(default_factory=list)
    requests: list[str] = field(default_factory=list)

    def text(self, name: str) -> str:
        return self.page.locator(f"#{name}").inner_text()

    def wait_until(self, condition: str) -> None:
        """Ask from outside: the page's own rules forbid to evaluate text in it again and again."""
        for _ in range(PATIENCE):
            if self.page.evaluate(condition):
                return
            self.page.wait_for_timeout(50)
        pytest.fail(f"never true: {condition}")

    def wait_for_text(self, name: str, text: object) -> None:
        self.wait_until(f"document.getElementById('{name}').textContent === '{text}'")


def open_page(
    browser: sync_api.Browser, path: Path, size: dict[str, int], scheme: str = "light"
) -> Visit:
    page = browser.new_page(viewport=size, color_scheme=scheme)
    visit = Visit(page)
    page.on(
        "console",
        lambda message: (
            visit.complaints.append(message.text) if message.type in ("error", "warning") else None
        ),
    )
    page.on("pageerror", lambda error: visit.complaints.append(str(error)))
    page.on("request", lambda request: visit.requests.append(request.url))
    page.goto(path.as_uri())
    if page.locator("#video").count():
        visit.wait_until("document.getElementById('video').readyState >= 2")
    return visit

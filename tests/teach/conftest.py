"""One server and one browser for all visits of a file."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

from tests.teach.hand import browser
from tests.teach.made import Server, served
from tests.teach.visit import DESK, opened


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    from subgoal.teach.server import warm_up

    warm_up()
    with served(tmp_path_factory.mktemp("projects")) as made:
        yield made


@pytest.fixture(scope="module")
def chromium() -> Iterator[Any]:
    with browser() as made:
        yield made


@pytest.fixture
def page(chromium: Any, server: Server) -> Iterator[Any]:
    """An empty page; anything that the browser complains of fails the test."""
    with opened(chromium, server, viewport=DESK) as made:
        yield made

"""Fixtures of these tests."""

from types import SimpleNamespace

import pytest


@pytest.fixture
def here(tmp_path, monkeypatch):
    """Two folders, so that the same relative paths can be given to command and module."""
    for name in ("command", "python"):
        (tmp_path / name).mkdir()
    return SimpleNamespace(
        command=tmp_path / "command",
        python=tmp_path / "python",
        enter=lambda name: monkeypatch.chdir(tmp_path / name),
    )

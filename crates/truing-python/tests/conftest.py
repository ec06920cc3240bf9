"""Where the committed cases and the command line are."""

import os
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture(scope="session")
def fixtures():
    return ROOT / "fixtures"


@pytest.fixture(scope="session")
def program():
    """The command line of the same build; whoever runs the tests says where it is."""
    return os.environ["TRUING"]

"""What the originals' own code made of inputs that the tests draw."""

import json

import pytest
import torch
from originals import FIXTURES


@pytest.fixture(scope="session")
def original():
    """original(project, case): the numbers, as float64 tensors by name. The file says version, commit and function."""
    files = {path.stem: json.loads(path.read_text()) for path in FIXTURES.glob("*.json")}

    def numbers(project, case):
        return {name: torch.tensor(value, dtype=torch.float64) for name, value in files[project][case].items()
                if name != "function"}
    return numbers

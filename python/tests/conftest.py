"""What the tests share: specs, the repository, and the binary that has built the same plans."""

import os
import pathlib
import subprocess

import numpy as np
import pytest

ROOT = pathlib.Path(__file__).parents[2]


@pytest.fixture
def problems() -> pathlib.Path:
    """The folder of problems with known answers."""
    return ROOT / "problems"


@pytest.fixture(scope="session")
def slew():
    """Runs the binary; its path stands in the variable SLEW."""
    binary = os.environ.get("SLEW", str(ROOT / "target/debug/slew"))
    if not pathlib.Path(binary).exists():
        pytest.fail(f"no {binary}: build it, or name it in the variable SLEW")

    def run(*arguments: str, code: int = 0) -> subprocess.CompletedProcess:
        done = subprocess.run([binary, *map(str, arguments)], capture_output=True, text=True)
        assert done.returncode == code, done.stderr
        return done

    return run


@pytest.fixture
def spec() -> dict:
    """A slew of a free asymmetric body, from rest to rest."""
    return {
        "format": 1,
        "name": "a slew",
        "body": {"inertia_kg_m2": np.diag([120.0, 100.0, 80.0])},
        "start": {"attitude": {"axis": [0, 0, 1], "angle_deg": 0}},
        "end": {"attitude": {"euler_zyx_deg": (30, -40, 70)}},
        "maneuver": {"duration_s": 60, "steps": 100},
    }


@pytest.fixture
def discrete(spec) -> dict:
    """The slew with the plan whose discrete motion meets the end, as in what is published."""
    return spec | {"solver": {"target": "discrete"}}


def pytest_addoption(parser):
    parser.addoption("--plans", type=int, default=2000, help="plans of the test of memory; 100000 take minutes")

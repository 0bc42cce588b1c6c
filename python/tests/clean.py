"""The package with NumPy alone, as `pip install slewkit` brings it."""

import importlib.metadata
import importlib.util
import pathlib
import subprocess
import sys

import slewkit

assert importlib.metadata.version("slewkit") == slewkit.__version__
assert importlib.util.find_spec("scipy") is None
spec = {
    "format": 1,
    "body": {"inertia_kg_m2": [120, 100, 80]},
    "start": {"attitude": {"axis": [0, 0, 1], "angle_deg": 0}},
    "end": {"attitude": {"axis": [0, 0, 1], "angle_deg": 90}},
    "maneuver": {"duration_s": 60, "steps": 100},
}
plan = slewkit.plan(spec)
print(f"{slewkit.__version__} in a clean environment: {plan}")
assert plan.status == "solved" and plan.torque.shape == (101, 3)

program = pathlib.Path(sys.executable).parent / "slew"
problem = pathlib.Path(__file__).parents[2] / "problems" / "xte_20s.toml"
subprocess.run([program, "plan", problem], check=True, stdout=subprocess.DEVNULL)

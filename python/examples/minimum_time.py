"""The shortest turn of a cube by 90°, which is not about its axis: K. D. Bilimoria and B. Wie, J.
Guidance 16 (1993)."""

import math

import slewkit

plan = slewkit.plan(
    {
        "format": 1,
        "body": {"inertia_kg_m2": [1, 1, 1]},
        "actuators": {"torque_limit_n_m": 1},
        "start": {"attitude": {"axis": [0, 0, 1], "angle_deg": 0}},
        "end": {"attitude": {"axis": [0, 0, 1], "angle_deg": 90}},
        "maneuver": {"minimize": "time", "steps": 100},
    }
)
print(f"{plan.duration:.4f} s, about the axis {2 * math.sqrt(math.pi / 2):.4f} s")
print("inputs switch at", ", ".join(f"{time:.4f}" for time in plan.switching_times), "s")
assert abs(plan.duration - 2.4211) < 1e-3

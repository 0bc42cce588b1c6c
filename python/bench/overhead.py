"""What Python adds to a plan: the time of a call from Python beside that of the same plan within
the library, pair by pair.

    python overhead.py [steps] [plans]

The maneuver is the free asymmetric body of `cargo bench -p benches --bench ratio`, rest to rest,
the default plan: best way, second order, all witnesses. Needs a wheel built with `--release`.
"""

import sys
import time

import numpy as np

import slewkit

steps, count = (int(text) for text in (sys.argv[1:] + ["100", "2000"][len(sys.argv) - 1 :])[:2])
spec = {
    "format": 1,
    "body": {"inertia_kg_m2": [120, 100, 80]},
    "start": {"attitude": {"axis": [0, 0, 1], "angle_deg": 0}},
    "end": {"attitude": {"rotation_vector_rad": [0.4, -0.8, 1.2]}},
    "maneuver": {"duration_s": 60, "steps": steps},
}
problem = slewkit.Problem(spec)


def measured(call):
    """Median and 95 % of the microseconds of a call beyond those within the library, and the median
    of the latter."""
    beyond, within = [], []
    for _ in range(count):
        began = time.perf_counter()
        plan = call()
        beyond.append(1e6 * (time.perf_counter() - began - plan.wall_time))
        within.append(1e6 * plan.wall_time)
    return np.median(beyond), np.percentile(beyond, 95), np.median(within)


def touched():
    plan = slewkit.plan(problem)
    plan.time, plan.quaternions(), plan.angular_velocity, plan.torque, plan.costates
    return plan


print(f"{count} plans of {steps} steps each; microseconds beyond the library: median, 95 %; within the library: median")
calls = {
    "plan(problem)": lambda: slewkit.plan(problem),
    "plan(problem), five arrays": touched,
    "plan(problem), progress": lambda: slewkit.plan(problem, progress=lambda progress: None),
    "plan(dict)": lambda: slewkit.plan(spec),
}
for name, call in calls.items():
    measured(call) if name == "plan(problem)" else None
    beyond, worst, within = measured(call)
    print(f"{name:<28} {beyond:8.1f} {worst:8.1f} {within:10.1f}")

"""What a Python process that plans all day holds: resident memory over many plans, none of which is
kept.

    python memory.py [plans] [steps]

Every plan is of another dictionary, and is used as users do: arrays, a rotation, the dictionary of
the plan; one in ten is refused, stopped or verified once more. What grows is a leak; the first
tenth warms up. Prints a line every tenth, and fails where the second half has grown by more than a
mebibyte.
"""

import resource
import sys
import time

import numpy as np

import slewkit


def resident() -> float:
    """MiB that are resident now; where the system does not tell, the most there ever were."""
    try:
        with open("/proc/self/status") as status:
            return next(int(line.split()[1]) for line in status if line.startswith("VmRSS")) / 1024
    except OSError:
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def use(case: int, steps: int, random: np.random.Generator) -> None:
    spec = {
        "format": 1,
        "body": {"inertia_kg_m2": random.uniform(80, 120, 3)},
        "start": {"attitude": {"axis": [0, 0, 1], "angle_deg": 0}},
        "end": {"attitude": {"rotation_vector_rad": random.uniform(-1, 1, 3)}},
        "maneuver": {"duration_s": 60, "steps": steps, "path": "shortest"},
        "solver": {"search": "quick"},
    }
    if case % 10 == 0:
        try:
            slewkit.plan(spec, overrides={"maneuver.duration_s": -1})
        except slewkit.SpecError:
            pass
    plan = slewkit.plan(spec, progress=(lambda told: None) if case % 10 == 1 else None)
    assert plan.rotation()[-1] is not None and plan.torque.shape == (steps + 1, 3)
    if case % 10 == 2:
        assert slewkit.verify(plan.to_dict()).passed


if __name__ == "__main__":
    plans, steps = (int(text) for text in (sys.argv[1:] + ["100000", "10"][len(sys.argv) - 1 :])[:2])
    random, began, half = np.random.default_rng(1), time.perf_counter(), float("nan")
    for case in range(plans):
        use(case, steps, random)
        done = case + 1
        if done * 10 % plans < 10:
            now = resident()
            half = now if done * 2 <= plans else half
            print(f"{done:8} plans  {now:7.1f} MiB  {done / (time.perf_counter() - began):6.0f} a second", flush=True)
    grown = resident() - half
    print(f"grown by {grown:.2f} MiB over the second half, {grown * 2**20 / (plans / 2):.2f} bytes a plan")
    assert grown < 1.0, "this process would not last"

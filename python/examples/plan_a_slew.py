"""A slew within torque limits, past the Sun: what it costs, and how near it comes to its limits."""

import slewkit

plan = slewkit.plan(
    {
        "format": 1,
        "name": "past the Sun",
        "body": {"inertia_kg_m2": [120, 100, 80]},
        "actuators": {"torque_limit_n_m": 0.6},
        "start": {"attitude": {"axis": [0, 0, 1], "angle_deg": 0}},
        "end": {"attitude": {"axis": [0, 0, 1], "angle_deg": 120}},
        "maneuver": {"duration_s": 60, "steps": 100},
        "constraint": [
            {
                "kind": "keep_out",
                "name": "the Sun",
                "boresight_body": [[1, 0, 0]],
                "direction_inertial": {"vector": [0.5, 0.8, 0.15]},
                "half_angle_deg": 25,
            }
        ],
    }
)
print(plan.summary())
for margin in plan.margins:
    print(f"{margin['name']}: {margin['margin']:.3g} {margin['unit']} to spare at {margin['time_s']:.1f} s")
assert plan.status == "solved" and plan.margins[-1]["scaled"] > -1e-9

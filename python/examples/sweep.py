"""Cost against duration, each plan begun from the one before."""

import slewkit

spec = slewkit.Problem(
    {
        "format": 1,
        "body": {"inertia_kg_m2": [120, 100, 80]},
        "start": {"attitude": {"axis": [0, 0, 1], "angle_deg": 0}},
        "end": {"attitude": {"euler_zyx_deg": [30, -40, 70]}},
        "maneuver": {"duration_s": 60, "steps": 100},
    }
)
plan, scaled = None, []
for duration in range(60, 20, -5):
    plan = slewkit.plan(spec, overrides={"maneuver.duration_s": duration}, guess=plan)
    scaled.append(plan.cost * duration**3)
    print(f"{duration:3d} s   cost {plan.cost:10.4f}   peak torque {abs(plan.torque).max():.4f} N·m")
# From rest to rest the effort of a free body falls with the cube of the time.
assert max(scaled) / min(scaled) - 1 < 1e-9

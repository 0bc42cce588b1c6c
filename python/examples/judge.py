"""What is told when things go wrong: a spec with mistakes, a maneuver that cannot be, a plan that
was tampered with."""

import slewkit

spec = {
    "format": 1,
    "body": {"inertia_kg_m2": [120, 100, 80]},
    "actuators": {"torque_limit_n_m": 0.6},
    "start": {"attitude": {"axis": [0, 0, 1], "angle_deg": 0}},
    "end": {"attitude": {"axis": [0, 0, 1], "angle_deg": 120}},
    "maneuver": {"duration_s": 60, "steps": 100},
}
for finding in slewkit.check({**spec, "body": {"inertia_kg_m2": [120, 10, 80], "mas_kg": 3}}):
    print(f"{finding.key}: {finding.reason}; {finding.remedy}")
try:
    slewkit.plan(spec, overrides={"maneuver.duration_s": 10})
except slewkit.Infeasible as error:
    print(error.reason)
    longer = error.plan.to_dict()["shortest_duration_s"]
plan = slewkit.plan(spec, overrides={"maneuver.duration_s": 2 * longer})
tampered = plan.to_dict()
tampered["trajectory"]["input"][40][2] *= 0.999
verdict = slewkit.verify(tampered)
print("fails:", ", ".join(check["name"] for check in verdict.checks if not check["passed"]))
assert slewkit.verify(plan).passed and not verdict.passed

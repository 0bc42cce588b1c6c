"""The same random slews through slewkit and through CasADi with IPOPT and fatrop, on one core.

    pip install casadi; python peers.py [cases] [steps]

A free asymmetric body turns from rest to rest between random attitudes in given time with least
effort. CasADi gets what a practitioner writes: unit quaternion and rate, Runge–Kutta 4 over steps
with held torque, multiple shooting, exact derivatives, compiled once for all cases, and from the
turn about the eigenaxis with a cubic law as the start. Its effort is that of held torques, so the
two optima differ by the square of the step: some 1e-4 of the cost at 100 steps. `slewkit` is timed
twice: the solve alone, and the whole default plan, with second-order test and witnesses, called
from Python.
"""

import os
import sys
import time

import casadi as ca
import numpy as np
from scipy.spatial.transform import Rotation

import slewkit

count, steps = (int(text) for text in (sys.argv[1:] + ["1000", "100"][len(sys.argv) - 1 :])[:2])
DURATION = 60.0
if hasattr(os, "sched_setaffinity"):
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})


def cases():
    random = np.random.default_rng(1)
    for _ in range(count):
        moments = random.uniform(1, 2, 3)
        while 2 * moments.max() > 0.98 * moments.sum():
            moments = random.uniform(1, 2, 3)
        yield 80 * moments, Rotation.random(random_state=random)


def spec(moments, target):
    return {
        "format": 1,
        "body": {"inertia_kg_m2": moments},
        "start": {"attitude": {"axis": [0, 0, 1], "angle_deg": 0}},
        "end": {"attitude": target},
        "maneuver": {"duration_s": DURATION, "steps": steps},
    }


def transcription(solver):
    """The maneuver as a program of all nodes, in scaled time and torque; parameters are moments and
    target."""
    moments, target = ca.MX.sym("J", 3), ca.MX.sym("target", 4)
    x, u, h = ca.MX.sym("x", 7), ca.MX.sym("u", 3), 1.0 / steps
    q, w = x[:4], x[4:]
    derivative = ca.vertcat(
        0.5 * (q[3] * w + ca.cross(q[:3], w)), -0.5 * ca.dot(q[:3], w), (u - ca.cross(w, moments * w)) / moments
    )
    f = ca.Function("f", [x, u, moments], [derivative])
    k1 = f(x, u, moments)
    k2 = f(x + h / 2 * k1, u, moments)
    k3 = f(x + h / 2 * k2, u, moments)
    k4 = f(x + h * k3, u, moments)
    step = ca.Function("step", [x, u, moments], [x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)])
    xs = [ca.MX.sym(f"x{k}", 7) for k in range(steps + 1)]
    us = [ca.MX.sym(f"u{k}", 3) for k in range(steps)]
    variables, constraints = [], []
    for k in range(steps):
        variables += [xs[k], us[k]]
        constraints.append(xs[k + 1] - step(xs[k], us[k], moments))
        if k == 0:
            constraints.append(xs[0] - ca.DM([0, 0, 0, 1, 0, 0, 0]))
    variables.append(xs[-1])
    end = xs[-1]
    # The vector part of the quaternion from target to end: three conditions, as an attitude has.
    missed = target[3] * end[:3] - end[3] * target[:3] - ca.cross(target[:3], end[:3])
    constraints += [missed, end[4:]]
    cost = sum(h / 2 * ca.dot(u, u) for u in us)
    program = {"x": ca.vertcat(*variables), "f": cost, "g": ca.vertcat(*constraints), "p": ca.vertcat(moments, target)}
    rows = program["g"].numel()
    options = {"expand": True, "print_time": False}
    if solver == "ipopt":
        options["ipopt"] = {"print_level": 0, "sb": "yes", "tol": 1e-8, "max_iter": 500}
    else:
        options |= {"structure_detection": "auto", "equality": [True] * rows}
        options["fatrop"] = {"print_level": 0, "tolerance": 1e-8, "max_iter": 500}
    return ca.nlpsol(solver, solver, program, options)


def guess(target):
    vector = target.as_rotvec()
    nodes = np.linspace(0, 1, steps + 1)
    quaternions = Rotation.from_rotvec(np.outer(3 * nodes**2 - 2 * nodes**3, vector)).as_quat()
    rates = np.outer(6 * nodes - 6 * nodes**2, vector)
    rows = np.hstack([quaternions, rates, np.zeros((steps + 1, 3))])
    return rows.ravel()[:-3]


def by_casadi(solver, moments, target):
    scale = moments.mean()
    q = target.as_quat(canonical=True)
    began = time.perf_counter()
    found = solver(x0=guess(target), p=np.concatenate([moments / scale, q]), lbg=0, ubg=0)
    seconds = time.perf_counter() - began
    # Torques are in units of J/T², the effort in J²/T³.
    cost = float(found["f"]) * scale**2 / DURATION**3
    end = np.array(found["x"]).ravel()[-7:]
    missed = (Rotation.from_quat(end[:4]) * target.inv()).magnitude()
    return cost if solver.stats()["success"] and missed < 1e-6 else np.nan, seconds


def by_slewkit(moments, target):
    problem = slewkit.Problem(spec(moments, target))
    began = time.perf_counter()
    plan = slewkit.plan(problem, strict=False)
    seconds = time.perf_counter() - began
    return plan.cost if plan.status == "solved" else np.nan, plan.solve_time, seconds


solvers = {name: transcription(name) for name in ["ipopt", "fatrop"]}
costs, times = {}, {}
for moments, target in cases():
    cost, solve, whole = by_slewkit(moments, target)
    costs.setdefault("slewkit", []).append(cost)
    times.setdefault("slewkit, solve", []).append(solve)
    times.setdefault("slewkit", []).append(whole)
    for name, solver in solvers.items():
        cost, seconds = by_casadi(solver, moments, target)
        costs.setdefault(name, []).append(cost)
        times.setdefault(name, []).append(seconds)

best = np.nanmin(np.array(list(costs.values())), axis=0)
print(f"{count} random slews of {steps} steps, rest to rest, one core; CasADi {ca.__version__}, "
      f"slewkit {slewkit.__version__}\n")
print(f"{'':<16} {'solved':>8} {'costlier by > 1 %':>18} {'median excess':>14} {'median':>10} {'95 %':>10}")
for name in times:
    seconds = 1e3 * np.array(times[name])
    told = f"{np.median(seconds):7.2f} ms {np.percentile(seconds, 95):7.2f} ms"
    if name not in costs:
        print(f"{name:<16} {'':>8} {'':>18} {'':>14} {told}")
        continue
    found = np.array(costs[name])
    excess = found / best - 1
    solved, worse = np.isfinite(found).mean(), (excess > 0.01).mean()
    print(f"{name:<16} {100 * solved:7.1f}% {100 * worse:17.1f}% {np.nanmedian(excess):14.1e} {told}")

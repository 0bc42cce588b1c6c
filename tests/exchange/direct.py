"""Plans against a direct method of another program: CasADi with IPOPT, from many starts.

    pip install casadi numpy scipy python tests/exchange/direct.py target/release/slew SPEC …
    maneuvers of files python tests/exchange/direct.py target/release/slew --random 20 [KIND …]
    random ones of each kind (or these)

Each maneuver is planned as a user would plan it, and solved by direct multiple shooting: inputs
held over equal intervals, the equations of motion written here and integrated by Runge and Kutta's
method of order four, in 100 intervals or as many as `--intervals` says. The starts (`--starts`) are
the plan itself and paths about the axis of the rotation, both ways round, half of them bent at
random. Held inputs are a restriction, so what the direct method finds is an upper bound of the
least cost: a plan is beaten where the bound lies below its cost by more than a part of 1e-4. Cones
are asked for at the ends of the intervals and at the middle of each, while they act; a boresight
that is held on a cone at the ends of the intervals.

The random maneuvers: bodies of moments in a ratio up to 5 (`unequal`: 5 to 20) along the axes of
the torques, limits from 0.4 to 1.6, rotations of uniform axis and 30 to 180°, from rest to rest;
fuel and effort in 1.2 to 5 times the shortest duration; one to three cones of 15 to 35° that hold
neither end; 6 to 10 one-sided thrusters.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from multiprocessing import Pool
from pathlib import Path

import casadi as ca
import numpy as np
from scipy.spatial.transform import Rotation, Slerp

# A plan that costs more than what the direct method finds by this part is beaten.
BEATEN = 1e-4
# What two grids make of one plan differs by less than this part.
OF_THE_GRIDS = 2e-3
# Runge–Kutta steps an interval.
SUBSTEPS = 2
# Longest run of one start, seconds of processor time.
PATIENCE = 30.0


class Maneuver:
    """What of a plan file says the maneuver, in numbers; a key that is not read here is refused."""

    def __init__(self, plan):
        spec = plan["spec"]
        assert spec.get("environment", {"kind": "none"})["kind"] == "none", "no fields here"
        inertia = np.array(spec["body"]["inertia_kg_m2"])
        self.inertia = np.diag(inertia) if inertia.ndim == 1 else inertia
        actuators = dict(spec["actuators"])
        self.objective = spec["maneuver"].get("minimize", "effort")
        self.duration = spec["maneuver"].get("duration_s")
        self.norm = actuators.pop("torque_norm_limit_n_m", None)
        if "thruster" in actuators:
            thrusters = actuators.pop("thruster")
            self.axes = np.array([one["torque_axis_body"] for one in thrusters])
            self.most = np.array([one["torque_limit_n_m"] for one in thrusters])
            self.least = np.zeros(len(thrusters))
            self.price = np.array([one.get("fuel_price", 1.0) for one in thrusters])
        else:
            self.axes = np.array(actuators.pop("torque_axes_body"))
            self.most = np.array(actuators.pop("torque_limit_n_m", [np.inf] * len(self.axes)))
            self.least = -self.most
            self.price = np.array(actuators.pop("fuel_price", [1.0] * len(self.axes)))
        self.weight = np.array(actuators.pop("effort_weight", [1.0] * len(self.axes)))
        assert not actuators, f"not read here: {list(actuators)}"
        self.cones, self.rate = [], None
        for rule in spec.get("constraint", []):
            if rule["kind"] == "rate_limit":
                self.rate = np.array(rule["limit_rad_s"])
                continue
            # Held on a cone: of no sign.
            sign = {"keep_out": 1.0, "keep_in": -1.0, "on_cone": 0.0}[rule["kind"]]
            angle = rule["half_angle_rad"] + sign * rule.get("margin_rad", 0.0)
            acts = rule.get("during_s", [[-np.inf, np.inf]])
            for axis in rule["boresight_body"]:
                for direction in rule["direction_inertial"]:
                    self.cones.append((sign, np.array(axis), np.array(direction["vector"]), np.cos(angle), acts))

        def state(end):
            turn = Rotation.from_matrix(end["attitude"]["matrix"])
            return turn, np.array(end.get("angular_velocity_rad_s", [0.0, 0.0, 0.0]))

        (self.start, self.start_rate), (self.end, self.end_rate) = state(spec["start"]), state(spec["end"])


def product(a, b):
    return ca.vertcat(a[0] * b[0] - ca.dot(a[1:], b[1:]), a[0] * b[1:] + b[0] * a[1:] + ca.cross(a[1:], b[1:]))


def turned(q, v):
    """A body vector in the reference frame."""
    return v + 2 * ca.cross(q[1:], ca.cross(q[1:], v) + q[0] * v)


class Direct:
    """The discrete problem: states at nodes and held inputs, solved by IPOPT."""

    def __init__(self, maneuver, intervals):
        self.maneuver, self.intervals = maneuver, intervals
        m = len(maneuver.axes)
        state, held, step = ca.SX.sym("x", 7), ca.SX.sym("u", m), ca.SX.sym("h")
        inertia, inverse = ca.DM(maneuver.inertia), ca.DM(np.linalg.inv(maneuver.inertia))
        axes = ca.DM(maneuver.axes.T)

        def rates(x):
            q, w = x[:4], x[4:]
            spin = inverse @ (ca.cross(inertia @ w, w) + axes @ held)
            return ca.vertcat(0.5 * product(q, ca.vertcat(0, w)), spin)

        x, middle, small = state, None, step / SUBSTEPS
        for part in range(SUBSTEPS):
            a = rates(x)
            b = rates(x + small / 2 * a)
            c = rates(x + small / 2 * b)
            d = rates(x + small * c)
            x = x + small / 6 * (a + 2 * b + 2 * c + d)
            middle = x if part + 1 == SUBSTEPS // 2 else middle
        flow = ca.Function("flow", [state, held, step], [x, middle]).map(intervals)

        def margins(x):
            rows = [(sign or 1.0) * (cosine - ca.dot(d, turned(x[:4], ca.DM(a)))) for sign, a, d, cosine,
                _ in maneuver.cones]
            return ca.vertcat(*rows)

        def bounds(parts, between):
            """What margins may be at parts of the motion: held on a cone at nodes alone, and
            anything where a cone does not act."""
            low, high = np.full((2, len(maneuver.cones), len(parts)), [[[-np.inf]], [[np.inf]]])
            for cone, (sign, *_, acts) in enumerate(maneuver.cones):
                assert maneuver.duration or np.isinf(acts).all(), "times need a given duration"
                for at, part in enumerate(parts):
                    if any(since <= part * (maneuver.duration or 1.0) <= until for since, until in acts):
                        low[cone, at] = -np.inf if between and sign == 0.0 else 0.0
                        high[cone, at] = 0.0 if sign == 0.0 and not between else np.inf
            return low.ravel(order="F"), high.ravel(order="F")

        nodes, inputs, duration = ca.MX.sym("X", 7, intervals + 1), ca.MX.sym("U", m, intervals), ca.MX.sym("T")
        fuel = maneuver.objective == "fuel"
        burnt = ca.MX.sym("S", 1 if maneuver.norm else m, intervals) if fuel else ca.MX(0, 1)
        grid = duration / intervals
        after, midway = flow(nodes[:, :-1], inputs, ca.repmat(grid, 1, intervals))
        rows, low, high = [], [], []

        def row(value, least, most):
            value = ca.vec(value)
            rows.append(value)
            low.append(np.full(value.numel(), least) if np.isscalar(least) else least)
            high.append(np.full(value.numel(), most) if np.isscalar(most) else most)

        row(after - nodes[:, 1:], 0.0, 0.0)
        to = np.roll(maneuver.end.as_quat(), 1)
        back = ca.DM(np.append(to[0], -to[1:]))
        row(product(back, nodes[:4, -1])[1:], 0.0, 0.0)
        if maneuver.cones:
            each = ca.SX.sym("x", 7)
            kept = ca.Function("kept", [each], [margins(each)])
            row(kept.map(intervals - 1)(nodes[:, 1:-1]), *bounds(np.arange(1, intervals) / intervals, False))
            row(kept.map(intervals)(midway), *bounds((np.arange(intervals) + 0.5) / intervals, True))
        if maneuver.norm:
            # Over the limit: small numbers would be within the tolerances of IPOPT.
            square = ca.sum1(inputs**2)
            row(square / maneuver.norm**2, 0.0, 1.0)
            if fuel:
                row((burnt**2 - square) / maneuver.norm**2, 0.0, np.inf)
        elif fuel:
            row(burnt - inputs, 0.0, np.inf)
            row(burnt + inputs, 0.0, np.inf)
        if maneuver.objective == "time":
            cost = duration
        elif fuel:
            price = ca.DM(maneuver.price if not maneuver.norm else [1.0])
            cost = grid * ca.sum2(price.T @ burnt)
        else:
            cost = grid / 2 * ca.sum2(ca.DM(maneuver.weight).T @ inputs**2)
        self.shape = [nodes.shape, inputs.shape, burnt.shape]
        unknowns = ca.vertcat(ca.vec(nodes), ca.vec(inputs), ca.vec(burnt), duration)
        most_of = np.full((7, intervals + 1), np.inf)
        if maneuver.rate is not None:
            most_of[4:] = np.broadcast_to(maneuver.rate, (intervals + 1, 3)).T
        lowest, highest = -most_of, most_of.copy()
        first = np.concatenate([np.roll(maneuver.start.as_quat(), 1), maneuver.start_rate])
        lowest[:, 0] = highest[:, 0] = first
        lowest[4:, -1] = highest[4:, -1] = maneuver.end_rate
        given = maneuver.duration
        ends = (given, given) if given is not None else (1e-3, np.inf)
        least, most = (np.repeat(one[:, None], intervals, 1) for one in (maneuver.least, maneuver.most))
        flat = [one.ravel(order="F") for one in (lowest, least)], [one.ravel(order="F") for one in (highest, most)]
        slack = burnt.numel()
        self.lbx = np.concatenate([*flat[0], np.zeros(slack), [ends[0]]])
        self.ubx = np.concatenate([*flat[1], np.full(slack, np.inf), [ends[1]]])
        self.lbg, self.ubg = np.concatenate(low), np.concatenate(high)
        quiet = {"print_level": 0, "sb": "yes", "max_iter": 500, "max_cpu_time": PATIENCE, "tol": 1e-9,
            "bound_relax_factor": 1e-10}
        problem = {"x": unknowns, "f": cost, "g": ca.vertcat(*rows)}
        self.solver = ca.nlpsol("direct", "ipopt", problem, {"ipopt": quiet, "print_time": False})

    def solve(self, nodes, inputs, duration):
        """The least cost from a start, infinite where IPOPT does not end at a minimum."""
        slack = np.zeros(self.shape[2])
        if self.maneuver.objective == "fuel":
            slack = np.linalg.norm(inputs, axis=0)[None] if self.maneuver.norm else np.abs(inputs)
        start = np.concatenate([one.ravel(order="F") for one in (nodes, inputs, slack)] + [[duration]])
        found = self.solver(x0=start, lbx=self.lbx, ubx=self.ubx, lbg=self.lbg, ubg=self.ubg)
        return float(found["f"]) if self.solver.stats()["success"] else np.inf

    def path(self, way, bend, duration):
        """States and inputs of a path about the axis of the rotation (turned by 2π more where `way`
        says), bent by a vector."""
        one, s = self.maneuver, np.linspace(0.0, 1.0, self.intervals + 1)
        vector = (one.start.inv() * one.end).as_rotvec()
        angle = np.linalg.norm(vector)
        if way and angle > 0:
            vector *= 1 - 2 * np.pi / angle
        smooth = 3 * s**2 - 2 * s**3
        turns = one.start * Rotation.from_rotvec(smooth[:, None] * vector)
        turns = turns * Rotation.from_rotvec(np.sin(np.pi * s)[:, None] ** 2 * bend)
        quaternions = np.roll(turns.as_quat(), 1, axis=1)
        for k in range(1, len(quaternions)):
            if quaternions[k] @ quaternions[k - 1] < 0:
                quaternions[k] *= -1
        steps = (turns[:-1].inv() * turns[1:]).as_rotvec() * self.intervals / duration
        rates = np.concatenate([steps[:1], 0.5 * (steps[1:] + steps[:-1]), steps[-1:]])
        rates[0], rates[-1] = one.start_rate, one.end_rate
        nodes = np.concatenate([quaternions, rates], axis=1).T
        return nodes, np.zeros((len(one.axes), self.intervals)), duration

    def plan(self, plan):
        """The plan on the intervals: attitudes interpolated, inputs averaged."""
        path = plan["trajectory"]
        time = np.array(path["time_s"])
        at = np.linspace(0.0, time[-1], self.intervals + 1)
        attitude = Rotation.from_quat(np.array(path["quaternion_wxyz"]), scalar_first=True)
        turns = np.roll(Slerp(time, attitude)(at).as_quat(), 1, axis=1)
        for k in range(1, len(turns)):
            if turns[k] @ turns[k - 1] < 0:
                turns[k] *= -1
        rates = np.array(path["angular_velocity_rad_s"])
        nodes = np.concatenate([turns.T, [np.interp(at, time, rates[:, i]) for i in range(3)]])
        inputs = np.array(path["input"])
        inputs = inputs if len(inputs) < len(time) else 0.5 * (inputs[1:] + inputs[:-1])
        total = np.concatenate([np.zeros((1, inputs.shape[1])), np.cumsum(inputs * np.diff(time)[:, None], axis=0)])
        sums = np.array([np.interp(at, time, total[:, i]) for i in range(inputs.shape[1])])
        return nodes, np.diff(sums) * self.intervals / time[-1], time[-1]


def compared(name, plan, asked, seed):
    """Cost of the plan, of the direct method from the plan, and the least from other starts."""
    maneuver = Maneuver(plan)
    direct = Direct(maneuver, asked.intervals)
    near = direct.solve(*direct.plan(plan))
    random = np.random.default_rng(seed)
    costs = []
    for start in range(asked.starts - 1):
        bend = np.zeros(3) if start < 2 else random.normal(size=3) * random.choice([0.5, 1.5])
        duration = plan["trajectory"]["time_s"][-1]
        if maneuver.duration is None:
            duration *= random.uniform(1.0, 1.4)
        costs.append(direct.solve(*direct.path(start % 2 == 1, bend, duration)))
    return name, plan["cost"], near, min(costs, default=np.inf), sum(np.isfinite(costs))


def random_spec(kind, random, shortest=None):
    """A random maneuver; of fuel and effort within 1.2 to 5 times the shortest duration."""
    ratio = np.exp(random.uniform(np.log(5), np.log(20))) if kind == "unequal" else np.exp(random.uniform(0, np.log(5)))
    third = random.uniform(max(1.0, ratio - 1.0), min(ratio, ratio + 1.0)) if ratio > 2 else random.uniform(1.0, ratio)
    moments = random.permutation([1.0, third, ratio])
    axis = random.normal(size=3)
    angle = random.uniform(30, 180)
    lines = ["format = 1", "[body]", f"inertia_kg_m2 = {moments.tolist()}", "[start]"]
    lines += ["attitude = { axis = [0, 0, 1], angle_deg = 0 }", "[end]"]
    lines += [f"attitude = {{ axis = {axis.tolist()}, angle_deg = {angle} }}", "[maneuver]"]
    objective = {"fuel": "fuel", "cone-fuel": "fuel", "thruster-fuel": "fuel", "effort": "effort"}.get(kind, "time")
    objective = "effort" if kind == "cone-effort" else objective
    spread = random.uniform(1.2, 5.0)
    if shortest is None:
        lines.append('minimize = "time"')
    else:
        lines += [f'minimize = "{objective}"', f"duration_s = {spread * shortest}"]
    lines += ["steps = 100", "[actuators]"]
    if kind.startswith("thruster"):
        while True:
            axes = random.normal(size=(random.integers(6, 11), 3))
            axes /= np.linalg.norm(axes, axis=1)[:, None]
            around = random.normal(size=(2000, 3))
            around /= np.linalg.norm(around, axis=1)[:, None]
            # Each direction of a sample has a thruster well on its side.
            if (around @ axes.T).max(axis=1).min() > 0.2:
                break
        for one in axes:
            lines += ["[[actuators.thruster]]", f"torque_axis_body = {one.tolist()}"]
            lines += [f"torque_limit_n_m = {random.uniform(0.4, 1.6)}"]
    elif kind == "norm":
        lines += ["torque_norm_limit_n_m = 1"]
    else:
        lines += [f"torque_limit_n_m = {random.uniform(0.4, 1.6, 3).tolist()}"]
    if kind.startswith("cone"):
        ends = Rotation.from_rotvec([np.zeros(3), np.radians(angle) * axis / np.linalg.norm(axis)])
        cones, count = 0, random.integers(1, 4)
        while cones < count:
            sight, half = random.normal(size=3), random.uniform(15, 35)
            sight /= np.linalg.norm(sight)
            part = random.uniform(0.3, 0.7)
            way = Rotation.from_rotvec(part * ends[1].as_rotvec()).apply(sight) + 0.2 * random.normal(size=3)
            way /= np.linalg.norm(way)
            if np.degrees(np.arccos(np.clip(ends.apply(sight) @ way, -1, 1))).min() < half + 3:
                continue
            cones += 1
            lines += ["[[constraint]]", 'kind = "keep_out"', f'name = "cone {cones}"']
            lines += [f"boresight_body = {sight.tolist()}", f"direction_inertial = {{ vector = {way.tolist()} }}"]
            lines += [f"half_angle_deg = {half}"]
    return objective, "\n".join(lines) + "\n"


KINDS = ["time", "norm", "unequal", "fuel", "effort", "thruster-time", "thruster-fuel", "cone-time",
    "cone-fuel", "cone-effort"]


def planned(slew, spec, folder, name):
    """The plan of a spec, `None` where there is none."""
    file = Path(folder) / f"{name}.json"
    run = subprocess.run([slew, "plan", str(spec), "-q", "--force", "-o", str(file)], capture_output=True, text=True)
    plan = json.loads(file.read_text()) if file.exists() else None
    return plan if run.returncode == 0 else print(f"{name}: not solved, exit {run.returncode} {run.stderr[:200]}")


def one_random(job):
    kind, seed, asked = job
    name = f"{kind}-{seed}"
    with tempfile.TemporaryDirectory() as folder:
        spec = Path(folder) / f"{name}.toml"
        code = [KINDS.index(kind), seed]
        objective, text = random_spec(kind, np.random.default_rng(code))
        spec.write_text(text)
        plan = planned(asked.slew, spec, folder, name)
        if plan is not None and objective != "time":
            shortest = plan["trajectory"]["time_s"][-1]
            spec.write_text(random_spec(kind, np.random.default_rng(code), shortest)[1])
            plan = planned(asked.slew, spec, folder, name)
        if asked.keep:
            Path(asked.keep, spec.name).write_text(spec.read_text())
        return compared(name, plan, asked, seed) if plan is not None else (name, np.inf, np.inf, np.inf, 0)


def one_file(job):
    file, asked = job
    with tempfile.TemporaryDirectory() as folder:
        plan = planned(asked.slew, file, folder, Path(file).stem)
        if plan is None:
            return Path(file).stem, np.inf, np.inf, np.inf, 0
        return compared(Path(file).stem, plan, asked, 1)


def main():
    reader = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    reader.add_argument("slew")
    reader.add_argument("what", nargs="*", help="specs, or kinds of random maneuvers")
    reader.add_argument("--random", type=int, metavar="COUNT")
    reader.add_argument("--starts", type=int, default=10)
    reader.add_argument("--intervals", type=int, default=100)
    reader.add_argument("--processes", type=int, default=1)
    reader.add_argument("--first", type=int, default=0, help="seed of the first random maneuver")
    reader.add_argument("--keep", help="folder for the specs of random maneuvers")
    asked = reader.parse_args()
    asked.slew = str(Path(asked.slew).resolve())
    if asked.random:
        seeds = range(asked.first, asked.first + asked.random)
        jobs, run = [(kind, seed, asked) for kind in asked.what or KINDS for seed in seeds], one_random
    else:
        jobs, run = [(file, asked) for file in asked.what], one_file
    beaten = {}
    print(f"{'maneuver':<28} {'plan':>14} {'direct from it':>15} {'direct from others':>18}  of {asked.starts - 1}")
    with Pool(asked.processes) as pool:
        for name, cost, near, other, count in pool.imap(run, jobs):
            ours = near if 0 < 1 - near / cost < OF_THE_GRIDS else cost
            least = min(near, other)
            lost = not ours <= least * (1 + BEATEN)
            kind = name.rsplit("-", 1)[0] if asked.random else "maneuvers"
            beaten.setdefault(kind, []).append(lost)
            mark = f"  <- {ours / least - 1:.1e} dearer" if lost else ""
            print(f"{name:<28} {cost:>14.8g} {near:>15.8g} {other:>18.8g}  {count}{mark}", flush=True)
    for kind, lost in beaten.items():
        print(f"{kind}: {sum(lost)} of {len(lost)} beaten by the direct method")
    return any(any(lost) for lost in beaten.values())


if __name__ == "__main__":
    sys.exit(main())

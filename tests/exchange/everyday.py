"""Everyday maneuvers planned by slew beside CasADi with IPOPT: time, cost, how many each solves.

    pip install casadi numpy scipy
    cargo build --release && cargo build --release -p evidence
    python tests/exchange/everyday.py target/release/slew target/release/evidence --cases 6 [KIND …]

The maneuvers are those of `evidence everyday KIND NUMBER SEED`: four wheels, rest to rest, of least
time (`time`), within rates (`rate`), past cones too (`cone`), of least effort past cones
(`effort`), on 100 steps. IPOPT solves each from one cold start about the axis of the turn, in two
forms of direct multiple shooting by one step of Runge and Kutta's method of order four on each
interval:

- `direct`: all nodes as matrices, the step mapped over the intervals, the duration one unknown.
- `expanded`: stage by stage, the duration a state of its own, all expressions expanded to scalars,
  which takes seconds to build
  and half the time to solve. Building is told apart.

Units are such that torques, moments and durations are near one. Cones are asked for at nodes.
Therefore what IPOPT finds counts only if its torques, which are held over the intervals, lead to
the end and keep all limits to 1e-4 (rad, or of the limit) when the motion is sampled 20 times an
interval; where they do not, both programs solve the maneuver on `--fine` steps once more, and these
costs are compared. With `--starts` the expanded form also solves from ways that are bent to a side,
and every other one from the long way round: the cheapest motion that counts is compared. Seconds
are those of the first start. They are those of the processor: of the whole process of slew, and of the
call of IPOPT alone.
"""

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")

import casadi as ca
import numpy as np
from scipy.spatial.transform import Rotation

KINDS = ["time", "rate", "cone", "effort"]
# What a motion that counts may miss or exceed: rad, or of the limit.
KEPT = 1e-4
# Samples of an interval.
SAMPLES = 20
# How far a start is bent to a side, rad.
BEND = 0.5
# A plan is dearer or cheaper where costs differ by more than this part.
APART = 2e-3


class Maneuver:
    """What of a spec says the maneuver, in units of the largest torque and the mean moment."""

    def __init__(self, spec):
        assert "environment" not in spec or spec["environment"]["kind"] == "none", "no fields here"
        inertia = np.array(spec["body"]["inertia_kg_m2"], dtype=float)
        inertia = np.diag(inertia) if inertia.ndim == 1 else inertia
        actuators = dict(spec["actuators"])
        wheels = actuators.pop("wheel")
        assert not actuators, f"not read here: {list(actuators)}"
        torque = np.array([wheel["torque_limit_n_m"] for wheel in wheels])
        self.moment, self.torque = np.trace(inertia) / 3, torque.max()
        self.time = np.sqrt(self.moment / self.torque)
        self.inertia, self.most = inertia / self.moment, torque / self.torque
        self.axes = np.array([wheel["axis_body"] for wheel in wheels]).T
        momentum = self.torque * self.time
        self.store = np.array([wheel["momentum_limit_n_m_s"] for wheel in wheels]) / momentum
        self.stored = np.array([wheel.get("momentum_n_m_s", 0.0) for wheel in wheels]) / momentum
        assert all(wheel.get("effort_weight", 1.0) == 1.0 for wheel in wheels), "effort without weights"
        self.start, self.end = (self.at_rest(spec[name]) for name in ("start", "end"))
        self.effort = spec["maneuver"]["minimize"] == "effort"
        assert self.effort or spec["maneuver"]["minimize"] == "time"
        self.duration = spec["maneuver"]["duration_s"] / self.time if self.effort else None
        self.rate, self.cones = np.full(3, np.inf), []
        for rule in spec.get("constraint", []):
            if rule["kind"] == "rate_limit":
                self.rate = np.array(rule["angular_velocity_limit_rad_s"]) * self.time
                continue
            assert rule["kind"] == "keep_out" and not rule.get("margin_rad"), f"not read here: {rule}"
            for axis in rule["boresight_body"]:
                for direction in rule["direction_inertial"]:
                    self.cones.append((np.array(axis), np.array(direction["vector"]), rule["half_angle_rad"]))

    @staticmethod
    def at_rest(state):
        assert not np.any(state.get("angular_velocity_rad_s", 0.0)), "from rest to rest"
        return Rotation.from_matrix(state["attitude"]["matrix"])

    def cost(self, value):
        """A cost of these units in seconds, or N²·m²·s."""
        return value * self.time * (self.torque**2 if self.effort else 1.0)

    def way(self, s, number):
        """Attitudes of a start: the turn about its axis, and others bent to a random side, every
        other one the long way round."""
        turn = (self.start.inv() * self.end).as_rotvec()
        aside = np.zeros(3)
        if number > 0:
            angle = np.linalg.norm(turn)
            axis = turn / angle if angle > 0 else np.eye(3)[0]
            turn = turn - 2 * np.pi * axis if number % 2 == 0 else turn
            aside = np.cross(axis, np.random.default_rng(number).standard_normal(3))
            aside *= BEND / np.linalg.norm(aside)
        smooth, bent = 3 * s**2 - 2 * s**3, np.sin(np.pi * s) ** 2
        return self.start * Rotation.from_rotvec(np.outer(smooth, turn)) * Rotation.from_rotvec(np.outer(bent, aside))

    def guess(self, intervals, number=0):
        """States, torques and duration along the way of a start, within the limits of everything but
        cones."""
        s = np.linspace(0.0, 1.0, intervals + 1)
        attitudes = self.way(s, number)
        turned = ((attitudes[:-1].inv() * attitudes[1:]).as_rotvec() * intervals).T
        rates = np.zeros((3, intervals + 1))
        rates[:, 1:-1] = (turned[:, 1:] + turned[:, :-1]) / 2
        angular = self.inertia @ rates
        # Of a duration of one; rates and momenta go with its inverse, torques with the square of
        # that.
        back = -np.linalg.pinv(self.axes)
        stored = self.stored[:, None] + back @ angular
        held = -back @ np.diff(angular, axis=1) * intervals
        duration = self.duration
        if duration is None:
            of_torques = np.sqrt((np.abs(held) / self.most[:, None]).max())
            of_rates = (np.abs(rates) / self.rate[:, None]).max()
            of_momenta = (np.abs(back @ angular) / self.store[:, None]).max()
            duration = 1.1 * max(of_torques, of_rates, of_momenta)
        stored = self.stored[:, None] + back @ angular / duration
        held = np.clip(held / duration**2, -0.98 * self.most[:, None], 0.98 * self.most[:, None])
        quaternions = quaternion(attitudes)
        for k in range(1, len(quaternions)):
            if quaternions[k] @ quaternions[k - 1] < 0:
                quaternions[k] *= -1
        return np.vstack([quaternions.T, rates / duration, stored]), held, duration

    def kept(self, torques, duration):
        """Whether torques held over equal intervals lead to the end within all limits, by small
        steps."""
        inverse = np.linalg.inv(self.inertia)

        def slope(x, held):
            q, w, p = x[:4], x[4:7], x[7:]
            spin = np.cross(self.inertia @ w + self.axes @ p, w) + self.axes @ held
            turn = 0.5 * np.concatenate([[-q[1:] @ w], q[0] * w + np.cross(q[1:], w)])
            return np.concatenate([turn, inverse @ spin, -held])

        x = np.concatenate([quaternion(self.start), np.zeros(3), self.stored])
        step, worst = duration / torques.shape[1] / SAMPLES, np.abs(torques / self.most[:, None]).max() - 1
        for held in torques.T:
            for _ in range(SAMPLES):
                a = slope(x, held)
                b = slope(x + step / 2 * a, held)
                c = slope(x + step / 2 * b, held)
                x = x + step / 6 * (a + 2 * b + 2 * c + slope(x + step * c, held))
                attitude = Rotation.from_quat(np.roll(x[:4], -1))
                inside = [half - between(attitude.apply(axis), way) for axis, way, half in self.cones]
                over = np.abs(np.concatenate([x[4:7] / self.rate, x[7:] / self.store])) - 1
                worst = max(worst, *inside, *over)
        missed = (self.end.inv() * attitude).magnitude()
        return max(worst, missed, np.abs(x[4:7]).max() * duration) <= KEPT


def quaternion(rotation):
    """Scalar first."""
    return np.roll(rotation.as_quat(), 1, axis=-1)


def between(a, b):
    return np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b)


class Discrete:
    """A maneuver on intervals for IPOPT, in either form."""

    def __init__(self, maneuver, intervals, expanded, patience):
        self.maneuver, self.intervals, self.expanded = maneuver, intervals, expanded
        began = time.process_time()
        self.wheels = maneuver.axes.shape[1]
        options = {"print_level": 0, "sb": "yes", "max_iter": 1000, "tol": 1e-8, "max_cpu_time": patience}
        problem = self.staged() if expanded else self.mapped()
        options = {"ipopt": options, "print_time": False, "expand": expanded}
        self.solver = ca.nlpsol("everyday", "ipopt", problem, options)
        self.building = time.process_time() - began

    def flow(self):
        """One step of Runge and Kutta's method: state, held torques and length to the next
        state."""
        one, count = self.maneuver, self.wheels
        inertia, inverse, axes = (ca.DM(m) for m in (one.inertia, np.linalg.inv(one.inertia), one.axes))
        x, held, step = ca.SX.sym("x", 7 + count), ca.SX.sym("u", count), ca.SX.sym("h")

        def slope(x):
            q, w, p = x[:4], x[4:7], x[7:]
            spin = inverse @ (ca.cross(inertia @ w + axes @ p, w) + axes @ held)
            turn = ca.vertcat(-ca.dot(q[1:], w), q[0] * w + ca.cross(q[1:], w)) / 2
            return ca.vertcat(turn, spin, -held)

        a = slope(x)
        b = slope(x + step / 2 * a)
        c = slope(x + step / 2 * b)
        d = slope(x + step * c)
        return ca.Function("flow", [x, held, step], [x + step / 6 * (a + 2 * b + 2 * c + d)])

    def margins(self):
        """How far boresights are outside of cones, by cosines."""
        q, rows = ca.SX.sym("q", 4), []
        for axis, way, half in self.maneuver.cones:
            axis = ca.DM(axis)
            pointed = axis + 2 * ca.cross(q[1:], ca.cross(q[1:], axis) + q[0] * axis)
            rows.append(np.cos(half) - ca.dot(ca.DM(way), pointed))
        return ca.Function("margins", [q], [ca.vertcat(*rows)])

    def missed(self, q):
        """The vector part of the quaternion that is left to the end."""
        to = quaternion(self.maneuver.end)
        return to[0] * q[1:] - q[0] * ca.DM(to[1:]) - ca.cross(ca.DM(to[1:]), q[1:])

    def bounds(self, width):
        """Of all states and torques; the duration is the last state where a state has one more
        number."""
        one, count = self.maneuver, self.intervals
        most = np.concatenate([np.full(4, np.inf), one.rate, one.store, np.full(width - 7 - self.wheels, np.inf)])
        low, high = -np.repeat(most[:, None], count + 1, 1), np.repeat(most[:, None], count + 1, 1)
        low[7 + self.wheels :] = 1e-3
        first = np.concatenate([quaternion(one.start), np.zeros(3), one.stored])
        low[: len(first), 0] = high[: len(first), 0] = first
        low[4:7, -1] = high[4:7, -1] = 0.0
        torques = np.repeat(one.most[:, None], count, 1)
        return (low, -torques), (high, torques)

    def mapped(self):
        one, count = self.maneuver, self.intervals
        x, u = ca.MX.sym("X", 7 + self.wheels, count + 1), ca.MX.sym("U", self.wheels, count)
        duration = ca.MX.sym("T")
        step = duration / count
        after = self.flow().map(count)(x[:, :-1], u, ca.repmat(step, 1, count))
        rows = [ca.vec(after - x[:, 1:]), self.missed(x[:4, -1])]
        kept = 0
        if one.cones:
            margins = ca.vec(self.margins().map(count - 1)(x[:4, 1:-1]))
            kept = margins.numel()
            rows.append(margins)
        equal = sum(row.numel() for row in rows) - kept
        (low, least), (high, most) = self.bounds(7 + self.wheels)
        ends = (one.duration, one.duration) if one.effort else (1e-3, np.inf)
        flat = lambda states, torques, end: np.concatenate([states.ravel("F"), torques.ravel("F"), [end]])
        self.limits = {
            "lbx": flat(low, least, ends[0]),
            "ubx": flat(high, most, ends[1]),
            "lbg": np.zeros(equal + kept),
            "ubg": np.concatenate([np.zeros(equal), np.full(kept, np.inf)]),
        }
        cost = step / 2 * ca.sumsqr(u) if one.effort else duration
        return {"x": ca.vertcat(ca.vec(x), ca.vec(u), duration), "f": cost, "g": ca.vertcat(*rows)}

    def staged(self):
        one, count = self.maneuver, self.intervals
        flow, margins = self.flow(), self.margins()
        width = 7 + self.wheels + (0 if one.effort else 1)
        x = [ca.MX.sym(f"x{k}", width) for k in range(count + 1)]
        u = [ca.MX.sym(f"u{k}", self.wheels) for k in range(count)]
        rows, most, cost = [], [], 0
        for k in range(count):
            duration = one.duration if one.effort else x[k][-1]
            state = x[k][: 7 + self.wheels]
            if k > 0 and one.cones:
                rows.append(margins(x[k][:4]))
                most.append(np.full(len(one.cones), np.inf))
            after = flow(state, u[k], duration / count)
            after = after if one.effort else ca.vertcat(after, duration)
            rows.append(after - x[k + 1])
            most.append(np.zeros(width))
            cost += duration / count / 2 * ca.sumsqr(u[k]) if one.effort else 0
        rows.append(self.missed(x[-1][:4]))
        most.append(np.zeros(3))
        low, high = self.bounds(width)
        most = np.concatenate(most)
        limits = {"lbx": self.by_stages(*low), "ubx": self.by_stages(*high), "lbg": np.zeros(len(most)), "ubg": most}
        self.limits = limits
        unknowns = [part for pair in zip(x, u) for part in pair] + [x[-1]]
        cost = cost if one.effort else x[-1][-1]
        return {"x": ca.vertcat(*unknowns), "f": cost, "g": ca.vertcat(*rows)}

    @staticmethod
    def by_stages(states, torques):
        both = np.vstack([states[:, :-1], torques])
        return np.concatenate([both.ravel("F"), states[:, -1]])

    def solve(self, number=0):
        """Returns the cost, the seconds, and whether the motion counts, from the start of this
        number. The cost is infinite if IPOPT does not end at a minimum."""
        states, torques, duration = self.maneuver.guess(self.intervals, number)
        if self.expanded:
            given = [] if self.maneuver.effort else [np.full((1, self.intervals + 1), duration)]
            start = self.by_stages(np.vstack([states, *given]), torques)
        else:
            start = np.concatenate([states.ravel("F"), torques.ravel("F"), [duration]])
        began = time.process_time()
        found = self.solver(x0=start, **self.limits)
        seconds = time.process_time() - began
        if not self.solver.stats()["success"]:
            return np.inf, seconds, False
        values = np.array(found["x"]).ravel()
        if self.expanded:
            width = len(values) - self.intervals * self.wheels
            width //= self.intervals + 1
            rows = values[: self.intervals * (width + self.wheels)].reshape(self.intervals, -1)
            torques, duration = rows[:, width:].T, self.maneuver.duration or values[-1]
        else:
            at = (7 + self.wheels) * (self.intervals + 1)
            torques = values[at : at + self.wheels * self.intervals].reshape(self.wheels, -1, order="F")
            duration = values[-1]
        return self.maneuver.cost(float(found["f"])), seconds, self.maneuver.kept(torques, duration)


def planned(slew, spec, folder, steps, patience):
    """Cost of the plan of slew, infinite where none is solved and verified, and the seconds of its
    process."""
    file, plan = Path(folder) / "spec.json", Path(folder) / "plan.json"
    file.write_text(json.dumps(spec))
    plan.unlink(missing_ok=True)
    used = lambda: sum(resource.getrusage(resource.RUSAGE_CHILDREN)[:2])
    before = used()
    words = [slew, "plan", str(file), "-q", "-o", str(plan), "--set", f"maneuver.steps={steps}"]
    # Of the processor, as the patience with IPOPT is: others may be at work.
    limit = lambda: resource.setrlimit(resource.RLIMIT_CPU, 2 * (int(np.ceil(patience)),))
    run = subprocess.run(words, capture_output=True, text=True, preexec_fn=limit)
    seconds = used() - before
    if run.returncode == 2:
        sys.exit(run.stderr)
    return (json.loads(plan.read_text())["cost"] if run.returncode == 0 else np.inf), seconds


def compared(spec, folder, asked):
    """Costs and seconds of all three, and the costs that are compared: of slew, and the least of
    IPOPT that counts."""
    maneuver = Maneuver(spec)
    cost, seconds = planned(asked.slew, spec, folder, asked.steps, asked.patience)
    forms = [Discrete(maneuver, asked.steps, expanded, asked.patience) for expanded in (False, True)]
    found = [form.solve() for form in forms]
    row = {"slew": (cost, seconds)}
    for name, form, (value, took, _) in zip(("direct", "expanded"), forms, found):
        row[name] = value, took, form.building
    found += [forms[1].solve(number) for number in range(1, asked.starts)]
    counted = min((value for value, _, kept in found if kept), default=np.inf)
    pair = cost, counted
    if not np.isfinite(counted) and any(np.isfinite(value) for value, *_ in found) and asked.fine:
        value, _, kept = Discrete(maneuver, asked.fine, False, 4 * asked.patience).solve()
        if kept and np.isfinite(cost):
            pair = planned(asked.slew, spec, folder, asked.fine, 4 * asked.patience)[0], value
        row["fine"] = True
    row["pair"] = pair
    return row


def told(kind, rows):
    seconds = {name: np.array([row[name][1] for row in rows]) for name in ("slew", "direct", "expanded")}
    solved = {name: sum(np.isfinite(row[name][0]) for row in rows) for name in seconds}
    building = np.median([row["expanded"][2] for row in rows])
    print(f"{kind}: {len(rows)} maneuvers")
    for name, values in seconds.items():
        ratio = np.median(values / seconds["slew"])
        more = f", {ratio:.2f} times slew in the median" if name != "slew" else ""
        more += f", {building:.2f} s to build" if name == "expanded" else ""
        print(f"  {name:<9} solves {solved[name]}; median {np.median(values):.3f} s, most {values.max():.3f} s{more}")
    pairs = np.array([row["pair"] for row in rows])
    both = np.isfinite(pairs).all(axis=1)
    fine = sum("fine" in row for row in rows)
    print(f"  costs compared: {both.sum()}, where IPOPT's keeps the limits; {fine} solved on more steps for that")
    print(f"  IPOPT alone: {(np.isinf(pairs[:, 0]) & np.isfinite(pairs[:, 1])).sum()}; slew alone: ", end="")
    print((np.isfinite(pairs[:, 0]) & np.isinf(pairs[:, 1])).sum())
    if both.any():
        apart = pairs[both, 0] / pairs[both, 1] - 1
        print(f"  cost of slew over IPOPT's: median {np.median(apart):+.1e}, least {apart.min():+.1e}, ", end="")
        print(f"most {apart.max():+.1e}; dearer by {APART:.1%} in {(apart > APART).sum()}, cheaper "
              f"in {(apart < -APART).sum()}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("slew")
    parser.add_argument("evidence", help="the program that prints the specs")
    parser.add_argument("kinds", nargs="*", metavar="KIND", help=f"of {', '.join(KINDS)}; all by default")
    parser.add_argument("--cases", type=int, default=6, help="of each kind")
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--steps", type=int, default=100)
    parser.add_argument("--starts", type=int, default=1, help="of IPOPT, the cheapest of which is compared")
    parser.add_argument("--fine", type=int, default=400, help="steps where IPOPT's motion does not count; 0: none")
    parser.add_argument("--patience", type=float, default=120.0, help="what a solve may take of the processor [s]")
    asked = parser.parse_args()
    if unknown := [kind for kind in asked.kinds if kind not in KINDS]:
        parser.error(f"no kind is called {unknown[0]}; known are {', '.join(KINDS)}")
    with tempfile.TemporaryDirectory() as folder:
        for kind in asked.kinds or KINDS:
            rows = []
            for number in range(asked.first, asked.first + asked.cases):
                words = [asked.evidence, "everyday", kind, str(number), str(asked.seed)]
                spec = json.loads(subprocess.run(words, capture_output=True, text=True, check=True).stdout)
                rows.append(compared(spec, folder, asked))
                last = rows[-1]
                costs = ", ".join(
                    f"{name} {last[name][0]:.8g} in {last[name][1]:.2f} s"
                    for name in ("slew", "direct", "expanded")
                )
                fine = "; compared on more steps: {:.8g}, {:.8g}".format(*last["pair"]) if "fine" in last else ""
                print(f"  {kind} {number}: {costs}{fine}", flush=True)
            told(kind, rows)


if __name__ == "__main__":
    main()

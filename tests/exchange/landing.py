"""Plans of every kind, flown by SciPy: their torques, held as `slew help replay` says, bring the
body to the target.

The equations are written here anew from the plan file and the maneuver in it, and integrated by
DOP853; the verdict of the program is not read.
"""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

PROBLEMS = Path(__file__).parents[2] / "problems"
# Shipped maneuvers, none of which takes more than a few seconds to plan. They are planned to land,
# whatever the file says.
KINDS = {
    "effort": ["rest_120", "moving_ends", "detumble", "two_torques", "limited_norm", "pyramid"],
    "other scheme": ["moving_ends_euler"],
    "cones and rates": ["keep_out_small", "keep_in", "limited_rate"],
    "wheels": ["wheels_pyramid", "wheels_one_failed"],
    "fields": ["moving_ends_pendulum", "orbit_turn"],
    "position and attitude": ["free_flyer", "body_thrusters", "dumbbell_transfer"],
    "time": ["minimum_time_cube_090", "minimum_time_xte"],
    "fuel": ["minimum_fuel_xte", "minimum_fuel_norm"],
}
# What is asked of a plan that is called solved, in degrees.
ASKED = 1e-4


def symmetric(rows):
    rows = np.array(rows)
    return np.diag(rows) if rows.ndim == 1 else rows


def product(a, b):
    (a, u), (b, v) = (a[0], a[1:]), (b[0], b[1:])
    return np.append(a * b - u @ v, a * v + b * u + np.cross(u, v))


def fields(spec, inertia, mass):
    """The moment (body axes) and force (reference axes) of an environment, and the rate of the
    reference frame."""
    field = spec.get("environment", {"kind": "none"})
    none = np.zeros(3)
    if field["kind"] == "none":
        return lambda x, r: (none, none), none
    if field["kind"] == "uniform_gravity":
        down = np.array(field["direction"]) / np.linalg.norm(field["direction"])
        weight = field["mass_kg"] * field["gravity_m_s2"] * down
        arm = np.array(field["pivot_to_mass_center_m"])
        return lambda x, r: (np.cross(arm, r.T @ weight), none), none
    if field["kind"] == "gravity_gradient":
        rate = field["orbital_rate_rad_s"]

        # Outwards is z, and the frame turns about y.
        def moment(x, r):
            up = r.T @ [0, 0, 1]
            return 3 * rate**2 * np.cross(up, inertia @ up), none

        return moment, np.array([0, rate, 0])
    assert field["kind"] == "central_gravity" and field["body"] == "points", field
    mu = field["gravitational_parameter_m3_s2"]

    def central(x, r):
        moment, force = np.zeros(3), np.zeros(3)
        for point in field["points"]:
            place = np.array(point["position_m"])
            apart = x + r @ place
            pull = -mu * point["mass_kg"] * apart / np.linalg.norm(apart) ** 3
            force += pull
            moment += np.cross(place, r.T @ pull)
        return moment, force

    return central, none


def missed(plan):
    """By how many degrees the body misses the attitude of the end, and the largest other miss,
    relative."""
    spec, path = plan["spec"], plan["trajectory"]
    inertia, mass = symmetric(spec["body"]["inertia_kg_m2"]), spec["body"].get("mass_kg", 1.0)
    field, turning = fields(spec, inertia, mass)
    time = np.array(path["time_s"])
    wheels = spec["actuators"].get("wheel", [])
    axes = np.array([wheel["axis_body"] for wheel in wheels]).reshape(-1, 3)
    by_body = "force_axes_body" in spec["actuators"]
    by_reference = "torque_axes_reference" in spec["actuators"]

    def rows(name):
        rows = np.array(path.get(name, np.zeros((len(time) - 1, 3))))
        return rows if len(rows) < len(time) else 0.5 * (rows[:-1] + rows[1:])

    # Torques of the file are in body axes and forces in reference axes: of actuators fixed in the
    # other, what is held is what the inputs give in their own axes.
    inputs = rows("input")
    forces = spec["actuators"].get("force_axes_body", spec["actuators"].get("force_axes_reference", []))
    force = inputs[:, : len(forces)] @ np.array(forces).reshape(-1, 3)
    torque_axes = spec["actuators"].get("torque_axes_reference", spec["actuators"].get("torque_axes_body", []))
    torque_axes = axes if wheels else np.array(torque_axes).reshape(-1, 3)
    torque = inputs[:, len(forces) :] @ torque_axes

    def motion(t, y, torque, force):
        quaternion, rate, place, velocity, stored = y[:4], y[4:7], y[7:10], y[10:13], y[13:]
        r = Rotation.from_quat(quaternion, scalar_first=True).as_matrix()
        turn = 0.5 * (product(quaternion, np.append(0, rate)) - product(np.append(0, turning), quaternion))
        moment, pull = field(place, r)
        torque = r.T @ torque if by_reference else torque
        force = r @ force if by_body else force
        spin = np.linalg.solve(inertia, np.cross(inertia @ rate + stored, rate) + moment + torque)
        return np.concatenate([turn, spin, velocity, (force + pull) / mass, -torque if wheels else np.zeros(3)])

    start, end = spec["start"], spec["end"]

    def quaternion(state):
        return Rotation.from_matrix(state["attitude"]["matrix"]).as_quat(scalar_first=True)

    def vector(state, name):
        return np.array(state.get(name, [0.0, 0.0, 0.0]))

    stored = sum((w["momentum_n_m_s"] * np.array(w["axis_body"]) for w in wheels), np.zeros(3))
    names = ["angular_velocity_rad_s", "position_m", "velocity_m_s"]
    y = np.concatenate([quaternion(start), *(vector(start, name) for name in names), stored])
    for k in range(len(time) - 1):
        span = (time[k], time[k + 1])
        y = solve_ivp(motion, span, y, "DOP853", args=(torque[k], force[k]), rtol=1e-12, atol=1e-13).y[:, -1]
    turned = Rotation.from_quat(y[:4], scalar_first=True)
    off = np.degrees((Rotation.from_matrix(end["attitude"]["matrix"]).inv() * turned).magnitude())
    rate = np.linalg.norm(y[4:7] - vector(end, names[0])) * time[-1]
    way = max(1.0, np.linalg.norm(vector(end, names[1])))
    place = np.linalg.norm(y[7:10] - vector(end, names[1])) / way
    return off, max(rate, place)


def main(slew, folder):
    flown = 0
    for kind, names in KINDS.items():
        for name in names:
            file = Path(folder) / f"{name}.json"
            planned = ["plan", str(PROBLEMS / f"{name}.toml"), "--set", "solver.target=motion", "-q", "-o", str(file)]
            run = subprocess.run([slew, *planned], capture_output=True, text=True)
            assert run.returncode == 0, f"{name}: {run.stderr}"
            off, others = missed(json.loads(file.read_text()))
            print(f"{kind:22} {name:22} {off:.1e} deg off, rate and place {others:.1e}", flush=True)
            assert off <= ASKED and others <= 1e-6, name
            flown += 1
    print(f"{flown} plans land")


if __name__ == "__main__":
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        main(str(Path(sys.argv[1]).resolve()), folder)

"""A plan flown by Basilisk, in its own modules and dynamics, lands where the plan says, with its
gains too. From the root:

    python tests/exchange/basilisk.py SLEW

Three roads, each with the inertia of the plan and with 2 % more of it: the exported waypoints,
tracked by Basilisk's modules of reference, error and feedback; the torques alone, held over each
step; and torques with the gains of the plan, both kinds, whose error must follow the linear
prediction that is made here from the equations of motion.

Frames and units: R maps components in body axes B to those in the inertial axes N, and Basilisk's
σ_BN are the modified Rodrigues parameters of R. Rates and torques are in body axes, rad/s and N m.
Waypoints have rates in axes of N.
"""

import itertools
import json
import math
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

try:
    from Basilisk.architecture import bskLogging, messaging, sysModel
    from Basilisk.fswAlgorithms import attTrackingError, mrpFeedback, waypointReference
    from Basilisk.simulation import extForceTorque, simpleNav, spacecraft
    from Basilisk.utilities import SimulationBaseClass
except ImportError as missing:
    print(f"SKIPPED: Basilisk cannot be imported ({missing}); pip install bsk")
    sys.exit(0)
# Else it tells of every file that it opens.
bskLogging.setDefaultLogLevel(bskLogging.BSK_WARNING)

PROBLEMS = Path("problems")
STEPS = 200
NANO = 1e9
# Of all modules, in seconds; Basilisk integrates by RK4 over it.
TICK = 0.01
# Of mrpFeedback, in N m and N m s: torque = −K σ_BR − P ω_BR + J (ω̇_RN − ω_BN × ω_RN) + ω_RN × J
# ω_BN.
PROPORTIONAL, RATE_GAIN = 500.0, 2500.0
HEAVIER = 1.02

# What is promised at the end, in rad and rad/s. Waypoints are tracked to 1e-4: the torque of the
# feedback is held over a tick (half the tick, half the miss), and σ and rates are interpolated
# linearly, each for itself. Held torques land as the plan does.
TRACKED, TRACKED_HEAVIER = 2e-4, 5e-3
HELD = 1e-8
# The least by which 2 % more inertia must miss in open loop, so that a loop has something to do, in
# rad.
SHOWS = 2e-2
# What the body has of error at the start, in rad and rad/s, and what gains leave of it at the end.
START_ERROR = np.array([6e-4, -4e-4, 5e-4, 1e-5, 2e-5, -1e-5])
LEFT = 1e-4
# The error along the flight against the linear prediction, relative to its largest: what is left is
# of second order in it.
PREDICTED = 1e-3


class Row(NamedTuple):
    """A row of a table of gains. Over [t_k, t_{k+1}) the torque is u_k − K_k [ζ; δω] of t_k; the
    last row is the end, and acts on nothing."""

    time: float  # t_k, s
    quaternion: np.ndarray  # of R*, Hamilton, w x y z
    rate: np.ndarray  # ω*, body axes, rad/s
    torque: np.ndarray  # u_k, body axes, N m
    gains: np.ndarray  # K_k, 3 × 6: by ζ, N m/rad, then by δω, N m s


class Flight(NamedTuple):
    """How a flight ends, and where it was against the plan on the way."""

    attitude: float  # |ζ| at the end, rad
    rate: float  # |δω| at the end, rad/s
    errors: np.ndarray  # [ζ; δω] at each row


def require(true, sentence):
    if not true:
        sys.exit(f"Basilisk: {sentence}")


def attitude_error(attitude, expected):
    """ζ = log(R*ᵀ R), body axes, rad."""
    return (expected.inv() * attitude).as_rotvec()


# ---- the craft in Basilisk


class Craft:
    """A free rigid body and a torque on it, in one task. Within a tick the body moves first, under
    the torque that was commanded a tick ago, and what commands is added after it: it sees the state
    of this instant, and its torque is held until the next."""

    def __init__(self, inertia, attitude, rate, tick_nanos):
        self.simulation = SimulationBaseClass.SimBaseClass()
        task = self.simulation.CreateNewTask("task", tick_nanos)
        self.simulation.CreateNewProcess("process").addTask(task)
        self.priority = 100
        self.torque = extForceTorque.ExtForceTorque()
        self.body = spacecraft.Spacecraft()
        self.body.hub.mHub = 1000.0
        self.body.hub.IHubPntBc_B = np.asarray(inertia).tolist()
        self.body.hub.sigma_BNInit = attitude.as_mrp().reshape(3, 1).tolist()
        self.body.hub.omega_BN_BInit = np.reshape(rate, (3, 1)).tolist()
        self.body.addDynamicEffector(self.torque)
        self.add(self.torque)
        self.add(self.body)

    def add(self, module):
        """Modules of higher priority go first."""
        module.ModelTag = module.ModelTag or type(module).__name__
        self.simulation.AddModelToTask("task", module, self.priority)
        self.priority -= 1

    def fly(self, end_nanos):
        """Attitude and rate at the end."""
        self.simulation.InitializeSimulation()
        self.simulation.ConfigureStopTime(end_nanos)
        self.simulation.ExecuteSimulation()
        return state(self.body.scStateOutMsg.read())


def state(message):
    return Rotation.from_mrp(message.sigma_BN), np.array(message.omega_BN_B)


def fly_waypoints(table, start, end, inertia, known_inertia):
    """Basilisk's own loop along a table of waypoints; how far it ends from the last row, in rad and
    rad/s. The feedback module knows `known_inertia` alone."""
    attitude, rate = Rotation.from_quat(start.quaternion, scalar_first=True), start.rate
    craft = Craft(inertia, attitude, rate, round(TICK * NANO))
    navigation = simpleNav.SimpleNav()
    navigation.scStateInMsg.subscribeTo(craft.body.scStateOutMsg)

    reference = waypointReference.WaypointReference()
    reference.dataFileName, reference.delimiter, reference.headerLines = str(table), ",", 1
    # Modified Rodrigues parameters; rates and accelerations in axes of N.
    reference.attitudeType, reference.useReferenceFrame = 0, False

    error = attTrackingError.attTrackingError()
    error.attNavInMsg.subscribeTo(navigation.attOutMsg)
    error.attRefInMsg.subscribeTo(reference.attRefOutMsg)

    vehicle = messaging.VehicleConfigMsgPayload()
    vehicle.ISCPntB_B = np.asarray(known_inertia).ravel().tolist()
    vehicle = messaging.VehicleConfigMsg().write(vehicle)
    feedback = mrpFeedback.mrpFeedback()
    # Negative: no integral.
    feedback.K, feedback.P, feedback.Ki = PROPORTIONAL, RATE_GAIN, -1.0
    feedback.guidInMsg.subscribeTo(error.attGuidOutMsg)
    feedback.vehConfigInMsg.subscribeTo(vehicle)

    craft.torque.cmdTorqueInMsg.subscribeTo(feedback.cmdTorqueOutMsg)
    for module in (navigation, reference, error, feedback):
        craft.add(module)
    attitude, rate = craft.fly(round(end.time / TICK) * round(TICK * NANO))
    zeta = attitude_error(attitude, Rotation.from_quat(end.quaternion, scalar_first=True))
    return np.linalg.norm(zeta), np.linalg.norm(rate - end.rate)


class GainTable(sysModel.SysModel):
    """At the tick of row k: torque = u_k − K_k [ζ; δω], ζ = log(R*ᵀ R), δω = ω − ω*, held until the
    next row."""

    def __init__(self, rows, ticks, tick_nanos, state_message):
        super().__init__()
        self.rows = dict(zip(ticks, rows, strict=True))
        self.tick_nanos = tick_nanos
        self.errors = []
        self.state_message = state_message
        self.torque_message = messaging.CmdTorqueBodyMsg()

    # Named by Basilisk.
    def UpdateState(self, now):
        row = self.rows.get(now // self.tick_nanos)
        if row is None:
            return
        attitude, rate = state(self.state_message.read())
        zeta = attitude_error(attitude, Rotation.from_quat(row.quaternion, scalar_first=True))
        error = np.concatenate([zeta, rate - row.rate])
        self.errors.append(error)
        command = messaging.CmdTorqueBodyMsgPayload()
        command.torqueRequestBody = (np.asarray(row.torque) - np.asarray(row.gains) @ error).tolist()
        self.torque_message.write(command, now, self.moduleID)


def ticks_of(rows, longest):
    """A tick of at most `longest` seconds, in whole nanoseconds, and the number of ticks until each
    row."""
    times = np.array([row.time for row in rows]) - rows[0].time
    step = np.diff(times).min()
    tick_nanos = round(step * NANO / math.ceil(step / longest - 1e-9))
    ticks = np.rint(times * NANO / tick_nanos).astype(int)
    off = np.abs(times - ticks * tick_nanos / NANO).max()
    # Of a step that is no whole number of nanoseconds the rounding adds up, to microseconds at
    # most.
    if off > 1e-5:
        raise ValueError(f"a row is {off:.1e} s from any tick of {tick_nanos / NANO} s; take ticks on "
                         f"which all rows lie")
    return tick_nanos, ticks.tolist()


def fly_gains(rows, inertia, start_error=None, tick=TICK):
    """Flies a table of gains with a body of `inertia`, from the first row or [ζ; δω] =
    `start_error` beside it."""
    rows = [Row(*row) for row in rows]
    tick_nanos, ticks = ticks_of(rows, tick)
    error = np.zeros(6) if start_error is None else np.asarray(start_error)
    attitude = Rotation.from_quat(rows[0].quaternion, scalar_first=True) * Rotation.from_rotvec(error[:3])
    craft = Craft(inertia, attitude, rows[0].rate + error[3:], tick_nanos)
    table = GainTable(rows, ticks, tick_nanos, craft.body.scStateOutMsg)
    craft.torque.cmdTorqueInMsg.subscribeTo(table.torque_message)
    craft.add(table)
    craft.fly(ticks[-1] * tick_nanos)
    # The last row is met at the last tick, after the body has moved.
    assert len(table.errors) == len(rows), (len(table.errors), len(rows))
    errors = np.array(table.errors)
    return Flight(np.linalg.norm(errors[-1, :3]), np.linalg.norm(errors[-1, 3:]), errors)


# ---- plan and gains


class Plan:
    """A maneuver of `problems/`, planned in STEPS steps, and its table of waypoints."""

    def __init__(self, slew, name, kind, folder):
        self.kind = kind
        spec, file = PROBLEMS / f"{name}.toml", Path(folder) / f"{name}.json"
        require(spec.is_file(), f"there is no {spec}; run this from the root of the repository")
        self.waypoints = Path(folder) / f"{name}.csv"
        # Nodes of the true motion under held torques. Those of the discrete motion of `lie_euler`
        # have rates that lag by half a step, 5e-3 rad at the end of tracked waypoints.
        wanted = ["solver.scheme=lie_verlet", "solver.target=motion", f"maneuver.steps={STEPS}",
            f"feedback.kind={kind}"]
        for arguments in (
            ["plan", "--force", str(spec), *(part for key in wanted for part in ("--set", key)), "-q", "-o", str(file)],
            ["export", "--force", str(file), "--format", "basilisk", "-q", "-o", str(self.waypoints)],
        ):
            run = subprocess.run([slew, *arguments], check=False, capture_output=True, text=True)
            require(run.returncode == 0, f"`slew {' '.join(arguments)}` ends with {run.returncode}: {run.stderr}")
        plan = json.loads(file.read_text())
        inertia = np.array(plan["spec"]["body"]["inertia_kg_m2"])
        self.gains = np.array(plan["feedback"]["gains"])
        self.inertia = np.diag(inertia) if inertia.ndim == 1 else inertia
        self.step, path = plan["step_s"], plan["trajectory"]
        self.time, self.wxyz = path["time_s"], np.array(path["quaternion_wxyz"])
        self.rate, torque = np.array(path["angular_velocity_rad_s"]), np.array(path["torque_n_m"])
        # Rows of this scheme are of nodes, and over a step their mean is held.
        self.held = 0.5 * (torque[:-1] + torque[1:])
        target = Rotation.from_matrix(plan["spec"]["end"]["attitude"]["matrix"])
        off = np.linalg.norm(attitude_error(Rotation.from_quat(self.wxyz[-1], scalar_first=True), target))
        require(off < HELD, f"{name}: the last row of the plan is {off:.1e} rad from the target that its spec states")

    def rows(self, gains=None):
        """With gains of each step, or none."""
        gains = np.zeros((STEPS, 3, 6)) if gains is None else gains
        columns = self.time, self.wxyz, self.rate, [*self.held, np.zeros(3)], [*gains, np.zeros((3, 6))]
        return [Row(*row) for row in zip(*columns, strict=True)]


def cross(v):
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def linear_steps(rows, inertia):
    """[ζ; δω] over each step under a held δu: z' = A z + B δu. From J ω̇ = Jω × ω + u, to first
    order,

        ζ̇ = −ω* × ζ + δω,    J δω̇ = (Jω*) × δω − ω* × J δω + δu,

    with ω* of the middle of the step."""
    steps = []
    for row, after in itertools.pairwise(rows):
        rate = 0.5 * (row.rate + after.rate)
        motion = np.zeros((9, 9))
        motion[:3, :6] = np.hstack([-cross(rate), np.eye(3)])
        gyroscopic = cross(inertia @ rate) - cross(rate) @ inertia
        motion[3:6, 3:] = np.linalg.solve(inertia, np.hstack([gyroscopic, np.eye(3)]))
        moved = expm(motion * (after.time - row.time))
        steps.append((moved[:6, :6], moved[:6, 6:]))
    return steps


# ---- what is judged


def told(road, body, flight):
    print(f"{road:32} {body:18} ends {flight[0]:.1e} rad and {flight[1]:.1e} rad/s off", flush=True)


def tracked(plan):
    """Waypoints, in Basilisk's own loop."""
    rows = plan.rows()
    for body, more, promised in (("as planned", 1.0, TRACKED), ("2 % more inertia", HEAVIER, TRACKED_HEAVIER)):
        flight = fly_waypoints(plan.waypoints, rows[0], rows[-1], more * plan.inertia, plan.inertia)
        told("waypoints, mrpFeedback", body, flight)
        require(flight[0] < promised, f"{body}, tracked waypoints end {flight[0]:.1e} rad off; promised "
                                      f"are {promised:.0e}")


def held(plan):
    """Torques alone, open loop."""
    flight = fly_gains(plan.rows(), plan.inertia)
    told("held torques, open loop", "as planned", flight)
    off = max(flight.attitude, flight.rate)
    require(off < HELD, f"held torques end {off:.1e} rad or rad/s off; promised are {HELD:.0e}")
    flight = fly_gains(plan.rows(), HEAVIER * plan.inertia)
    told("held torques, open loop", "2 % more inertia", flight)
    require(flight.attitude > SHOWS, f"2 % more inertia must show in open loop, and is {flight.attitude:.1e} rad")


def steered(plan):
    """Torques and gains."""
    steps = linear_steps(plan.rows(), plan.inertia)
    gains = plan.gains
    flight = fly_gains(plan.rows(gains), plan.inertia, START_ERROR)
    told(f"torques and {plan.kind} gains", "start 0.9 mrad off", flight)
    off = flight.attitude
    require(off < LEFT, f"of a start error of 0.9 mrad the gains leave {off:.1e} rad; promised are {LEFT:.0e}")
    expected = [START_ERROR]
    for (a, b), gain in zip(steps, gains, strict=True):
        expected.append((a - b @ gain) @ expected[-1])
    expected = np.array(expected)
    for what, part in (("attitude", slice(0, 3)), ("rate", slice(3, 6))):
        off = np.abs(flight.errors - expected)[:, part].max() / np.abs(expected[:, part]).max()
        print(f"{'':32} error of {what} along the flight as predicted, to {off:.1e} of its largest")
        require(off < PREDICTED, f"with gains the {what} leaves the linear prediction by {off:.1e} of the "
                                 f"largest error")
    flight = fly_gains(plan.rows(gains), HEAVIER * plan.inertia)
    told(f"torques and {plan.kind} gains", "2 % more inertia", flight)
    off = flight.attitude
    require(off < TRACKED_HEAVIER, f"2 % more inertia, gains end {off:.1e} rad off; promised are {TRACKED_HEAVIER:.0e}")


ROADS = {
    ("xte_40s", "tvlqr"): (tracked, held, steered),
    ("xte_40s", "neighbouring"): (steered,),
    ("moving_ends", "tvlqr"): (held, steered),
    ("moving_ends", "neighbouring"): (steered,),
}

if __name__ == "__main__":
    require(len(sys.argv) == 2, "usage: basilisk.py SLEW")
    slew = Path(sys.argv[1]).resolve()
    require(slew.is_file(), f"there is no program {slew}")
    with tempfile.TemporaryDirectory() as folder:
        for (name, kind), roads in ROADS.items():
            plan = Plan(str(slew), name, kind, folder)
            print(name)
            for road in roads:
                road(plan)

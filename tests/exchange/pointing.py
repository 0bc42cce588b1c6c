"""Pointing files against ESA's engine: OSVE, with AGM inside. Run by `.ci/run`:

    python tests/exchange/pointing.py SLEW [NAME OF A TEST ...]

OSVE runs without a network and without kernels of a mission: leap seconds, bodies and circles as
orbits are written here, and the configuration of AGM comes from `ptwrapper`. The attitudes of AGM
are the judge of those that `slew timeline` reads, converts and plans, and what AGM refuses `slew`
must refuse too.
"""

import json
import math
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

SLEW = str(Path(sys.argv[1]).resolve())
RANDOM = np.random.default_rng(20321226)

LEAP_SECONDS = """KPL/LSK
\\begindata
DELTET/DELTA_T_A = 32.184
DELTET/K = 1.657D-3
DELTET/EB = 1.671D-2
DELTET/M = ( 6.239996D0 1.99096871D-7 )
DELTET/DELTA_AT = ( 36, @2015-JUL-1  37, @2017-JAN-1 )
\\begintext
"""
AU_KM = 149597870.7
# Number, centre and radius of the circle [AU] of every body that AGM asks for; -28 is JUICE.
BODIES = {
    10: (0, 0.001), 199: (10, 0.39), 299: (10, 0.72), 399: (10, 1), 301: (399, 0.0026),
    599: (10, 5.2), 6: (10, 9.5), 7: (10, 19), 8: (10, 30), 9: (10, 39),
    501: (599, 0.0028), 502: (599, 0.0045), 503: (599, 0.0072), 504: (599, 0.0126), -28: (10, 1.5),
}
KERNELS = ["leap.tls", "bodies.tpc", "circles.bsp"]
RUN = "import sys; from osve import osve; sys.exit(osve.osve().execute(*sys.argv[1:]) != 0)"


def write_kernels(folder):
    import spiceypy

    (folder / KERNELS[0]).write_text(LEAP_SECONDS)
    lines = ["KPL/PCK", "\\begindata"]
    for body in (body for body in BODIES if body >= 10):
        lines += [f"BODY{body}_RADII = ( 1000 1000 1000 )", f"BODY{body}_POLE_RA = ( 0 0 0 )",
                  f"BODY{body}_POLE_DEC = ( 90 0 0 )", f"BODY{body}_PM = ( 0 1 0 )"]
    (folder / KERNELS[1]).write_text("\n".join([*lines, "\\begintext", ""]))
    spiceypy.furnsh(str(folder / KERNELS[0]))
    try:
        first, last = (spiceypy.str2et(day) for day in ("2032-12-01", "2033-02-01"))
        handle = spiceypy.spkopn(str(folder / KERNELS[2]), "circles", 0)
        times = np.linspace(first, last, 1000)
        for body, (center, radius) in BODIES.items():
            rate = 2e-7 / radius ** 1.5 if center == 10 else 1e-5
            angle, radius = rate * (times - first) + body, radius * AU_KM
            cos, sin, zero = np.cos(angle), np.sin(angle), 0 * angle
            states = radius * np.stack([cos, sin, zero, -rate * sin, rate * cos, zero], 1)
            spiceypy.spkw09(handle, body, center, "J2000", first, last, str(body), 7, len(times),
                            states.tolist(), times.tolist())
        spiceypy.spkcls(handle)
    finally:
        spiceypy.kclear()


class Engine:
    """OSVE in a folder of its own."""

    def __init__(self, folder):
        import ptwrapper

        self.folder = folder
        for name in ("kernels", "input", "outputs"):
            (folder / name).mkdir()
        write_kernels(folder / "kernels")
        shutil.copytree(Path(ptwrapper.__file__).parent / "config/agm", folder / "agm")
        configuration = {
            "kernelsList": {"baselineRelPath": "kernels",
                            "fileList": [{"fileRelPath": name} for name in KERNELS]},
            "baselineRelPath": "agm",
            "ageConfigFileName": "cfg_agm_jui.xml",
            "fixedDefinitionsFile": "cfg_agm_jui_fixed_definitions.xml",
            "predefinedBlockFile": "cfg_agm_jui_predefined_block.xml",
            "eventDefinitionsFile": "cfg_agm_jui_event_definitions.xml",
        }
        (folder / "session.json").write_text(json.dumps({"sessionConfiguration": {
            "simulationConfiguration": {"timeStep": 20},
            "attitudeSimulationConfiguration": configuration,
            "inputFiles": {"baselineRelPath": "input", "xmlPtrPath": "timeline.ptx"},
            "outputFiles": {"baselineRelPath": "outputs", "txtAttitudeFilePath": "quaternions.csv"},
            "logging": {"stdOutLogLevel": "ERROR"},
        }}))

    def run(self, text):
        """Resolves a timeline: None, or the quaternions by time, from reference to body axes."""
        (self.folder / "input/timeline.ptx").write_text(text)
        table = self.folder / "outputs/quaternions.csv"
        table.unlink(missing_ok=True)
        run = subprocess.run([sys.executable, "-c", RUN, str(self.folder), "session.json"],
                             cwd=self.folder, capture_output=True, timeout=600)
        if run.returncode != 0:
            return None
        rows = [line.split(",") for line in table.read_text().splitlines()[1:]]
        return {row[0]: np.array([float(part) for part in row[1:]]) for row in rows}


def slew(folder, *args):
    return subprocess.run([SLEW, "timeline", *args], cwd=folder, capture_output=True, text=True,
                          timeout=600)


def told(folder, *args):
    run = slew(folder, *args, "-q", "--format", "json")
    assert run.returncode == 0, f"{args}: {run.stderr}"
    return json.loads(run.stdout)["observations"]


def apart(wxyz, reference_to_body):
    """The angle between our attitude, from body to reference, and one of AGM, its transpose."""
    w, v = wxyz[0], np.array(wxyz[1:])
    # The product of both is the identity: vector part of q p.
    vector, scalar = reference_to_body[:3], reference_to_body[3]
    error = w * vector + scalar * v + np.cross(v, vector)
    return 2 * math.asin(min(1.0, np.linalg.norm(error)))


def compare(observations, quaternions, within):
    """The largest angle [rad] over all rows of AGM within the observations."""
    worst, rows = 0.0, 0
    for observation in observations:
        begin, end = observation["begins"][:19], observation["ends"][:19]
        for time, quaternion in quaternions.items():
            # Whole seconds: the begin itself may be a fraction later.
            if begin < time[:19] < end:
                worst = max(worst, apart(observation["quaternion_wxyz"], quaternion))
                rows += 1
    assert rows >= 2 * len(observations), f"{rows} rows of {len(observations)} observations"
    assert worst < within, f"attitudes are {worst} rad apart"
    return f"{rows} rows of {len(observations)} observations within {worst:.1e} rad"


def clock(seconds):
    minutes, second = divmod(seconds, 60)
    hours, minute = divmod(int(minutes), 60)
    days, hour = divmod(hours, 24)
    return f"2032-12-{10 + days:02}T{hour:02}:{minute:02}:{second:06.3f}"


def direction():
    vector = RANDOM.normal(size=3)
    return vector / np.linalg.norm(vector)


def components(vector):
    return "".join(f"<{name}>{part:.15g}</{name}>" for name, part in zip("xyz", vector))


def random_ptr(count):
    """A timeline in the notations that PTR has."""
    blocks = []
    for k in range(count):
        boresight, axis, inertial, target = direction(), direction(), direction(), direction()
        aim = f'<boresight frame="SC">{components(boresight * RANDOM.uniform(0.5, 2))}</boresight>'
        at = components(target)
        if k % 3 == 1:
            aim = f'<boresight ref="SC_{"XYZ"[k % 9 // 3]}axis"/>'
        if k % 3 == 2:
            lon, lat, unit = math.atan2(target[1], target[0]), math.asin(target[2]), "rad"
            if k % 2:
                lon, lat, unit = math.degrees(lon), math.degrees(lat), "deg"
            at = f'<lon units="{unit}">{lon:.15g}</lon><lat units="{unit}">{lat:.15g}</lat>'
        blocks.append(f'''<block ref="OBS">
<startTime>{clock(2500 * k)}</startTime><endTime>{clock(2500 * k + 180.5)}</endTime>
<attitude ref="inertial">{aim}
<phaseAngle ref="align"><SCAxis frame="SC">{components(axis)}</SCAxis>
<inertialAxis frame="EME2000">{components(inertial)}</inertialAxis></phaseAngle>
<target frame="EME2000">{at}</target></attitude>
<metadata><comment>Number {k}</comment></metadata></block>''')
    body = '\n<block ref="SLEW"/>\n'.join(blocks)
    return f'<prm><body><segment><data><timeline frame="SC">\n{body}\n</timeline></data></segment></body></prm>\n'


def prm(blocks, phase, frame="EME2000"):
    """A message with one definition; `phase` has the axes of the phase angle, or is None."""
    numbers = lambda vector: " ".join(f"{part:.15g}" for part in vector)
    axes = "" if phase is None else f'''<phaseAngle>
<frameDir frame="SC" coord="cartesian" units="">{numbers(phase[0])}</frameDir>
<baseFrameDir frame="{frame}" coord="cartesian" units="">{numbers(phase[1])}</baseFrameDir>
<projAngle localName="phaseAngle"/></phaseAngle>'''
    rows = []
    for begin, end, boresight, target, angle in blocks:
        angle = "" if angle is None else f'<phaseAngle units="deg">{angle}</phaseAngle>'
        rows.append(f'''<block ref="inertial"><blockStart>{begin}</blockStart><blockEnd>{end}</blockEnd>
<boresight frame="SC" coord="cartesian" units="">{numbers(boresight)}</boresight>
<target frame="{frame}" coord="cartesian" units="">{numbers(target)}</target>{angle}</block>''')
    return f'''<?xml version="1.0" encoding="UTF-8"?>
<prm id="CCSDS_PRM_VERS" version="1.0">
<header><CREATION_DATE>2032-01-01T00:00:00</CREATION_DATE><ORIGINATOR>TEST</ORIGINATOR></header>
<body><segment><metadata>
<OBJECT_NAME>JUICE</OBJECT_NAME><OBJECT_ID>2023-053A</OBJECT_ID><TIME_SYSTEM>UTC</TIME_SYSTEM>
<START_TIME>{blocks[0][0]}</START_TIME><STOP_TIME>{blocks[-1][1]}</STOP_TIME>
<definition name="test" version="1.0">
<frame baseFrame="none" name="{frame}"/><frame baseFrame="{frame}" name="SC"/>
<block name="inertial"><startEpoch localName="blockStart"/><endEpoch localName="blockEnd"/>
<attitude><frameDir localName="boresight"/><baseFrameDir localName="target"/>{axes}</attitude></block>
</definition></metadata>
<data><timeline frame="SC">{"".join(rows)}</timeline></data></segment></body></prm>
'''


def reads_as_agm_does(engine, folder):
    text = random_ptr(24)
    (folder / "random.ptx").write_text(text)
    # The two programs normalise the vectors of a file each in its own way.
    return compare(told(folder, "random.ptx"), engine.run(text), 1e-9)


def converts_to_what_agm_resolves(engine, folder):
    """From PTR to PRM and back, and from phase angles of a PRM, also in another frame."""
    results = []
    (folder / "random.ptx").write_text(random_ptr(12))
    assert slew(folder, "random.ptx", "-q", "-o", "random.xml", "--force").returncode == 0
    assert slew(folder, "random.xml", "-q", "-o", "back.ptx").returncode == 0
    quaternions = engine.run((folder / "back.ptx").read_text())
    assert quaternions is not None, "AGM refuses the PTR of a PRM of a PTR"
    results.append(compare(told(folder, "random.ptx"), quaternions, 1e-9))
    for frame in ("EME2000", "GCRF"):
        blocks = [(clock(2500 * k), clock(2500 * k + 180.5), direction(), direction(),
                   RANDOM.uniform(-180, 180)) for k in range(12)]
        name = f"{frame}.xml"
        (folder / name).write_text(prm(blocks, (direction(), direction()), frame))
        assert slew(folder, name, "-q", "-o", f"{frame}.ptx").returncode == 0
        quaternions = engine.run((folder / f"{frame}.ptx").read_text())
        assert quaternions is not None, f"AGM refuses the PTR of {name}"
        # The attitudes of the message are in its own frame, and AGM has EME2000.
        results.append(compare(told(folder, f"{frame}.ptx"), quaternions, 1e-9))
    return "; ".join(results)


SPEC = """format = 1
epoch = "2032-12-09T23:30:00 UTC"
[names]
reference_frame = "EME2000"
body_frame = "SC"
[body]
inertia_kg_m2 = [[27755, -96, -1265], [-96, 9682, 122], [-1265, 122, 26290]]
[actuators]
torque_axes_body = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
torque_limit_n_m = 2
[start]
attitude = { axis = [0, 0, 1], angle_deg = 0 }
[end]
attitude = { axis = [0, 0, 1], angle_deg = 0 }
[maneuver]
minimize = "time"
steps = 60
"""


def resolves_free_rolls(engine, folder):
    blocks = [(clock(2500 * k), clock(2500 * k + 180.5), direction(), direction(), None) for k in range(3)]
    (folder / "free.xml").write_text(prm(blocks, None))
    (folder / "craft.toml").write_text(SPEC)
    run = slew(folder, "free.xml", "-q", "-o", "free.ptx")
    assert run.returncode == 2 and "E0145" in run.stderr, run.stderr
    observations = told(folder, "free.xml", "--spec", "craft.toml", "-o", "resolved.ptx")
    for observation, (begin, end, *_) in zip(observations, blocks):
        assert observation["begins"][:23] == begin and observation["ends"][:23] == end, observation
        assert observation["slew"]["status"] == "solved", observation
    quaternions = engine.run((folder / "resolved.ptx").read_text())
    assert quaternions is not None, "AGM refuses the resolved timeline"
    return compare(observations, quaternions, 1e-9)


# Changes of the first block that AGM refuses.
REFUSED = [
    ("<prm>", '<prm version="1">'),
    ("<prm>", "<prm><header><format>1</format></header>"),
    ("<segment>", "<segment><metadata></metadata>"),
    ('<timeline frame="SC">', "<timeline>"),
    ('<timeline frame="SC">', '<timeline frame="MGA">'),
    ('<timeline frame="SC">', '<timeline frame="SC"><block ref="SLEW"/>'),
    ("</timeline>", '<block ref="SLEW"/></timeline>'),
    ('<block ref="SLEW"/>', '<block ref="SLEW"/><block ref="SLEW"/>'),
    ('<block ref="SLEW"/>', '<block ref="SLEW"><startTime>2032-12-10T00:10:00</startTime></block>'),
    ('<block ref="OBS">', '<block ref="UNKNOWN">'),
    ('<block ref="OBS">', '<block ref="OBS" id="1">'),
    ('<block ref="OBS">', '<block ref="OBS" name="first">'),
    ('<attitude ref="inertial">', '<attitude ref="nowhere">'),
    ('<boresight ref="SC_Xaxis"/>', '<boresight ref="SC_negXaxis"/>'),
    ('<boresight ref="SC_Xaxis"/>', '<boresight frame="SC" ref="SC_Xaxis"/>'),
    ('<boresight ref="SC_Xaxis"/>', '<boresight frame="SC">1. 0. 0.</boresight>'),
    ('<boresight ref="SC_Xaxis"/>', '<boresight frame="SC"><x>0</x><y>0</y><z>0</z></boresight>'),
    ('<boresight ref="SC_Xaxis"/>', '<boresight frame="SC"><x>9D-1</x><y>0</y><z>0</z></boresight>'),
    ('<boresight ref="SC_Xaxis"/>', ""),
    ("</inertialAxis>", '</inertialAxis><angle units="deg">10</angle>'),
    ("<x>0</x><y>0</y><z>1</z></SCAxis>", "<x>1</x><y>0</y><z>0</z></SCAxis>"),
    ('<target frame="EME2000">', '<target frame="J2000">'),
    ('<lon units="deg">', "<lon>"),
    ("2032-12-10T00:00:00", "2032-345T00:00:00"),
    ("2032-12-10T00:00:00", "2032-12-10T00:00:00Z"),
    ("2032-12-10T00:00:00", "2032-12-10T00:00:00.5"),
    ("2032-12-10T00:00:00", "2032-12-10T00:00:00.123456"),
    ("2032-12-10T00:00:00", "2032-12-10 00:00:00"),
    ("2032-12-10T00:00:00", "2032-02-30T00:00:00"),
    ("2032-12-10T00:00:00", "2032-12-10T00:05:00"),
    ("2032-12-10T00:00:00", "2032-12-10T00:06:00"),
    ("2032-12-10T01:00:00", "2032-12-10T00:05:00"),
    ("2032-12-10T01:00:00", "2032-12-10T00:04:00"),
]
TWO_BLOCKS = """<prm><body><segment><data><timeline frame="SC">
<block ref="OBS"><startTime>2032-12-10T00:00:00</startTime><endTime>2032-12-10T00:05:00</endTime>
<attitude ref="inertial"><boresight ref="SC_Xaxis"/>
<phaseAngle ref="align"><SCAxis frame="SC"><x>0</x><y>0</y><z>1</z></SCAxis>
<inertialAxis frame="EME2000"><x>0</x><y>0</y><z>1</z></inertialAxis></phaseAngle>
<target frame="EME2000"><lon units="deg">10</lon><lat units="deg">20</lat></target></attitude></block>
<block ref="SLEW"/>
<block ref="OBS"><startTime>2032-12-10T01:00:00</startTime><endTime>2032-12-10T01:05:00</endTime>
<attitude ref="inertial"><boresight ref="SC_Yaxis"/>
<phaseAngle ref="align"><SCAxis frame="SC"><x>0</x><y>0</y><z>1</z></SCAxis>
<inertialAxis frame="EME2000"><x>0</x><y>0</y><z>1</z></inertialAxis></phaseAngle>
<target frame="EME2000"><x>1</x><y>2</y><z>3</z></target></attitude></block>
</timeline></data></segment></body></prm>
"""


def refuses_what_agm_refuses(engine, folder):
    (folder / "two.ptx").write_text(TWO_BLOCKS)
    assert engine.run(TWO_BLOCKS) is not None and slew(folder, "two.ptx").returncode == 0
    for before, after in REFUSED:
        text = TWO_BLOCKS.replace(before, after, 1)
        assert text != TWO_BLOCKS, before
        assert engine.run(text) is None, f"AGM reads {after}"
        (folder / "refused.ptx").write_text(text)
        run = slew(folder, "refused.ptx")
        assert run.returncode == 8 and "E0154" in run.stderr, f"{after}: {run.stderr}"
        assert re.search(r"refused\.ptx:\d+:\d+: error", run.stderr), run.stderr
    return f"{len(REFUSED)} constructs"


def main():
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        (folder / "engine").mkdir()
        engine = Engine(folder / "engine")
        tests = {test.__name__: test for test in (reads_as_agm_does, converts_to_what_agm_resolves,
                                                  resolves_free_rolls, refuses_what_agm_refuses)}
        for name in sys.argv[2:] or tests:
            print(f"{name}: {tests[name](engine, folder)}", flush=True)


main()

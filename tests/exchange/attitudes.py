"""Attitudes of other kinds of files than ephemerides of CCSDS, each with the word that is due, from
`slew verify` and from `[start] attitude = { file = … }`: attitude files of STK, C-kernels of SPICE,
attitude parameter messages (APM). Run by corpus.py.

Kernels are written and read by SPICE (spiceypy), turns at one rate and polynomials are SciPy's; the
other truth is the formula of the motion. All files are written here.
"""

import subprocess

import numpy as np
from scipy.interpolate import BarycentricInterpolator, CubicHermiteSpline
from scipy.spatial.transform import Rotation, Slerp

from motion import DURATION, TIMES, apart, begins, motion, spec

# Of twelve digits [rad].
WITHIN = 2e-11
ROWS = TIMES[::5]


def one_rate(time, rows=ROWS):
    return Slerp(rows, Rotation.concatenate([motion(row)[0] for row in rows]))(time)


def components(time, degree, rows=ROWS):
    """Lagrange's polynomial of a degree through the components of the rows about a moment."""
    count = degree + 1
    first = int(np.clip(np.searchsorted(rows, time) - (count + 1) // 2, 0, len(rows) - count))
    near = rows[first:first + count]
    quaternions = signed([motion(row)[0].as_quat() for row in near])
    return Rotation.from_quat(BarycentricInterpolator(near, quaternions)(time))


def through_rates(time, rows=ROWS):
    """Hermite's polynomial of degree 3 through components and their derivatives."""
    quaternions = signed([motion(row)[0].as_quat() for row in rows])
    slopes = []
    for quaternion, row in zip(quaternions, rows, strict=True):
        rate, (vector, w) = motion(row)[1], (quaternion[:3], quaternion[3])
        slopes.append([*(0.5 * (w * rate + np.cross(vector, rate))), -0.5 * vector @ rate])
    return Rotation.from_quat(CubicHermiteSpline(rows, quaternions, slopes)(time))


def signed(quaternions):
    found = [quaternions[0]]
    for quaternion in quaternions[1:]:
        found.append(quaternion if quaternion @ found[-1] > 0 else -quaternion)
    return np.array(found)


# ---- STK


def stk(kind="AttitudeTimeQuaternions", keys="", axes="J2000", end="\n"):
    lines = ["stk.v.11.0", "# a comment", "BEGIN Attitude", f"NumberOfAttitudePoints {len(ROWS)}",
             "BlockingFactor 20", *filter(None, keys.split("\n")), "ScenarioEpoch 21 Nov 2026 07:00:00.000",
             "CentralBody Earth", f"CoordinateAxes {axes}", kind, ""]
    for row in ROWS:
        attitude, rate = motion(row)
        x, y, z, w = attitude.as_quat()
        first = "scalarfirst" in kind.lower()
        numbers = [row, *([w, x, y, z] if first else [x, y, z, w])]
        lines.append(" ".join(f"{value:.14f}" for value in [*numbers, *(
            np.degrees(rate) if kind.lower().endswith("angvels") else [])]))
    return end.join([*lines, "", "END Attitude"]) + end


ORDER = "InterpolationOrder {}\n"
LAGRANGE = "InterpolationMethod Lagrange\n" + ORDER
HERMITE = "InterpolationMethod Hermite\n" + ORDER
# The attitude between rows, and a word of the warning that is due.
STK = {
    "quaternions": (stk(), one_rate, ""),
    "scalar first": (stk("AttitudeTimeQuatScalarFirst"), one_rate, ""),
    "rates": (stk("AttitudeTimeQuatAngVels", ORDER.format(1)), one_rate, ""),
    "scalar first, with rates": (stk("AttitudeTimeQuatScalarFirstAngVels", ORDER.format(1)), one_rate, ""),
    "lower case": (stk("attitudetimequaternions", ORDER.format(1).lower()), one_rate, ""),
    "lines of DOS": (stk(end="\r\n"), one_rate, ""),
    "tabs": (stk().replace(" 0.", "\t0."), one_rate, ""),
    "seconds": (stk(keys="TimeFormat EpSec\n"), one_rate, ""),
    "order 1": (stk(keys=LAGRANGE.format(1)), one_rate, ""),
    "order alone": (stk(keys=ORDER.format(5)), lambda time: components(time, 5), ""),
    "Lagrange 3": (stk(keys=LAGRANGE.format(3)), lambda time: components(time, 3), ""),
    "Lagrange 7": (stk(keys=LAGRANGE.format(7)), lambda time: components(time, 7), ""),
    "Hermite 3": (stk("AttitudeTimeQuatAngVels", HERMITE.format(3)), through_rates, ""),
    "Hermite without rates": (stk(keys=HERMITE.format(3)), one_rate, "HERMITE needs rates"),
    "order 0": (stk(keys=ORDER.format(0)), one_rate, "Lagrange of degree 0"),
    "order 30": (stk(keys=LAGRANGE.format(30)), one_rate, "25 is the highest supported degree"),
    "splines": (stk(keys="InterpolationMethod Spline\n" + ORDER.format(3)), one_rate, "Spline, which is not supported"),
    "a pattern": (stk(keys="RepeatPattern\n"), one_rate, "`RepeatPattern`, which is not supported"),
}
REFUSED_STK = {
    **{f"rows of {kind}": (stk().replace("AttitudeTimeQuaternions", kind), f"rows of {kind} are not supported")
       for kind in ("AttitudeTimeAngVels", "AttitudeTimeEulerAngles", "AttitudeTimeEulerAngleRates",
                    "AttitudeTimeEulerAnglesAndRates", "AttitudeTimeYPRAngles", "AttitudeTimeYPRAngleRates",
                    "AttitudeTimeYPRAnglesAndRates", "AttitudeTimeDCM", "AttitudeTimeDCMAngVels",
                    "AttitudeTimeECIVector", "AttitudeTimeECFVector")},
    **{f"times in {name}": (stk(keys=f"TimeFormat {name}\n"), f"times in the format {name}")
       for name in ("EpMin", "EpHr", "UTCG", "JDate")},
    **{f"axes {name}": (stk(axes=name), "the rotation between the two is unknown")
       for name in ("Fixed", "TrueOfDate", "MeanOfDate", "B1950", "Custom Body Satellite/A")},
    "axes of an epoch": (stk(axes="TEMEOfEpoch\nCoordinateAxesEpoch 1 Jan 2000 00:00:00.0"), "axes of a date"),
    "no epoch": (stk().replace("ScenarioEpoch", "#"), "no ScenarioEpoch"),
    "cut off": (stk().replace("END Attitude", ""), "the file is cut off"),
    "a row too few": (stk().replace(f"Points {len(ROWS)}", f"Points {len(ROWS) + 1}"), "may be cut off"),
    "numbers of another format": (stk("AttitudeTimeQuatAngVels").replace("QuatAngVels", "Quaternions"), "8 numbers"),
    "an ephemeris": (stk().replace("Attitude\n", "Ephemeris\n"), "give an attitude file of STK"),
}


# ---- SPICE

STRUCTURE = -125544000
CLOCK = ("one tick is a microsecond of TT", "Epoch: 2026-11-21T07:00:00 UTC")


def kernel(path, kind=3, frame="J2000", rates=True, starts=(0,), segments=1, clock=CLOCK, rows=ROWS, turned=None):
    """A kernel by SPICE, whose clock counts microseconds from the epoch."""
    import spiceypy

    path.unlink(missing_ok=True)
    handle = spiceypy.ckopn(str(path), "corpus", 0)
    size = -(-len(rows) // segments)
    for first in range(0, len(rows) - 1, size):
        part = rows[first:first + size + 1]
        ticks, quaternions, velocities = part * 1e6, [], []
        for row in part:
            attitude, rate = motion(row)
            attitude = (turned or Rotation.identity()) * attitude
            # The C-matrix leads from reference to body components.
            x, y, z, w = attitude.inv().as_quat()
            quaternions.append([w, x, y, z])
            velocities.append(attitude.apply(rate))
        head = (handle, ticks[0], ticks[-1], STRUCTURE, frame)
        if kind == 2:
            spiceypy.ckw02(*head, "segment", len(part) - 1, ticks[:-1], ticks[1:], quaternions[:-1],
                velocities[:-1], np.full(len(part) - 1, 1e-6))
        elif kind == 1:
            spiceypy.ckw01(*head, rates, "segment", len(part), ticks, quaternions, velocities)
        else:
            spiceypy.ckw03(*head, rates, "segment", len(part), ticks, quaternions, velocities, len(starts),
                [ticks[start] for start in starts])
    if clock:
        spiceypy.dafac(handle, list(clock))
    spiceypy.ckcls(handle)
    return path.read_bytes()


def swapped(data):
    """The kernel with its bytes in the other order."""
    data = bytearray(data)
    first = int.from_bytes(data[76:80], "little")

    def swap(at, size):
        data[at:at + size] = data[at:at + size][::-1]
    for at in (8, 12, 76, 80, 84):
        swap(at, 4)
    record = 1024 * (first - 1)
    for k in range(5):
        swap(record + 8 * k, 8)
    for k in range(6):
        swap(record + 40 + 4 * k, 4)
    for at in range(1024 * (first + 1), len(data), 8):
        swap(at, 8)
    data[88:96] = b"BIG-IEEE"
    return bytes(data)


def by_spice(path, time):
    """The attitude of SPICE, or none in a gap."""
    import spiceypy

    spiceypy.furnsh(str(path))
    try:
        matrix, _ = spiceypy.ckgp(STRUCTURE, time * 1e6, 0.0, "J2000")
        return Rotation.from_matrix(matrix).inv()
    except spiceypy.NotFoundError:
        return None
    finally:
        spiceypy.kclear()


def ecliptic():
    import spiceypy

    return Rotation.from_matrix(spiceypy.pxform("J2000", "ECLIPJ2000", 0.0))


KERNELS = {
    "type 3": {},
    "without rates": {"rates": False},
    "two intervals": {"starts": (0, 5)},
    "three segments": {"segments": 3},
    "many rows": {"rows": np.linspace(0.0, DURATION, 501)},
    "many intervals": {"rows": np.linspace(0.0, DURATION, 501), "starts": range(0, 500, 4)},
    "the other order of bytes": {},
    "the ecliptic": {"frame": "ECLIPJ2000"},
}
REFUSED_KERNELS = {
    "type 1": ({"kind": 1}, "segments of type 1 are not supported"),
    "type 2": ({"kind": 2}, "segments of type 2 are not supported"),
    "a clock of others": ({"clock": None}, "does not state the tick length"),
    "B1950": ({"frame": "B1950"}, "map to B1950"),
    "the galaxy": ({"frame": "GALACTIC"}, "the frame of SPICE with the number 13"),
}


# ---- APM

HEADER = "CCSDS_APM_VERS = {}\nCREATION_DATE = 2026-11-20T00:00:00\nORIGINATOR = TEST\n"
KEYS = "OBJECT_NAME = DEMO\nOBJECT_ID = 2026-001A\nCENTER_NAME = EARTH\nTIME_SYSTEM = UTC\n"
HEAD = HEADER.format("2.0") + f"META_START\n{KEYS}META_STOP\nEPOCH = 2026-11-21T07:00:00.000\n"
OLD = HEADER.format("1.0") + KEYS + "EPOCH = 2026-11-21T07:00:00.000\n"
TRUTH = motion(0.0)[0]
STAR = TRUTH * Rotation.from_euler("X", 90, degrees=True)


def block(kind, attitude, a="EME2000", b="SC_BODY_1", keys=""):
    if kind == "QUAT":
        numbers = dict(zip(("Q1", "Q2", "Q3", "QC"), attitude.as_quat(), strict=True))
    else:
        numbers = dict(zip(("ANGLE_1", "ANGLE_2", "ANGLE_3"), attitude.as_euler(kind, degrees=True), strict=True))
        kind, keys = "EULER", f"EULER_ROT_SEQ = {kind}\n{keys}"
    numbers = "".join(f"{key} = {value:.14f}\n" for key, value in numbers.items())
    return f"{kind}_START\nREF_FRAME_A = {a}\nREF_FRAME_B = {b}\n{keys}{numbers}{kind}_STOP\n"


def old(attitude, a, b, direction):
    return (f"{OLD}Q_FRAME_A = {a}\nQ_FRAME_B = {b}\nQ_DIR = {direction}\n"
            + "".join(f"{key} = {value:.14f}\n" for key, value in zip(("Q1", "Q2", "Q3", "QC"), attitude.as_quat(),
                strict=True)))


STATES = {"QUAT": "quaternionState", "EULER": "eulerAngleState"}


def xml(*blocks, units=False, wrapped=False):
    states = ""
    for text in blocks:
        kind, _, rest = text.partition("_START\n")
        lines = [line.split(" = ") for line in rest.splitlines() if " = " in line]
        elements = ["<{0}{1}>{2}</{0}>".format(key, " units=\"deg\"" if units and key[:5] == "ANGLE" else "", value)
            for key, value in lines]
        if kind == "QUAT":
            elements[2:] = ["<quaternion>", *elements[2:], "</quaternion>"]
        states += f"<{STATES[kind]}>{''.join(elements)}</{STATES[kind]}>"
    keys = "".join("<{0}>{1}</{0}>".format(*line.split(" = ")) for line in KEYS.splitlines())
    text = (f"<apm id=\"CCSDS_APM_VERS\" version=\"2.0\"><header><COMMENT>of it</COMMENT><CREATION_DATE>"
            f"2026-11-20T00:00:00</CREATION_DATE><ORIGINATOR>TEST</ORIGINATOR></header><body><segment><metadata>"
            f"{keys}</metadata><data><EPOCH>2026-11-21T07:00:00.000</EPOCH>{states}</data></segment></body></apm>")
    return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n" + (f"<ndm>{text}</ndm>" if wrapped else text)


QUAT = block("QUAT", TRUTH)
OF_STAR = block("QUAT", STAR, b="STARTRACKER_1")
OF_ORBIT = block("QUAT", STAR, a="LVLH")
MOUNTED = block("QUAT", STAR, a="STARTRACKER_1")
SPIN = ("SPIN_START\nREF_FRAME_A = EME2000\nREF_FRAME_B = STARTRACKER_1\nSPIN_ALPHA = 1\nSPIN_DELTA = 2\n"
        "SPIN_ANGLE = 3\nSPIN_ANGLE_VEL = 4 [deg/s]\nSPIN_STOP\n")
REST = ("ANGVEL_START\nREF_FRAME_A = EME2000\nREF_FRAME_B = SC_BODY_1\nANGVEL_FRAME = SC_BODY_1\nANGVEL_X = 0.1\n"
        "ANGVEL_Y = 0\nANGVEL_Z = 0\nANGVEL_STOP\nINERTIA_START\nINERTIA_REF_FRAME = SC_BODY_1\nIXX = 1\nIYY = 1\n"
        "IZZ = 1\nIXY = 0\nIXZ = 0\nIYZ = 0\nINERTIA_STOP\n")
APM = {
    "a quaternion": HEAD + QUAT,
    "the body first": HEAD + block("QUAT", TRUTH.inv(), "SC_BODY_1", "EME2000"),
    **{f"angles {order}": HEAD + block(order, TRUTH) for order in ("ZYX", "XYZ", "ZXZ", "YXY", "YZX")},
    "angles, body first": HEAD + block("XZY", TRUTH.inv(), "SC_BODY_1", "EME2000"),
    "angles by figures": HEAD + block("ZYX", TRUTH).replace("= ZYX", "= 321"),
    "units": HEAD + block("ZYX", TRUTH).replace("\nANGLE_3", " [deg]\nANGLE_3"),
    "both": HEAD + QUAT + block("ZYX", TRUTH),
    "with a star tracker first": HEAD + OF_STAR + QUAT,
    "with a star tracker behind": HEAD + QUAT + OF_STAR,
    "with angles of a star tracker": HEAD + block("ZYX", STAR, b="STARTRACKER_1") + QUAT,
    "with the frame of the orbit first": HEAD + OF_ORBIT + QUAT,
    "with the place of a star tracker": HEAD + MOUNTED + QUAT,
    "with a spin, rates and inertia": HEAD + SPIN + QUAT + REST,
    "with derivatives": HEAD + QUAT.replace("QUAT_STOP", "Q1_DOT = 0 [1/s]\nQ2_DOT = 0\nQ3_DOT = 0\nQC_DOT = 0\nQUAT_STOP"),
    "comments": HEAD.replace("META_START", "COMMENT a = b\nMETA_START\nCOMMENT c")
    + QUAT.replace("QUAT_START\n", "QUAT_START\nCOMMENT Q1 = 7\n"),
    "lines of DOS": (HEAD + QUAT).replace("\n", "\r\n"),
    "TAI": (HEAD + QUAT).replace("UTC", "TAI").replace("00:00.000", "00:37.000"),
    "day of the year": (HEAD + QUAT).replace("2026-11-21", "2026-325"),
    "old, from A to B": old(TRUTH, "EME2000", "SC_BODY_1", "A2B"),
    "old, from B to A": old(TRUTH.inv(), "EME2000", "SC_BODY_1", "B2A"),
    "old, body first": old(TRUTH.inv(), "SC_BODY_1", "EME2000", "A2B"),
    "old, body first, from B to A": old(TRUTH, "SC_BODY_1", "EME2000", "B2A"),
    "XML": xml(QUAT),
    "XML of angles": xml(block("ZXZ", TRUTH), units=True),
    "XML in <ndm>": xml(QUAT, wrapped=True),
    "XML with the frame of the orbit first": xml(OF_ORBIT, QUAT),
    "XML with a star tracker first": xml(OF_STAR, block("XYZ", TRUTH)),
}
REFUSED_APM = {
    "another moment": ((HEAD + QUAT).replace("07:00:00.000", "07:00:01.000"), "is needed"),
    "a spin alone": (HEAD + SPIN, "no quaternion and no Euler angles"),
    "contradicting": (HEAD + QUAT + block("ZYX", STAR), "two attitudes of SC_BODY_1 differ by 90.0 deg"),
    "of two frames": (HEAD + OF_STAR + block("QUAT", TRUTH, b="STARTRACKER_2"),
                      "the attitudes of STARTRACKER_1 and STARTRACKER_2 differ by 90.0 deg"),
    "of the orbit": (HEAD + OF_ORBIT, "map to LVLH"),
    "of frames of the spacecraft": (HEAD + MOUNTED, "are both frames of the spacecraft"),
    "radians": ((HEAD + block("ZYX", TRUTH)).replace("\nANGLE_3", " [rad]\nANGLE_3"), "the unit rad"),
    "too long": (HEAD + QUAT.replace("Q1 = ", "Q1 = 1"), "the quaternion has the length"),
    "a number is missing": (HEAD + QUAT.replace("Q3 =", "COMMENT Q3 ="), "the attitude has no `Q3`"),
    "two messages": (HEAD + QUAT + HEAD.replace("DEMO", "OTHER") + OF_STAR, "2 messages with attitudes: DEMO, OTHER"),
    "old angles": (f"{OLD}EULER_FRAME_A = EME2000\nEULER_FRAME_B = SC_BODY_1\nEULER_DIR = A2B\nEULER_ROT_SEQ = 321\n"
                   "X_ANGLE = 1\nY_ANGLE = 2\nZ_ANGLE = 3\n", "Euler angles of version 1.0 are not supported"),
    "another version": (HEAD.replace("2.0", "3.0") + QUAT, "version 3.0 is not known"),
}

# Messages of other kinds, by keywords and in XML: their name, in words too.
OTHERS = {
    "ACM": "an attitude comprehensive message (ACM)",
    "OPM": "an orbit parameter message (OPM)",
    "OMM": "an orbit mean-elements message (OMM)",
    "OEM": "an orbit ephemeris message (OEM)",
    "OCM": "an orbit comprehensive message (OCM)",
    "CDM": "a conjunction data message (CDM)",
    "TDM": "a tracking data message (TDM)",
}


def of_others():
    for kind, word in OTHERS.items():
        low = kind.lower()
        inside = f"{low} id=\"CCSDS_{kind}_VERS\" version=\"2.0\"><header/></{low}>"
        yield kind, f"CCSDS_{kind}_VERS = 2.0\nCREATION_DATE = 2026-11-20T00:00:00\n", word
        yield f"{kind} in XML", f"<?xml version=\"1.0\"?>\n<{inside}", word
        yield f"{kind} in <ndm>", f"<?xml version=\"1.0\"?>\n<ndm><{inside}</ndm>", word
        yield f"{kind} with a prefix", f"<n:{inside}".replace(f"</{low}", f"</n:{low}").replace(" id=",
            " xmlns:n=\"urn:n\" id="), word


# ---- what is to be said


class Files:
    def __init__(self, slew, folder):
        self.slew, self.folder, self.count = slew, folder, 0
        (folder / "spec.toml").write_text(spec())

    def put(self, data, name="file"):
        (self.folder / name).write_bytes(data if isinstance(data, bytes) else data.encode())
        self.count += 1
        return name

    def begins_with(self, style, file, truth, moments, within, word=""):
        for time in moments:
            found, words = begins(self.slew, self.folder, file, float(time))
            expected = truth(float(time))
            if expected is None:
                assert found is None and "the file has no attitude" in words, f"{style}, {time}: {words}"
                continue
            assert found is not None, f"{style}, {time}: {words}"
            assert apart(found, expected) < within, f"{style}, {time}: {apart(found, expected):.1e}"
            assert word in words if word else "W0092" not in words, f"{style}: {words}"

    def verified(self, style, file, code, word):
        run = subprocess.run([self.slew, "verify", file, "--spec", "spec.toml"], cwd=self.folder,
                             capture_output=True, text=True)
        assert run.returncode == code and word in run.stderr, f"{style}: {run.returncode} {run.stderr}"

    def refused(self, style, file, word, motion_too=True):
        found, words = begins(self.slew, self.folder, file)
        assert found is None and "E0092" in words and word in words, f"{style}: {words}"
        if motion_too:
            self.verified(style, file, 8, word)


def corpus(slew, folder, random):
    files = Files(slew, folder)
    moments = [0.0, 10.0, DURATION, *(round(random.uniform(0.0, DURATION), 3) for _ in range(3))]
    for style, (text, truth, word) in STK.items():
        file = files.put(text)
        files.begins_with(f"STK, {style}", file, truth, moments, WITHIN, word)
        files.verified(f"STK, {style}", file, 0, word or "attitudes agree")
    for style, (text, word) in REFUSED_STK.items():
        files.refused(f"STK, {style}", files.put(text), word)
    stk_files = files.count
    for style, how in KERNELS.items():
        path = folder / "file.bc"
        how = how | ({"turned": ecliptic()} if "frame" in how else {})
        files.put(kernel(path, **how), "file.bc")
        if style == "the other order of bytes":
            path.write_bytes(swapped(path.read_bytes()))
        files.begins_with(f"CK, {style}", "file.bc", lambda time: by_spice(path, time), moments, WITHIN)
        gaps = len(how.get("starts", ())) > 1
        files.verified(f"CK, {style}", "file.bc", 7 if gaps else 0, "do not agree" if gaps else "attitudes agree")
    for style, (how, word) in REFUSED_KERNELS.items():
        files.put(kernel(folder / "file.bc", **how), "file.bc")
        files.refused(f"CK, {style}", "file.bc", word)
    kernels = files.count - stk_files
    for style, text in APM.items():
        file = files.put(text)
        files.begins_with(f"APM, {style}", file, lambda _: TRUTH, [0.0], WITHIN)
        files.verified(f"APM, {style}", file, 8, "it has only one attitude")
    for style, (text, word) in REFUSED_APM.items():
        files.refused(f"APM, {style}", files.put(text), word, motion_too=False)
    # The frame of the star tracker alone, which may be the body's: told, or named by the spec.
    file = files.put(HEAD + OF_STAR)
    files.begins_with("APM of a star tracker", file, lambda _: STAR, [0.0], WITHIN, "W0092")
    file = files.put(HEAD + OF_STAR + QUAT)
    names = "reference_frame = \"EME2000\"\nbody_frame = \"STARTRACKER_1\""
    found, words = begins(slew, folder, file, names=names)
    assert found is not None and apart(found, STAR) < WITHIN, words
    messages = files.count - stk_files - kernels
    for style, text, word in of_others():
        files.refused(style, files.put(text), word)
    others = files.count - stk_files - kernels - messages
    print(f"{stk_files} files of STK, {kernels} C-kernels, {messages} APM and {others} messages of other kinds have "
          f"their word, attitudes those of SciPy and SPICE", flush=True)

"""Attitude ephemerides in every legal style, read by `slew verify` and by programs that are not
ours: Orekit, ccsds-ndm, SPICE. Run by `.ci/run`:

    python tests/exchange/corpus.py SLEW [NAME OF A STYLE ...]

Messages with orbits stand in orbits.py, other files with attitudes in attitudes.py, and are run with
them. All files are written here, by formulas of SciPy, of the motion in motion.py. Every reader must
find its attitudes and rates, `slew verify` must say that they agree with the maneuver, and a plan
must begin with the attitude of the file at any moment.
"""

import json
import math
import os
import random
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

import attitudes
import orbits
from motion import TIMES, apart, begins, motion, spec
from test_exchange import LEAPSECONDS, orekit_or_none

SLEW = str(Path(sys.argv[1]).resolve())
# To a hundredth of a degree, as `slew verify` has it.
ATTITUDE, RATE = 2e-4, 2e-6
# Nine digits, the bias between ICRF and J2000, and the cubic between rows two seconds apart.
BETWEEN = 2e-7

# ---- styles

BASE = {
    "version": "2.0", "xml": False, "type": "QUATERNION", "a": "EME2000", "b": "SC_BODY_1", "direction": None,
    "order": None,
    "sequence": None, "rate_frame": None, "scale": "UTC", "day": False, "decimals": 3, "digits": 9,
    "exponent": False, "lower": False,
    "end": "\n", "comments": False, "extra": False, "blocks": [], "flip": 0, "units": False, "quote": '"',
    "turned": None,
    # Which readers know the style: all but where another program leaves the standard, with the
    # reason beside it.
    "orekit": True, "ndm": True,
}
OLD = {"version": "1.0", "direction": "A2B", "ndm": "version 2 alone"}
XML = {"xml": True}
ANGVEL = {"type": "QUATERNION/ANGVEL", "rate_frame": "REF_FRAME_B"}
STYLES = {
    "plain": {},
    "body first": {"a": "SC_BODY_1", "b": "EME2000"},
    "rates": ANGVEL,
    "rates in the axes of A": ANGVEL | {"rate_frame": "REF_FRAME_A"},
    "rates in the axes of EME2000": ANGVEL | {"rate_frame": "EME2000"},
    "rates, frame by its name": ANGVEL | {"rate_frame": "SC_BODY_1"},
    "rates, body first": ANGVEL | {"a": "SC_BODY_1", "b": "EME2000", "rate_frame": "REF_FRAME_A"},
    "derivatives": {"type": "QUATERNION/DERIVATIVE"},
    "Euler angles ZYX": {"type": "EULER_ANGLE", "sequence": "ZYX"},
    "Euler angles XYZ": {"type": "EULER_ANGLE", "sequence": "XYZ"},
    "Euler angles ZXZ": {"type": "EULER_ANGLE", "sequence": "ZXZ"},
    "Euler angles and rates": {"type": "EULER_ANGLE/ANGVEL", "sequence": "ZYX", "rate_frame": "REF_FRAME_B"},
    "Euler angles and derivatives": {"type": "EULER_ANGLE/DERIVATIVE", "sequence": "YZX"},
    "spin": {"type": "SPIN"},
    "old": OLD | {"order": "LAST"},
    "old, scalar first": OLD | {"order": "FIRST"},
    "old, from B to A": OLD | {"order": "LAST", "direction": "B2A"},
    "old, body first, from B to A": OLD | {"order": "FIRST", "direction": "B2A", "a": "SC_BODY_1", "b": "EME2000"},
    "old Euler angles": OLD | {"type": "EULER_ANGLE", "sequence": "321"},
    "TAI": {"scale": "TAI"},
    "TT": {"scale": "TT"},
    "GPS": {"scale": "GPS"},
    "day of the year": {"day": True},
    "picoseconds": {"decimals": 12},
    "tenths of seconds": {"decimals": 1},
    "six digits": {"digits": 6},
    "exponents": {"exponent": True, "digits": 15},
    "lower case": {"lower": True, "orekit": "types in upper case", "ndm": "upper case alone"},
    "lines of DOS": {"end": "\r\n"},
    "comments and optional keys": {"comments": True, "extra": True},
    "blocks": ANGVEL | {"blocks": [17, 41]},
    "either sign": {"flip": 3},
    "star tracker": {"b": "STARTRACKER_2"},
    "GCRF": {"a": "GCRF"},
    "XML": XML,
    "XML with rates and units": XML | ANGVEL | {"units": True},
    "XML between single quotes": XML | {"quote": "'"},
    "XML of Euler angles": XML | {"type": "EULER_ANGLE", "sequence": "ZYX"},
    "XML in blocks": XML | {"blocks": [30]},
    "ecliptic": {"turned": "ECLIPJ2000", "a": "ECLIPJ2000", "orekit": "no such name there", "ndm": True},
}
AHEAD = {"UTC": 0.0, "TAI": 37.0, "TT": 69.184, "GPS": 18.0}


def date(style, time):
    decimals = style["decimals"]
    past = round((7 * 3600 + time + AHEAD[style["scale"]]) * 10**decimals)
    whole, part = divmod(past, 10**decimals)
    day = "2026-325" if style["day"] else "2026-11-21"
    return f"{day}T{whole // 3600:02}:{whole // 60 % 60:02}:{whole % 60:02}.{part:0{decimals}}"


def y_in_x(style, time, to_theirs):
    """The axes of Y in X, and the rate of Y against X in axes of Y; whether Y is the body."""
    attitude, rate = motion(time)
    attitude = to_theirs * attitude
    b_is_body = "EME2000" not in style["b"]
    if b_is_body == (style["direction"] != "B2A"):
        return attitude, rate
    return attitude.inv(), -attitude.apply(rate)


def numbers(style, time, index, to_theirs):
    attitude, rate = y_in_x(style, time, to_theirs)
    kind = style["type"]
    quaternion = attitude.as_quat() * (-1 if style["flip"] and index % style["flip"] == 1 else 1)
    if kind.startswith("QUATERNION"):
        found = list(quaternion)
        if kind.endswith("DERIVATIVE"):
            vector, w = quaternion[:3], quaternion[3]
            found += [*(0.5 * (w * rate + np.cross(vector, rate))), -0.5 * vector @ rate]
        elif style["order"] == "FIRST":
            found = [found[3], *found[:3]]
    elif kind.startswith("EULER"):
        letters = {"1": "X", "2": "Y", "3": "Z"}
        sequence = "".join(letters.get(axis, axis) for axis in style["sequence"])
        angles = attitude.as_euler(sequence)
        found = list(np.degrees(angles))
        if kind.endswith("DERIVATIVE"):
            # By differences: the attitude is a formula of time.
            at = [y_in_x(style, time + shift, to_theirs)[0].as_euler(sequence) for shift in (1e-4, -1e-4)]
            moved = (at[0] - at[1] + math.pi) % (2 * math.pi) - math.pi
            found += list(np.degrees(moved / 2e-4))
    else:
        first, second, third = attitude.as_euler("ZXZ")
        pole = [first - math.pi / 2, math.pi / 2 - second, third, rate[2]]
        found = list(np.degrees(pole))
    if kind.endswith("ANGVEL"):
        named = style["rate_frame"]
        in_a = named in ("REF_FRAME_A", style["a"])
        found += list(np.degrees(attitude.apply(rate) if in_a else rate))
    return found


def written(style, value):
    return f"{value:.{style['digits']}{'e' if style['exponent'] else 'f'}}"


def blocks(style):
    ends = [0, *style["blocks"], len(TIMES) - 1]
    return list(zip(ends, ends[1:]))


def metadata(style, first, last):
    keys = {"OBJECT_NAME": "DEMO", "OBJECT_ID": "2026-001A"}
    if style["extra"]:
        # Of a center that Orekit knows it wants the ephemeris.
        keys["CENTER_NAME"] = "NOWHERE"
    keys |= {"REF_FRAME_A": style["a"], "REF_FRAME_B": style["b"]}
    if style["direction"]:
        keys["ATTITUDE_DIR"] = style["direction"]
    keys |= {"TIME_SYSTEM": style["scale"], "START_TIME": date(style, TIMES[first])}
    if style["extra"]:
        keys |= {"USEABLE_START_TIME": date(style, TIMES[first]), "USEABLE_STOP_TIME": date(style, TIMES[last])}
    keys |= {"STOP_TIME": date(style, TIMES[last]), "ATTITUDE_TYPE": style["type"]}
    if style["order"]:
        keys["QUATERNION_TYPE"] = style["order"]
    if style["sequence"]:
        keys["EULER_ROT_SEQ"] = style["sequence"]
    if style["rate_frame"]:
        keys["ANGVEL_FRAME"] = style["rate_frame"]
    if style["extra"]:
        keys |= {"INTERPOLATION_METHOD": "LAGRANGE", "INTERPOLATION_DEGREE": "5"}
    return keys


def keywords(style, to_theirs):
    lines = [f"CCSDS_AEM_VERS = {style['version']}"]
    if style["comments"]:
        lines.append("COMMENT of the header")
    lines += ["CREATION_DATE = 2026-11-20T00:00:00", "ORIGINATOR = TEST"]
    for first, last in blocks(style):
        lines += ["", "META_START"]
        if style["comments"]:
            lines.append("COMMENT of the block")
        for key, value in metadata(style, first, last).items():
            lower = style["lower"] and not key.endswith("_TIME") and "REF" not in key and "OBJECT" not in key
            lines.append(f"{key} = {value.lower() if lower else value}")
        lines += ["META_STOP", "", "DATA_START"]
        if style["comments"]:
            lines.append("COMMENT of the data")
        for index in range(first, last + 1):
            row = numbers(style, TIMES[index], index, to_theirs)
            lines.append(" ".join([date(style, TIMES[index]), *(written(style, value) for value in row)]))
        lines.append("DATA_STOP")
    return style["end"].join(lines) + style["end"]


ELEMENTS = {
    "QUATERNION": ("quaternionEphemeris", [("quaternion", ["Q1", "Q2", "Q3", "QC"])]),
    "QUATERNION/ANGVEL": ("quaternionAngVel", [("quaternion", ["Q1", "Q2", "Q3", "QC"]),
                                               ("angVel", ["ANGVEL_X", "ANGVEL_Y", "ANGVEL_Z"])]),
    "EULER_ANGLE": ("eulerAngle", [(None, ["ANGLE_1", "ANGLE_2", "ANGLE_3"])]),
}


def xml(style, to_theirs):
    q = style["quote"]
    lines = [f"<?xml version={q}1.0{q} encoding={q}UTF-8{q}?>",
             f"<aem xmlns:xsi={q}http://www.w3.org/2001/XMLSchema-instance{q} id={q}CCSDS_AEM_VERS{q} "
             f"version={q}2.0{q}>",
             "<header><CREATION_DATE>2026-11-20T00:00:00</CREATION_DATE><ORIGINATOR>TEST</ORIGINATOR></header>",
             "<body>"]
    state, parts = ELEMENTS[style["type"]]
    for first, last in blocks(style):
        keys = "".join(f"<{key}>{value}</{key}>\n" for key, value in metadata(style, first, last).items())
        lines.append(f"<segment><metadata>\n{keys}</metadata><data>")
        for index in range(first, last + 1):
            row = iter(numbers(style, TIMES[index], index, to_theirs))
            text = f"<EPOCH>{date(style, TIMES[index])}</EPOCH>"
            for part, names in parts:
                unit = "deg/s" if names[0].startswith("ANGVEL") else "deg" if names[0].startswith("ANGLE") else None
                unit = f" units={q}{unit}{q}" if style["units"] and unit else ""
                inside = "".join(f"<{name}{unit}>{written(style, next(row))}</{name}>" for name in names)
                text += f"<{part}>{inside}</{part}>" if part else inside
            lines.append(f"<attitudeState><{state}>{text}</{state}></attitudeState>")
        lines.append("</data></segment>")
    return "\n".join([*lines, "</body>", "</aem>"]) + "\n"


# ---- readers


def slew(style, path, folder):
    run = subprocess.run([SLEW, "verify", str(path), "--spec", str(folder / "spec.toml"), "--format", "json"],
        capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    found = json.loads(run.stdout)
    assert found["rows"] == len(TIMES), found["rows"]
    rates = [check for check in found["checks"] if check["name"] == "rates against attitudes"]
    told = style["type"].count("/") > 0
    assert len(rates) == int(told), found["checks"]
    # Between rows a turn at one rate; or the cubic through the rates, or the polynomial that the file
    # declares.
    moments = random.Random(style["digits"])
    for moment in (0.0, 34.0, round(moments.uniform(2.0, 118.0), 3)):
        attitude, words = begins(SLEW, folder, path.name, moment)
        assert attitude is not None, words
        truth = motion(moment)[0] if told or style["extra"] else attitudes.one_rate(moment, TIMES)
        limit = BETWEEN if style["digits"] >= 9 else ATTITUDE
        assert apart(attitude, truth) < limit, f"{moment}: {apart(attitude, truth):.1e}"
    return "agrees"


def orekit(style, path, to_theirs):
    if style["orekit"] is not True:
        return style["orekit"]
    if orekit_or_none() is None:
        return "SKIPPED"
    from org.hipparchus.geometry.euclidean.threed import Vector3D
    from org.orekit.data import DataSource
    from org.orekit.files.ccsds.ndm import ParserBuilder
    from org.orekit.time import AbsoluteDate, TimeScalesFactory

    start = AbsoluteDate("2026-11-21T07:00:00", TimeScalesFactory.getUTC())
    message = ParserBuilder().buildAemParser().parseMessage(DataSource(str(path)))
    count, worst = 0, 0.0
    for (first, _), index in zip(blocks(style), range(message.getSegments().size())):
        segment = message.getSegments().get(index)
        rows = segment.getData().getAngularCoordinates()
        for k in range(rows.size()):
            row, time = rows.get(k), TIMES[first + k]
            assert abs(row.getDate().durationFrom(start) - time) < 10.0 ** -style["decimals"]
            # Orekit: whatever the file says, the rotation that leads from reference to body
            # components.
            attitude, rate = motion(time)
            attitude = to_theirs * attitude
            for axis in np.eye(3):
                found = row.getRotation().applyTo(Vector3D(*axis))
                found = np.array([found.getX(), found.getY(), found.getZ()])
                worst = max(worst, np.abs(found - attitude.inv().apply(axis)).max())
            if style["type"].endswith(("ANGVEL", "DERIVATIVE")):
                told = row.getRotationRate()
                # Those of ANGVEL_FRAME it leaves in the axes of that frame.
                named = {"REF_FRAME_A": style["a"], "REF_FRAME_B": style["b"]}.get(style["rate_frame"],
                    style["rate_frame"])
                if named == "EME2000":
                    rate = attitude.apply(rate)
                off = np.abs(np.array([told.getX(), told.getY(), told.getZ()]) - rate).max()
                assert off < RATE, f"rate {k}: {off}"
            count += 1
    assert worst < ATTITUDE, worst
    assert count >= len(TIMES), count
    return f"attitudes to {worst:.0e}"


def ndm(style, path, to_theirs):
    if style["ndm"] is not True:
        return style["ndm"]
    reader = os.environ.get("READ_NDM")
    if not reader:
        return "SKIPPED"
    run = subprocess.run([reader, str(path)], capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    segments = json.loads(run.stdout)["body"]["segment"]
    worst = None
    for segment, (first, last) in zip(segments, blocks(style), strict=True):
        meta = segment["metadata"]
        assert (meta["REF_FRAME_A"], meta["REF_FRAME_B"]) == (style["a"], style["b"])
        rows = segment["data"]["attitudeState"]
        assert len(rows) == last - first + 1
        for k, row in enumerate(rows, first):
            (state,) = row.values()
            attitude, _ = y_in_x(style, TIMES[k], to_theirs)
            if "quaternion" in state:
                xyzw = [state["quaternion"][key] for key in ("Q1", "Q2", "Q3", "QC")]
                worst = max(worst or 0.0, (Rotation.from_quat(xyzw).inv() * attitude).magnitude())
            elif "ANGLE_1" in state:
                angles = [state[f"ANGLE_{k}"] for k in (1, 2, 3)]
                angles = [angle["$value"] if isinstance(angle, dict) else angle for angle in angles]
                found = Rotation.from_euler(style["sequence"], angles, degrees=True)
                worst = max(worst or 0.0, (found.inv() * attitude).magnitude())
    if worst is None:
        return "every row"
    assert worst < ATTITUDE, worst
    return f"attitudes to {worst:.0e}"


def turn(name, folder):
    """From J2000 to another frame, by SPICE."""
    import spiceypy

    leap = folder / "leap.tls"
    leap.write_text(LEAPSECONDS)
    spiceypy.furnsh(str(leap))
    try:
        return Rotation.from_matrix(spiceypy.pxform("J2000", name, spiceypy.str2et("2026-11-21T07:00:00")))
    finally:
        spiceypy.kclear()


# ---- what is to be said of a file


def aem(**changes):
    return keywords(BASE | changes, Rotation.identity())


def apm_before(text):
    head, body = text.split("?>\n", 1)
    apm = ("<apm id=\"CCSDS_APM_VERS\" version=\"2.0\"><header/><body><segment><metadata><TIME_SYSTEM>"
           "UTC</TIME_SYSTEM></metadata>"
           "<data><EPOCH>2026-11-21T07:00:00</EPOCH></data></segment></body></apm>")
    return f"{head}?>\n<ndm>{apm}{body}</ndm>"


def interpolated(method, degree):
    return aem().replace("META_STOP", f"INTERPOLATION_METHOD = {method}\nINTERPOLATION_DEGREE = {degree}\nMETA_STOP")


def words(folder, wanted):
    """Ephemerides and what is none, with the exit code and the words that are due: 0 agrees, 3 refused."""
    cases = {
        "behind an APM": (apm_before(xml(BASE | XML, Rotation.identity())), 0, "attitudes agree"),
        "Lagrange": (interpolated("LAGRANGE", 5), 0, "attitudes agree"),
        "a degree above all": (interpolated("LAGRANGE", 40), 0, "25 is the highest supported degree"),
        "an unknown method": (interpolated("SPLINE", 3), 0, "SPLINE, which is not supported"),
        "Hermite without rates": (interpolated("HERMITE", 3), 0, "HERMITE needs rates"),
        "compressed": (b"\x1f\x8b\x08\x00packed", 3, "compressed by gzip"),
        "a kernel of others": (b"DAF/CK  " + bytes(80) + b"LTL-IEEE" + bytes(2000), 3, "ticks of a clock"),
    }
    for name, (text, code, word) in cases.items():
        if wanted and name not in wanted:
            continue
        path = folder / "file"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        run = subprocess.run([SLEW, "verify", str(path), "--spec", str(folder / "spec.toml")],
            capture_output=True, text=True)
        assert run.returncode == code or run.returncode in (3,
            8) and code == 3, f"{name}: {run.returncode} {run.stderr}"
        assert word in run.stderr, f"{name}: {run.stderr}"
    print(f"{len(cases)} files have their word", flush=True)


if __name__ == "__main__":
    wanted = sys.argv[2:]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "spec.toml").write_text(spec())
        for name, changes in STYLES.items():
            if wanted and name not in wanted:
                continue
            style = BASE | changes
            to_theirs = turn(style["turned"], folder) if style["turned"] else Rotation.identity()
            path = folder / ("file.xml" if style["xml"] else "file.aem")
            path.write_bytes((xml if style["xml"] else keywords)(style, to_theirs).encode())
            try:
                told = [slew(style, path, folder), orekit(style, path, to_theirs), ndm(style, path, to_theirs)]
            except Exception:
                print(f"{name}:\n{path.read_text()[:1500]}")
                raise
            print(f"{name:32} slew: {told[0]:8} Orekit: {told[1]:24} ccsds-ndm: {told[2]}", flush=True)
        print(f"{len(STYLES) if not wanted else len(wanted)} styles")
        words(folder, wanted)
        if not wanted:
            attitudes.corpus(SLEW, folder, random.Random(20261121))
    if not wanted:
        orbits.corpus(SLEW)

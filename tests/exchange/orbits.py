"""Messages with orbits in every legal style, each with the word that is due: read, with the
direction that other programs find; refused, with why; read with a warning. Run by corpus.py:

    python tests/exchange/corpus.py SLEW

Elements are followed by the C++ code of SGP4 (PyPI: sgp4), frames are Skyfield's; ephemerides are
interpolated by the package `oem`; `ccsds-ndm` must read the OMM of every style too, but for JSON
and for comments in `<ndm>`. All files are written here. A direction is that of the zenith.
"""

import json
import math
import subprocess
import tempfile
from datetime import datetime, timedelta, timezone
from pathlib import Path

import numpy as np

EPOCH = datetime(2026, 11, 21, 7, 0, 0, tzinfo=timezone.utc)
MU = 3.986004418e14
# Of a direction [rad]: of elements to what the series of the frames are worth, of tables to what
# Lagrange's and Hermite's polynomials of one degree differ by.
ELEMENTS_WITHIN, TABLE_WITHIN = 1e-6, 2e-6
# Near-Earth and deep, round and eccentric: mean motion, eccentricity, inclination, node, perigee,
# anomaly, B*.
ORBITS = [
    (14.9, 0.0012, 97.8, 200.1, 90.2, 270.1, 2e-5),
    (15.49, 0.0003, 51.64, 10.0, 350.5, 0.25, 1.1e-4),
    (13.2, 0.051, 63.4, 310.7, 12.5, 200.9, -3e-6),
    (2.00561, 0.7, 63.4, 150.0, 270.0, 20.0, 0.0),
    (1.00273, 0.0004, 0.05, 80.0, 33.0, 120.0, 0.0),
    (12.6, 0.0018, 0.9, 0.0, 0.0, 359.999, 5e-4),
    (10.8242, 0.1859667, 34.2682, 348.7242, 331.7664, 19.3264, 2.8098e-5),
    (16.2, 0.0005, 28.5, 120.0, 45.0, 45.0, 1e-3),
]


def spec(orbit, seconds=0.0, duration=30.0):
    moment = EPOCH + timedelta(seconds=seconds)
    return (f"format = 1\nepoch = \"{moment:%Y-%m-%dT%H:%M:%S.%f} UTC\"\n[orbit]\n{orbit}\n[body]\n"
            f"inertia_kg_m2 = [120, 100, 80]\n"
            "[start]\nattitude = { axis = [0, 0, 1], angle_deg = 0 }\n[end]\npoint = { boresight_body = "
            "[0, 0, 1], at = \"zenith\" }\n"
            f"[maneuver]\nduration_s = {duration}\n")


def told(slew, folder, text):
    """What `slew sky` says: the direction of the zenith or none, and its words."""
    path = folder / "spec.toml"
    path.write_text(text)
    run = subprocess.run([slew, "sky", str(path), "--format", "json"], capture_output=True, text=True)
    if run.returncode:
        assert run.returncode == 3, run.stderr
        return None, run.stderr
    ra, dec = (math.radians(part) for part in json.loads(run.stdout)["targets"][0]["ra_dec_deg"][0])
    return np.array([math.cos(dec) * math.cos(ra), math.cos(dec) * math.sin(ra), math.sin(dec)]), run.stderr


def apart(one, other):
    one, other = one / np.linalg.norm(one), other / np.linalg.norm(other)
    return math.atan2(np.linalg.norm(np.cross(one, other)), float(one @ other))


# ---- elements


def checked(line):
    return line + str(sum(1 if sign == "-" else int(sign) if sign.isdigit() else 0 for sign in line) % 10)


def power(value):
    """A number as two-line elements have it: ±ddddd±d behind a point that is not written."""
    if value == 0:
        return " 00000-0"
    exponent = math.floor(math.log10(abs(value))) + 1
    digits = round(abs(value) / 10.0**exponent * 1e5)
    if digits == 100000:
        digits, exponent = 10000, exponent + 1
    return f"{'-' if value < 0 else ' '}{digits:05}{exponent:+d}"


def two_lines(orbit, number="99991", day=324.5):
    n, e, i, node, perigee, anomaly, drag = orbit
    one = checked(f"1 {number:>5}U 20001A   26{day:012.8f}  .00000000  00000-0 {power(drag)} 0  999")
    angles = f"{i:8.4f} {node:8.4f} {round(e * 1e7):07} {perigee:8.4f} {anomaly:8.4f}"
    two = checked(f"2 {number:>5} {angles} {n:11.8f}    1")
    assert len(one) == len(two) == 69, (one, two)
    return one, two


def by_sgp4(lines, seconds):
    from sgp4.api import Satrec, jday
    from skyfield.api import load
    from skyfield.sgp4lib import TEME

    moment = EPOCH + timedelta(seconds=seconds)
    satellite = Satrec.twoline2rv(*lines)
    day, part = jday(moment.year, moment.month, moment.day, moment.hour, moment.minute,
        moment.second + moment.microsecond * 1e-6)
    error, position, _ = satellite.sgp4(day, part)
    assert error == 0, error
    at = load.timescale(builtin=True).from_datetime(moment)
    return TEME.rotation_at(at).T @ np.array(position)


def record(orbit, moment="2026-11-20T12:00:00.000000"):
    n, e, i, node, perigee, anomaly, drag = orbit
    return {
        "OBJECT_NAME": "SAMPLE", "OBJECT_ID": "2020-001A", "CENTER_NAME": "EARTH", "REF_FRAME": "TEME",
        "TIME_SYSTEM": "UTC",
        "MEAN_ELEMENT_THEORY": "SGP4", "EPOCH": moment, "MEAN_MOTION": n, "ECCENTRICITY": round(e, 7), "INCLINATION": i,
        "RA_OF_ASC_NODE": node, "ARG_OF_PERICENTER": perigee, "MEAN_ANOMALY": anomaly, "EPHEMERIS_TYPE": 0,
        "CLASSIFICATION_TYPE": "U", "NORAD_CAT_ID": 799500123, "ELEMENT_SET_NO": 999, "REV_AT_EPOCH": 1, "BSTAR": drag,
        "MEAN_MOTION_DOT": 0, "MEAN_MOTION_DDOT": 0,
    }


UNITS = {"MEAN_MOTION": "rev/day", "INCLINATION": "deg", "RA_OF_ASC_NODE": "deg", "ARG_OF_PERICENTER": "deg",
    "MEAN_ANOMALY": "deg",
         "BSTAR": "1/ER", "MEAN_MOTION_DOT": "rev/day**2", "MEAN_MOTION_DDOT": "rev/day**3"}
PARTS = {"metadata": ["OBJECT_NAME", "OBJECT_ID", "CENTER_NAME", "REF_FRAME", "TIME_SYSTEM", "MEAN_ELEMENT_THEORY"],
         "meanElements": ["EPOCH", "MEAN_MOTION", "ECCENTRICITY", "INCLINATION", "RA_OF_ASC_NODE",
             "ARG_OF_PERICENTER", "MEAN_ANOMALY"],
         "tleParameters": ["EPHEMERIS_TYPE", "CLASSIFICATION_TYPE", "NORAD_CAT_ID", "ELEMENT_SET_NO",
             "REV_AT_EPOCH", "BSTAR",
                           "MEAN_MOTION_DOT", "MEAN_MOTION_DDOT"]}


def keywords(keys, units=False, end="\n", comments=False):
    lines = ["CCSDS_OMM_VERS = 2.0", "CREATION_DATE = 2026-11-20T13:00:00", "ORIGINATOR = TEST"]
    for key, value in keys.items():
        if comments:
            lines.append(f"COMMENT {key}")
        lines.append(f"{key:20}= {value}" + (f" [{UNITS[key]}]" if units and key in UNITS else ""))
    return end.join(lines) + end


def xml(keys, units=False, wrapped=True, odd=False):
    def element(key):
        unit = f" units=\"{UNITS[key]}\"" if units and key in UNITS else ""
        value = f"<![CDATA[{keys[key]}]]>" if odd and key == "OBJECT_NAME" else keys[key]
        return f"<{key}{unit}>{value}</{key}>"
    meta, mean, tle = ("".join(map(element, names)) for names in PARTS.values())
    body = (f"<omm id=\"CCSDS_OMM_VERS\" version=\"2.0\"><header><CREATION_DATE>2026-11-20T13:00:00</CREATION_DATE>"
            f"<ORIGINATOR>TEST</ORIGINATOR></header><body><segment><metadata>{meta}</metadata><data>"
            f"<meanElements>{mean}</meanElements>"
            f"<tleParameters>{tle}</tleParameters></data></segment></body></omm>")
    comment = "<!-- a comment -->" if odd else ""
    return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n" + (f"<ndm>{comment}{body}</ndm>" if wrapped else body)


OMM_STYLES = {
    "keywords": ("omm", lambda keys: keywords(keys)),
    "keywords with units": ("omm", lambda keys: keywords(keys, units=True)),
    "keywords, lines of DOS and comments": ("omm", lambda keys: keywords(keys, end="\r\n", comments=True)),
    "day of the year": ("omm", lambda keys: keywords(keys | {"EPOCH": "2026-324T12:00:00.000"})),
    "user defined": ("omm", lambda keys: keywords(keys) + "USER_DEFINED_OPERATOR = SOMEBODY\n"),
    "XML": ("xml", lambda keys: xml(keys)),
    "XML alone with units": ("xml", lambda keys: xml(keys, units=True, wrapped=False)),
    "XML with CDATA and comments": ("xml", lambda keys: xml(keys, odd=True)),
    "JSON of numbers": ("json", lambda keys: json.dumps([keys])),
    "JSON of texts": ("json", lambda keys: json.dumps([{key: str(value) for key,
        value in keys.items()} | {"DECAY_DATE": None}])),
    "JSON of one object": ("json", lambda keys: json.dumps(keys, indent=1)),
}
REFUSED_OMM = {
    "another theory": (lambda keys: keywords(keys | {"MEAN_ELEMENT_THEORY": "DSST"}), "the theory DSST"),
    "SGP4-XP": (lambda keys: json.dumps(keys | {"EPHEMERIS_TYPE": 4}), "SGP4-XP"),
    "another frame": (lambda keys: keywords(keys | {"REF_FRAME": "EME2000"}), "the frame EME2000"),
    "another centre": (lambda keys: xml(keys | {"CENTER_NAME": "MARS"}), "not the Earth"),
    "two satellites": (lambda keys: json.dumps([keys, keys]), "2 sets of elements"),
    "radians": (lambda keys: keywords(keys, units=True).replace("[deg]", "[rad]"), "the unit rad"),
    "no drag": (lambda keys: keywords({key: value for key, value in keys.items() if key != "BSTAR"}), "no `BSTAR`"),
    "eccentricity 1": (lambda keys: keywords(keys | {"ECCENTRICITY": 1.0}), "from 0 to below 1"),
    "a text for a number": (lambda keys: json.dumps(keys | {"MEAN_MOTION": "fast"}), "`fast` is no number"),
    "twice": (lambda keys: keywords(keys) + "BSTAR = 0\n", "given twice"),
    "cut off": (lambda keys: xml(keys)[:-20], "cut off"),
    "two lines": (lambda keys: "\n".join(two_lines(ORBITS[0])), "these are two-line elements"),
    "old": (lambda keys: keywords(keys | {"EPOCH": "2020-01-01T00:00:00"}), "days old"),
}


def by_ndm(text, orbit):
    """The elements that the package ccsds-ndm finds are those that were written."""
    from ccsds_ndm.ndm_io import NdmIo

    found = NdmIo().from_string(text)
    found = (found.omm[0] if hasattr(found, "omm") else found).body.segment.data
    n, e, i, node, perigee, anomaly, drag = orbit
    mean, tle = found.mean_elements, found.tle_parameters
    angles = [angle.value for angle in (mean.inclination, mean.ra_of_asc_node, mean.arg_of_pericenter,
        mean.mean_anomaly)]
    assert [float(value) for value in (mean.mean_motion.value, mean.eccentricity, *angles, tle.bstar.value)] == [
        n, round(e, 7), i, node, perigee, anomaly, drag], found


def elements(slew, folder, random):
    for style in ("keywords", "keywords with units", "day of the year", "user defined", "XML", "XML alone with units"):
        for orbit in ORBITS:
            by_ndm(OMM_STYLES[style][1](record(orbit)), orbit)
    count = 0
    for index, orbit in enumerate(ORBITS):
        for style, (ending, write) in OMM_STYLES.items():
            seconds = random.uniform(-40_000, 80_000)
            lines = two_lines(orbit)
            (folder / f"file.{ending}").write_bytes(write(record(orbit)).encode())
            found, words = told(slew, folder, spec(f"omm = \"file.{ending}\"", round(seconds, 3)))
            assert found is not None, f"{style}: {words}"
            off = apart(found, by_sgp4(lines, round(seconds, 3)))
            assert off < ELEMENTS_WITHIN, f"{style}, orbit {index}: {off:.1e}"
            count += 1
        for number, name in (("99991", []), ("B1234", []), ("   12", ["0 SAMPLE"])):
            seconds = round(random.uniform(-40_000, 80_000), 3)
            lines = two_lines(orbit, number)
            # A blank for the type of ephemeris is a zero, and so are blanks for the second
            # derivative.
            shown = [checked(lines[0][:44] + " " * 8 + lines[0][52:62] + " " + lines[0][63:68]),
                lines[1]] if number == "B1234" else lines
            found, words = told(slew, folder, spec("tle = " + json.dumps([*name, *shown]), seconds))
            assert found is not None, words
            off = apart(found, by_sgp4(lines, seconds))
            assert off < ELEMENTS_WITHIN, f"lines of orbit {index}: {off:.1e}"
            count += 1
    for style, (write, word) in REFUSED_OMM.items():
        (folder / "file.omm").write_text(write(record(ORBITS[0])))
        found, words = told(slew, folder, spec("omm = \"file.omm\""))
        assert found is None and word in words, f"{style}: {words}"
        count += 1
    return count


def verification(slew, folder, random):
    """The satellites by which SGP4 is verified, from the package sgp4: at a moment of the span for
    which each is listed the direction of its code in C++, or a refusal where that has an error."""
    import sgp4
    from sgp4.api import Satrec

    rows = [row for row in (Path(sgp4.__file__).parent / "SGP4-VER.TLE").read_text().splitlines()
        if row[:2] in ("1 ", "2 ")]
    refused = 0
    for one, two in zip(rows[::2], rows[1::2], strict=True):
        # Behind the elements stand the minutes from their epoch: first, last and between.
        first, last, _ = (float(part) for part in two[69:].split())
        lines = checked(one[:68]), checked(two[:68])
        satellite = Satrec.twoline2rv(*lines)
        days = satellite.jdsatepoch - 2451544.5 + satellite.jdsatepochF
        epoch = datetime(2000, 1, 1, tzinfo=timezone.utc) + timedelta(days=days)
        minutes = random.uniform(max(first, -1440.0), min(last, 1440.0))
        seconds = round((epoch - EPOCH).total_seconds() + 60.0 * minutes, 3)
        found, words = told(slew, folder, spec(f"tle = {json.dumps(lines)}\noldest_days = 4000", seconds))
        try:
            truth = by_sgp4(lines, seconds)
        except AssertionError:
            assert found is None, f"{lines} {minutes} min"
            refused += 1
            continue
        assert found is not None, f"{lines} {minutes} min: {words}"
        # Two years after their epoch, where no elements are worth anything, the codes differ by more.
        limit = ELEMENTS_WITHIN if abs(minutes) < 50_000 else 10 * ELEMENTS_WITHIN
        assert apart(found, truth) < limit, f"{lines} {minutes} min: {apart(found, truth):.1e}"
    assert len(rows) == 66, len(rows)
    return len(rows) // 2, refused


# ---- ephemerides


def kepler(time, axis=7e6, inclination=0.9, eccentricity=0.01):
    """Position [m] and velocity [m/s] on an ellipse from its perigee."""
    n = math.sqrt(MU / axis**3)
    mean = n * time
    anomaly = mean
    for _ in range(30):
        anomaly -= (anomaly - eccentricity * math.sin(anomaly) - mean) / (1 - eccentricity * math.cos(anomaly))
    root = math.sqrt(1 - eccentricity**2)
    rate = n / (1 - eccentricity * math.cos(anomaly))
    flat = np.array([math.cos(anomaly) - eccentricity, root * math.sin(anomaly), 0.0]) * axis
    moved = np.array([-math.sin(anomaly), root * math.cos(anomaly), 0.0]) * axis * rate
    turn = np.array([[1, 0, 0], [0, math.cos(inclination), -math.sin(inclination)],
        [0, math.sin(inclination), math.cos(inclination)]])
    return turn @ flat, turn @ moved


def oem(step, count, how, from_=0.0, scale=1.0, row=None, keys="", end="\n", body="EARTH"):
    def date(time):
        return f"{EPOCH + timedelta(seconds=time):%Y-%m-%dT%H:%M:%S.%f}"
    times = [from_ + step * k for k in range(count)]
    lines = ["CCSDS_OEM_VERS = 2.0", "CREATION_DATE = 2026-11-20T00:00:00", "ORIGINATOR = TEST", "",
        "META_START", "OBJECT_NAME = A",
             "OBJECT_ID = 2026-001A", f"CENTER_NAME = {body}", "REF_FRAME = ICRF", "TIME_SYSTEM = UTC",
             f"START_TIME = {date(times[0])}",
             f"STOP_TIME = {date(times[-1])}"]
    if how:
        lines += [f"INTERPOLATION = {how[0]}", f"INTERPOLATION_DEGREE = {how[1]}"]
    lines += [*filter(None, keys.split("\n")), "META_STOP", ""]
    for index, time in enumerate(times):
        position, velocity = kepler(time)
        if row is not None and index == row:
            position = position + np.array([0.0, 50e3, 0.0])
        lines.append(date(time) + "".join(f" {part / 1e3 * scale:.9f}" for part in position)
                     + "".join(f" {part / 1e3 * scale:.12f}" for part in velocity))
    return end.join(lines) + end


def by_oem(path, seconds):
    from oem import OrbitEphemerisMessage

    from astropy.time import Time

    moment = EPOCH + timedelta(seconds=seconds)
    state = OrbitEphemerisMessage.open(path)(Time(moment.replace(tzinfo=None), scale="utc"))
    return np.array(state.position)


READ_OEM = {
    "Lagrange 5": (60.0, 30, ("LAGRANGE", 5)),
    "Lagrange 7": (120.0, 30, ("LAGRANGE", 7)),
    "Lagrange 9": (180.0, 30, ("LAGRANGE", 9)),
    "Hermite 3": (60.0, 30, ("HERMITE", 3)),
    "Hermite 7": (300.0, 12, ("HERMITE", 7)),
    "Hermite 7, quarter hours": (900.0, 9, ("HERMITE", 7)),
    "Hermite 7, four rows": (60.0, 4, ("HERMITE", 7)),
    "Hermite 11": (600.0, 12, ("HERMITE", 11)),
    "nothing": (60.0, 30, None),
    "nothing, five minutes": (300.0, 12, None),
}
REFUSED_OEM = {
    "rows an hour apart": (oem(3600.0, 24, None, -36_000.0), "do not carry this orbit"),
    "Lagrange, quarter hours": (oem(900.0, 24, ("LAGRANGE", 7), -450.0), "do not carry this orbit"),
    "metres": (oem(60.0, 30, None, -300.0, scale=1e3), "escapes from the Earth"),
    "two orbits": (oem(60.0, 30, None, -300.0) + "META_START" + oem(60.0, 30, None, -300.0,
        scale=1.01).split("META_START")[1],
                   "both cover the maneuver"),
    "Mars": (oem(60.0, 30, None, -300.0, body="MARS"), "not the Earth"),
    "straight lines": (oem(60.0, 30, ("LINEAR", 1), -300.0), "an interpolation of degree 1"),
    "too few": (oem(60.0, 4, ("LAGRANGE", 7), -60.0), "degree 7 needs 8"),
    "another day": (oem(60.0, 30, None, 86_400.0), "none of them all the way"),
}


def ephemerides(slew, folder, random):
    count, path = 0, folder / "file.oem"
    for style, (step, rows, how) in READ_OEM.items():
        for end in ("\n", "\r\n"):
            path.write_bytes(oem(step, rows, how, -step * (rows // 2 - 1), end=end).encode())
            for _ in range(3):
                seconds = round(random.uniform(0, 0.4 * step), 3)
                found, words = told(slew, folder, spec("oem = \"file.oem\"", seconds, min(30.0, 0.5 * step)))
                assert found is not None and "W0077" not in words, f"{style}: {words}"
                truth, _ = kepler(seconds)
                # A polynomial is no orbit: what degree and step leave, of the four rows about a
                # moment.
                limit = 2e-5 if step >= 600 else TABLE_WITHIN
                assert apart(found, truth) < limit, f"{style}: {apart(found, truth):.1e} of the orbit"
                if how and end == "\n":
                    off = apart(found, by_oem(str(path), seconds))
                    assert off < limit, f"{style}: {off:.1e} of the package oem"
                count += 1
    for style, (text, word) in REFUSED_OEM.items():
        path.write_text(text)
        found, words = told(slew, folder, spec("oem = \"file.oem\""))
        assert found is None and word in words, f"{style}: {words}"
        count += 1
    path.write_text(oem(60.0, 30, None, -300.0, row=5))
    found, words = told(slew, folder, spec("oem = \"file.oem\"", 30.0))
    assert found is not None and "W0077" in words and "this row contradicts its neighbours" in words, words
    return count + 1


def corpus(slew):
    import random

    cases = random.Random(20261121)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        print(f"{elements(slew, folder, cases)} messages and lines with elements have their word, "
              f"directions those of SGP4", flush=True)
        count, refused = verification(slew, folder, cases)
        print(f"{count} satellites of the verification of SGP4 are where its code has them, {refused} are "
              f"refused as by it", flush=True)
        print(f"{ephemerides(slew, folder, cases)} ephemerides have theirs, directions those of the orbit "
              f"and of oem", flush=True)

"""Messages with orbits in every legal style, each with the word that is due: read, with the
direction that other programs find; refused, with why; read with a warning. Run by corpus.py:

    python tests/exchange/corpus.py SLEW

Elements are followed by the C++ code of SGP4 (PyPI: sgp4), frames are Skyfield's; ephemerides are
interpolated by the package `oem`; `ccsds-ndm` must read the OMM of every style too, but for JSON
and for comments in `<ndm>`. All files are written here. A direction is that of the zenith.
"""

import functools
import json
import math
import re
import subprocess
import tempfile
from datetime import datetime, timedelta, timezone
from pathlib import Path

import numpy as np

EPOCH = datetime(2026, 11, 21, 7, 0, 0, tzinfo=timezone.utc)
MU = 3.986004418e14
# Of a direction [rad]: of elements to what the series of the frames are worth, of tables to what
# Lagrange's and Hermite's polynomials of one degree differ by.
ELEMENTS_WITHIN, TABLE_WITHIN = 5e-7, 2e-6
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


def satellite(keys):
    """The satellite of an OMM, by the reader of the package sgp4."""
    from sgp4.api import Satrec
    from sgp4.omm import initialize

    found = Satrec()
    # Its own numbers of satellites have six signs.
    initialize(found, {key: str(value) for key, value in keys.items()} | {"NORAD_CAT_ID": "99991"})
    return found


@functools.cache
def timescale():
    from skyfield.api import load

    return load.timescale(builtin=True)


def by_sgp4(found, seconds):
    """The position from the minutes since the epoch of the elements, leap seconds counted. The code
    has two modes, which differ where a node is below 0: the one of the cases of verification."""
    from sgp4.api import WGS72, Satrec
    from sgp4.conveniences import sat_epoch_datetime
    from skyfield.sgp4lib import TEME

    if isinstance(found, tuple):
        found = Satrec.twoline2rv(*found)
    one = Satrec()
    since_1950 = found.jdsatepoch - 2433281.5 + found.jdsatepochF
    one.sgp4init(WGS72, "a", found.satnum, since_1950, found.bstar, found.ndot, found.nddot, found.ecco, found.argpo,
        found.inclo, found.mo, found.no_kozai, found.nodeo)
    at, epoch = (timescale().from_datetime(moment) for moment in (EPOCH + timedelta(seconds=seconds),
        sat_epoch_datetime(found)))
    days = (at.whole - epoch.whole) + (at.tai_fraction - epoch.tai_fraction)
    error, position, _ = one.sgp4_tsince(1440.0 * days)
    assert error == 0, error
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


COVARIANCE = ["COV_REF_FRAME", *(f"C{row}_{column}" for index, row in enumerate(
    ("X", "Y", "Z", "X_DOT", "Y_DOT", "Z_DOT")) for column in ("X", "Y", "Z", "X_DOT", "Y_DOT", "Z_DOT")[:index + 1])]
SPACECRAFT = {"MASS": 300.0, "SOLAR_RAD_AREA": 1.0, "SOLAR_RAD_COEFF": 1.2, "DRAG_AREA": 2.0, "DRAG_COEFF": 2.2}
# What users add may have the names of the standard.
OF_USERS = {"BSTAR": "7", "EPOCH": "never", "TLE_LINE1": "1 25544U 98067A [no unit] = none"}
# What a record needs, without the blocks and keys that are optional.
SHORT = [*PARTS["metadata"], *PARTS["meanElements"], "BSTAR"]
RECORD = ["OBJECT_NAME", "OBJECT_ID", *PARTS["meanElements"], *PARTS["tleParameters"]]
SPACE_TRACK = {"CCSDS_OMM_VERS": "2.0", "COMMENT": "GENERATED VIA AN API", "CREATION_DATE": "2026-11-20T13:00:00",
               "ORIGINATOR": "TEST", "SEMIMAJOR_AXIS": "6945.1", "PERIOD": "96.6", "APOAPSIS": "580.1",
               "PERIAPSIS": "560.2", "OBJECT_TYPE": "PAYLOAD", "DECAY_DATE": None, "FILE": "1", "GP_ID": "2",
               "TLE_LINE0": "0 SAMPLE", "TLE_LINE1": "1 …", "TLE_LINE2": "2 …"}


def only(keys, names):
    return {key: keys[key] for key in names}


def shifted(keys, scale, seconds):
    moment = datetime.fromisoformat(keys["EPOCH"]) + timedelta(seconds=seconds)
    return keys | {"TIME_SYSTEM": scale, "EPOCH": f"{moment:%Y-%m-%dT%H:%M:%S.%f}"}


def exponents(keys):
    return {key: f"{value:.12E}" if isinstance(value, float) else value for key, value in keys.items()}


def full(keys):
    """Keywords of version 3 with all blocks."""
    more = SPACECRAFT | dict.fromkeys(COVARIANCE, "1.0E-03") | {"COV_REF_FRAME": "RTN"}
    more |= {f"USER_DEFINED_{key}": value for key, value in OF_USERS.items()}
    text = keywords(keys | more).replace("2.0\n", "3.0\nCOMMENT a = b\nCLASSIFICATION = none\n", 1)
    return text.replace("ORIGINATOR = TEST\n", "ORIGINATOR = TEST\nMESSAGE_ID = 2026-17\n")


def full_xml(keys):
    craft = "".join(f"<{key}>{value}</{key}>" for key, value in SPACECRAFT.items())
    covariance = "".join(f"<{key}>{'RTN' if key == 'COV_REF_FRAME' else 1e-3}</{key}>" for key in COVARIANCE)
    users = "".join(f"<USER_DEFINED parameter=\"{key}\">{value}</USER_DEFINED>" for key, value in OF_USERS.items())
    text = xml(keys, units=True).replace("<header>", "<header><COMMENT>of it</COMMENT>")
    text = text.replace("<meanElements>", "<meanElements><COMMENT>one</COMMENT><COMMENT>two</COMMENT>")
    text = text.replace("<tleParameters>", f"<spacecraftParameters>{craft}</spacecraftParameters><tleParameters>")
    return text.replace("</tleParameters>", f"</tleParameters><covarianceMatrix>{covariance}</covarianceMatrix>"
                        f"<userDefinedParameters>{users}</userDefinedParameters>")


def by_their_ndm(form):
    """Written by the package ccsds-ndm, from keywords that it reads."""
    def write(keys):
        from ccsds_ndm.ndm_io import NDMFileFormats, NdmIo

        return NdmIo().to_string(NdmIo().from_string(keywords(keys)), getattr(NDMFileFormats, form))
    return write


def by_their_sgp4(write):
    """With the elements that the package sgp4 exports."""
    def written(keys):
        from sgp4.exporter import export_omm

        found = export_omm(satellite(keys), keys["OBJECT_NAME"])
        return write(found | {key: keys[key] for key in PARTS["metadata"] if key not in found})
    return written


OMM_STYLES = {
    "keywords": ("omm", lambda keys: keywords(keys)),
    "keywords with units": ("omm", lambda keys: keywords(keys, units=True)),
    "keywords, lines of DOS and comments": ("omm", lambda keys: keywords(keys, end="\r\n", comments=True)),
    "keywords between tabs and blank lines": ("omm", lambda keys: keywords(keys, end="\n\n").replace("= ", "=\t")),
    "keywords without blanks": ("omm", lambda keys: keywords(keys).replace(" ", "")),
    "keywords with a mark of UTF-8": ("omm", lambda keys: "\ufeff" + keywords(keys | {"OBJECT_NAME": "É"})),
    "values in lower case": ("omm", lambda keys: keywords({key: value.lower() if key in PARTS["metadata"] else value
        for key, value in keys.items()})),
    "exponents": ("omm", lambda keys: keywords(exponents(keys))),
    "without optional blocks": ("omm", lambda keys: keywords(only(keys, SHORT))),
    "all blocks, version 3": ("omm", full),
    "day of the year": ("omm", lambda keys: keywords(keys | {"EPOCH": "2026-324T12:00:00.000"})),
    "nanoseconds and Z": ("omm", lambda keys: keywords(keys | {"EPOCH": keys["EPOCH"] + "000Z"})),
    "TAI": ("omm", lambda keys: keywords(shifted(keys, "TAI", 37.0))),
    "GPS": ("xml", lambda keys: xml(shifted(keys, "GPS", 18.0))),
    "user defined": ("omm", lambda keys: keywords(keys) + "USER_DEFINED_OPERATOR = SOMEBODY\n"),
    "keywords by ccsds-ndm": ("omm", by_their_ndm("KVN")),
    "keywords by sgp4": ("omm", by_their_sgp4(keywords)),
    "XML": ("xml", lambda keys: xml(keys)),
    "XML alone with units": ("xml", lambda keys: xml(keys, units=True, wrapped=False)),
    "XML with CDATA and comments": ("xml", lambda keys: xml(keys, odd=True)),
    "XML of all blocks": ("xml", full_xml),
    "XML of version 3": ("xml", lambda keys: xml(keys).replace("version=\"2.0\"", "version=\"3.0\"")),
    "XML with a prefix": ("xml", lambda keys: xml(keys).replace("<omm ", "<n:omm xmlns:n=\"urn:n\" ").replace(
        "</omm>", "</n:omm>")),
    "XML with a schema": ("xml", lambda keys: xml(keys).replace("<omm ", "<omm xmlns:xsi="
        "\"http://www.w3.org/2001/XMLSchema-instance\" xsi:noNamespaceSchemaLocation=\"ndmxml-3.0.0-master-3.0.xsd\" ")),
    "XML between single quotes": ("xml", lambda keys: xml(keys, units=True).replace("\"", "'")),
    "XML of lines": ("xml", lambda keys: xml(keys).replace("><", ">\r\n  <")),
    "XML behind another message": ("xml", lambda keys: xml(keys).replace("<ndm>",
        "<ndm><oem id=\"CCSDS_OEM_VERS\" version=\"2.0\"><header/></oem>")),
    "XML by ccsds-ndm": ("xml", by_their_ndm("XML")),
    "XML by sgp4": ("xml", by_their_sgp4(xml)),
    "JSON of numbers": ("json", lambda keys: json.dumps([keys])),
    "JSON of texts": ("json", lambda keys: json.dumps([{key: str(value) for key,
        value in keys.items()} | {"DECAY_DATE": None}])),
    "JSON of one object": ("json", lambda keys: json.dumps(keys, indent=1)),
    "JSON without what all have in common": ("json", lambda keys: json.dumps([only(keys, RECORD)])),
    "JSON with more keys": ("json", lambda keys: json.dumps([{key: str(value) for key,
        value in keys.items()} | SPACE_TRACK])),
    "JSON by parts": ("json", lambda keys: json.dumps({"omm": {"header": {}, "body": {part: only(keys, names)
        for part, names in PARTS.items()}}})),
    "JSON by sgp4": ("json", by_their_sgp4(lambda keys: json.dumps([keys]))),
}


def two(write, join):
    """Two satellites in one file."""
    return lambda keys: join(write(keys), write(keys | {"OBJECT_NAME": "OTHER", "NORAD_CAT_ID": 100002}))


def of_one_ndm(one, other):
    return one.replace("</ndm>", other.partition("<ndm>")[2])


REFUSED_OMM = {
    "another theory": (lambda keys: keywords(keys | {"MEAN_ELEMENT_THEORY": "DSST"}), "the theory DSST"),
    "SGP4-XP": (lambda keys: json.dumps(keys | {"EPHEMERIS_TYPE": 4}), "SGP4-XP"),
    "SGP4-XP in XML": (lambda keys: xml(keys | {"EPHEMERIS_TYPE": 4}), "SGP4-XP"),
    "another frame": (lambda keys: keywords(keys | {"REF_FRAME": "EME2000"}), "the frame EME2000"),
    "another centre": (lambda keys: xml(keys | {"CENTER_NAME": "MARS"}), "not the Earth"),
    "another time": (lambda keys: keywords(keys | {"TIME_SYSTEM": "UT1"}), "the time system UT1"),
    "another version": (lambda keys: keywords(keys).replace("2.0", "4.0", 1), "version 4.0"),
    "two by keywords": (two(keywords, lambda one, other: one + other), "2 sets of elements: SAMPLE, OTHER"),
    "two in XML": (two(xml, of_one_ndm), "2 sets of elements: SAMPLE, OTHER"),
    "two in JSON": (two(dict, lambda one, other: json.dumps([one, other])), "2 sets of elements: SAMPLE, OTHER"),
    "two without names": (lambda keys: json.dumps([only(keys, RECORD[2:])] * 2), "2 sets of elements: 799500123"),
    "two epochs": (lambda keys: keywords(keys) * 2, "2 sets of elements: SAMPLE, SAMPLE"),
    "two segments": (lambda keys: xml(keys).replace("</segment>", "</segment>" + xml(keys).split("<body>")[1].split(
        "</body>")[0]), "2 sets of elements"),
    "radians": (lambda keys: keywords(keys, units=True).replace("[deg]", "[rad]"), "the unit rad"),
    "radians in XML": (lambda keys: xml(keys, units=True).replace("\"deg\"", "\"rad\""), "the unit rad"),
    "no drag": (lambda keys: keywords({key: value for key, value in keys.items() if key != "BSTAR"}), "no `BSTAR`"),
    "the drag of a user": (lambda keys: full_xml(keys).replace(f"<BSTAR units=\"1/ER\">{keys['BSTAR']}</BSTAR>", ""),
                           "no `BSTAR`"),
    "a wrong key": (lambda keys: keywords(keys).replace("REV_AT", "REF_AT"), "unknown key `REF_AT_EPOCH`"),
    "a wrong key in XML": (lambda keys: xml(keys).replace("REV_AT", "REF_AT"), "unknown key `REF_AT_EPOCH`"),
    "a semi-major axis": (lambda keys: keywords(keys).replace("MEAN_MOTION ", "SEMI_MAJOR_AXIS "),
                          "takes a mean motion"),
    "eccentricity 1": (lambda keys: keywords(keys | {"ECCENTRICITY": 1.0}), "from 0 to below 1"),
    "a wide angle": (lambda keys: xml(keys | {"MEAN_ANOMALY": 361.0}), "from -360 to 360 deg"),
    "a text for a number": (lambda keys: json.dumps(keys | {"MEAN_MOTION": "fast"}), "`fast` is not a number"),
    "no number": (lambda keys: json.dumps(keys | {"MEAN_MOTION": math.nan}), "not valid JSON"),
    "twice": (lambda keys: keywords(keys) + "BSTAR = 0\n", "given twice"),
    "twice in XML": (lambda keys: xml(keys).replace("<BSTAR>", "<BSTAR>0</BSTAR><BSTAR>"), "given twice"),
    "twice in JSON": (lambda keys: json.dumps(keys).replace("}", ", \"BSTAR\": 0}"), "`BSTAR` is set twice"),
    "an empty list": (lambda keys: "[]", "the list has no elements"),
    "cut off": (lambda keys: xml(keys)[:-20], "cut off"),
    "a document type": (lambda keys: xml(keys).replace("?>\n", "?>\n<!DOCTYPE ndm>\n"), "document type declarations are not supported"),
    "a table": (lambda keys: ",".join(keys) + "\n", "this is a table"),
    "another message": (lambda keys: keywords(keys).replace("OMM", "OPM"), "the file is not an OMM"),
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
    theirs = [float(value) for value in (mean.mean_motion.value, mean.eccentricity, *angles, tle.bstar.value)]
    # The package sgp4 has angles in radians.
    assert np.allclose(theirs, [n, round(e, 7), i, node, perigee, anomaly, drag], rtol=1e-14, atol=0.0), found


# What ccsds-ndm does not read, beside JSON: marks of UTF-8, prefixes, comments in `<ndm>`, headers
# without a date.
NOT_BY_NDM = {"keywords with a mark of UTF-8", "XML with CDATA and comments", "XML with a prefix",
              "XML behind another message"}


def elements(slew, folder, random):
    count = 0
    for index, orbit in enumerate(ORBITS):
        for style, (ending, write) in OMM_STYLES.items():
            seconds = round(random.uniform(-40_000, 80_000), 3)
            text = write(record(orbit))
            if ending != "json" and style not in NOT_BY_NDM and index == 0:
                by_ndm(text, orbit)
            (folder / f"file.{ending}").write_bytes(text.encode())
            found, words = told(slew, folder, spec(f"omm = \"file.{ending}\"", seconds))
            assert found is not None, f"{style}: {words}"
            off = apart(found, by_sgp4(satellite(record(orbit)), seconds))
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
    """The satellites by which SGP4 is verified, from the package sgp4: at four moments of the span
    for which each is listed the direction of its code in C++, or a refusal where that has an error."""
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
        for minutes in (first, *(random.uniform(first, last) for _ in range(2)), last):
            seconds = round((epoch - EPOCH).total_seconds() + 60.0 * minutes, 3)
            found, words = told(slew, folder, spec(f"tle = {json.dumps(lines)}\noldest_days = 4000", seconds))
            try:
                truth = by_sgp4(lines, seconds)
            except AssertionError:
                assert found is None, f"{lines} {minutes} min"
                refused += 1
                continue
            assert found is not None, f"{lines} {minutes} min: {words}"
            assert apart(found, truth) < ELEMENTS_WITHIN, f"{lines} {minutes} min: {apart(found, truth):.1e}"
    assert len(rows) == 66, len(rows)
    return 2 * len(rows), refused


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


def of_xml(text, units=False, more="", wrapped=False):
    """The OEM in XML."""
    head, rows = text.split("META_START\n")[1].split("META_STOP\n")
    keys = "".join("<{0}>{1}</{0}>".format(*line.split(" = ")) for line in head.split("\n") if line)
    names = ["EPOCH", "X", "Y", "Z", "X_DOT", "Y_DOT", "Z_DOT", "X_DDOT", "Y_DDOT", "Z_DDOT"]
    known = ["", *["km"] * 3, *["km/s"] * 3, *["km/s**2"] * 3]
    states = ""
    for row in filter(None, rows.split("\n")):
        states += "<stateVector>"
        for name, unit, value in zip(names, known, row.split()):
            unit = f" units='{unit}'" if units and unit else ""
            states += f"<{name}{unit}>{value}</{name}>"
        states += "</stateVector>"
    found = (f"<oem id=\"CCSDS_OEM_VERS\" version=\"2.0\"><header><CREATION_DATE>2026-11-20T00:00:00</CREATION_DATE>"
             f"<ORIGINATOR>TEST</ORIGINATOR></header><body><segment><metadata>{keys}</metadata><data>"
             f"<COMMENT>rows</COMMENT>{states}{more}</data></segment></body></oem>")
    return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n" + (f"<ndm>{found}</ndm>" if wrapped else found)


def rewritten(text, row):
    """The OEM with each row changed."""
    head, rows = text.split("META_STOP\n")
    return head + "META_STOP\n" + "\n".join(row(line.split()) if line else line for line in rows.split("\n"))


def in_scale(text, scale, seconds):
    def moved(found):
        return f"{datetime.fromisoformat(found.group()) + timedelta(seconds=seconds):%Y-%m-%dT%H:%M:%S.%f}"
    return re.sub(r"2026-11-21T\d\d:\d\d:\d\d\.\d+", moved, text).replace("= UTC", f"= {scale}")


def by_their_oem(form, ending):
    """Written by the package oem."""
    def write(text):
        from oem import OrbitEphemerisMessage

        with tempfile.TemporaryDirectory() as name:
            path = Path(name) / "file.oem"
            path.write_text(text)
            theirs = path.with_suffix(ending)
            OrbitEphemerisMessage.open(str(path)).save_as(str(theirs), file_format=form)
            return theirs.read_text()
    return write


MATRIX = "COVARIANCE_START\nEPOCH = 2026-11-21T07:00:00\nCOV_REF_FRAME = RTN\n" + "\n".join(
    " ".join(["1.0E-03"] * (row + 1)) for row in range(6)) + "\nCOVARIANCE_STOP\n"
# Changes of an OEM that leave the orbit as it is.
OEM_STYLES = {
    "version 1": lambda text: text.replace("2.0", "1.0", 1),
    "version 3": lambda text: text.replace("2.0", "3.0", 1).replace("CREATION", "CLASSIFICATION = none\nCREATION",
        1).replace("TEST", "TEST\nMESSAGE_ID = 1", 1),
    "accelerations": lambda text: rewritten(text, lambda words: " ".join([*words, "0.001", "0", "0"])),
    "a covariance": lambda text: text + MATRIX,
    "comments": lambda text: text.replace("META_START", "COMMENT a = b\nMETA_START\nCOMMENT c = d").replace(
        "META_STOP\n", "META_STOP\nCOMMENT rows\n\n"),
    "a usable span": lambda text: text.replace("INTERPOLATION =", "USEABLE_START_TIME = 2026-11-21T06:59:00\n"
        "USEABLE_STOP_TIME = 2026-11-21T07:02:00\nINTERPOLATION ="),
    "day of the year": lambda text: text.replace("2026-11-21", "2026-325"),
    "Z": lambda text: rewritten(text, lambda words: " ".join([words[0] + "Z", *words[1:]])),
    "exponents and tabs": lambda text: rewritten(text, lambda words: "\t".join([words[0],
        *(f"{float(word):.14E}" for word in words[1:])])),
    "lower case": lambda text: text.replace("EARTH", "Earth").replace("HERMITE", "hermite").replace("= UTC", "= utc"),
    "TAI": lambda text: in_scale(text, "TAI", 37.0),
    "TT": lambda text: in_scale(text, "TT", 69.184),
    "GPS": lambda text: in_scale(text, "GPS", 18.0),
    "GCRF": lambda text: text.replace("= ICRF", "= GCRF"),
    "two segments": lambda text: text + oem(60.0, 30, None, 1440.0).split("TEST\n")[1],
    "XML": lambda text: of_xml(text),
    "XML with units and accelerations": lambda text: of_xml(rewritten(text, lambda words: " ".join([*words, "0", "0",
        "0"])), units=True),
    "XML with a covariance": lambda text: of_xml(text, more="<covarianceMatrix><EPOCH>2026-11-21T07:00:00</EPOCH>"
        + "".join(f"<{key}>{'RTN' if key == 'COV_REF_FRAME' else 1e-3}</{key}>" for key in COVARIANCE)
        + "</covarianceMatrix>"),
    "XML in <ndm>": lambda text: of_xml(text, wrapped=True),
    "keywords by oem": by_their_oem("kvn", ".txt"),
    "XML by oem": by_their_oem("xml", ".xml"),
}
# What the package oem does not read: version 3, GPS, `<ndm>`.
NOT_BY_OEM = {"version 3", "GPS", "XML in <ndm>"}
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
    "rows an hour apart": (oem(3600.0, 24, None, -36_000.0), "are not enough for this orbit"),
    "Lagrange, quarter hours": (oem(900.0, 24, ("LAGRANGE", 7), -450.0), "are not enough for this orbit"),
    "metres": (oem(60.0, 30, None, -300.0, scale=1e3), "escapes from the Earth"),
    "two orbits": (oem(60.0, 30, None, -300.0) + "META_START" + oem(60.0, 30, None, -300.0,
        scale=1.01).split("META_START")[1],
                   "both cover the maneuver"),
    "Mars": (oem(60.0, 30, None, -300.0, body="MARS"), "not the Earth"),
    "straight lines": (oem(60.0, 30, ("LINEAR", 1), -300.0), "the interpolation degree 1"),
    "too few": (oem(60.0, 4, ("LAGRANGE", 7), -60.0), "degree 7 needs 8"),
    "another day": (oem(60.0, 30, None, 86_400.0), "none of them all the way"),
    "two objects": (oem(60.0, 30, None, -300.0) + oem(60.0, 30, None, 1440.0).split("TEST\n")[1].replace("= A", "= B"),
                    "this segment is of B, the one above of A"),
    "two objects in <ndm>": (of_xml(oem(60.0, 30, None, -300.0), wrapped=True).replace("</ndm>", of_xml(oem(60.0, 30,
        None, -300.0)).split("?>")[1].replace(">A<", ">B<") + "</ndm>"), "this segment is of B, the one above of A"),
    "metres in XML": (of_xml(oem(60.0, 30, None, -300.0), units=True).replace("'km'", "'m'"), "the unit m of <X>"),
    "another time": (oem(60.0, 30, None, -300.0).replace("= UTC", "= UT1"), "the time system UT1"),
    "another frame": (oem(60.0, 30, None, -300.0).replace("= ICRF", "= MOD"), "the frame MOD"),
    "positions alone": (rewritten(oem(60.0, 30, None, -300.0), lambda words: " ".join(words[:4])), "a row has 4 words"),
    "another message": (keywords(record(ORBITS[0])), "the file is not an OEM"),
    "compressed": (b"\x1f\x8b\x08\x00packed", "compressed by gzip"),
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
    for style, change in OEM_STYLES.items():
        text = change(oem(60.0, 12, ("HERMITE", 7), -300.0))
        path = folder / ("file.xml" if text.startswith("<?xml") else "file.oem")
        path.write_text(text)
        seconds = round(random.uniform(0, 60.0), 3)
        found, words = told(slew, folder, spec(f"oem = \"{path.name}\"", seconds))
        assert found is not None and "W0077" not in words, f"{style}: {words}"
        truths = [kepler(seconds)[0], *([] if style in NOT_BY_OEM else [by_oem(str(path), seconds)])]
        for truth in truths:
            assert apart(found, truth) < TABLE_WITHIN, f"{style}: {apart(found, truth):.1e}"
        count += 1
    path = folder / "file.oem"
    for style, (text, word) in REFUSED_OEM.items():
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
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
        print(f"the satellites of the verification of SGP4 are at {count - refused} moments where its code has "
              f"them, and refused as by it at {refused}", flush=True)
        print(f"{ephemerides(slew, folder, cases)} ephemerides have theirs, directions those of the orbit "
              f"and of oem", flush=True)

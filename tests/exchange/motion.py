"""The motion of the corpus: a turn about two axes one after the other, `R(s) = R0 A(s) B(s)`, with
`3s² − 2s³` of each angle, so that attitudes and rates are formulas; and what `slew` says of files
with it."""

import json
import subprocess

import numpy as np
from scipy.spatial.transform import Rotation

DURATION, STEP = 120.0, 2.0
TIMES = np.arange(0.0, DURATION + STEP / 2, STEP)
START = Rotation.from_euler("ZYX", [20.5, -31.2, 63.7], degrees=True)
AXES = [np.array([0.6, 0.0, 0.8]), np.array([0.48, 0.6, -0.64])]
ANGLES = np.radians([70.0, 50.0])


def motion(time):
    """Attitude, body to reference, and rate in body axes."""
    s = time / DURATION
    part, slope = s * s * (3 - 2 * s), 6 * s * (1 - s) / DURATION
    first, second = (Rotation.from_rotvec(axis * angle * part) for axis, angle in zip(AXES, ANGLES, strict=True))
    rate = AXES[1] * ANGLES[1] * slope + second.inv().apply(AXES[0] * ANGLES[0] * slope)
    return START * first * second, rate


def spec(start=None, seconds=0.0, names="reference_frame = \"EME2000\""):
    """The spec of the motion; or of one that begins with the attitude of a file so many seconds
    later."""
    ends = []
    for name, time in (("start", 0.0), ("end", DURATION)):
        w, x, y, z = (float(part) for part in np.roll(motion(time)[0].as_quat(), 1))
        ends.append(f"[{name}]\nattitude = {{ quaternion_wxyz = [{w!r}, {x!r}, {y!r}, {z!r}] }}")
    if start:
        ends[0] = f"[start]\nattitude = {{ file = \"{start}\" }}"
    minutes, seconds = divmod(seconds, 60.0)
    return (f"format = 1\nepoch = \"2026-11-21T07:{int(minutes):02}:{seconds:09.6f} UTC\"\n[names]\nobject = \"DEMO\"\n"
            f"{names}\n[body]\ninertia_kg_m2 = [120, 100, 80]\n{ends[0]}\n{ends[1]}\n"
            f"[maneuver]\nduration_s = {DURATION}\nsteps = {10 if start else 100}\n")


def begins(slew, folder, file, seconds=0.0, **more):
    """The attitude with which a plan begins, or none, and the words."""
    (folder / "start.toml").write_text(spec(file, seconds, **more))
    run = subprocess.run([slew, "plan", "start.toml", "--force", "-o", "start.json"], cwd=folder,
                         capture_output=True, text=True)
    if run.returncode:
        assert run.returncode == 3, run.stderr
        return None, run.stderr
    wxyz = json.loads((folder / "start.json").read_text())["trajectory"]["quaternion_wxyz"][0]
    return Rotation.from_quat(wxyz, scalar_first=True), run.stderr


def apart(one, other):
    return (one.inv() * other).magnitude()

"""Slew times for schedulers: the functions that they call, on a table.

`slew table spacecraft.toml -o slew.npz --settling 15` first, then `python scheduler_slews.py slew.npz`.
Without a table a coarse one is made, of the spacecraft of `problems/shortest_rate.toml`.
"""

import pathlib
import subprocess
import sys
import tempfile

import numpy as np

import slewkit


def attitude(center, roll):
    """Quaternions [w, x, y, z]: body z on the directions, body x turned by `roll` from north to east.

    `center` has `ra.rad` and `dec.rad`, as a SkyCoord has, or is a pair of arrays in radians.
    """
    right, up = (center.ra.rad, center.dec.rad) if hasattr(center, "ra") else center
    right, up, roll = np.broadcast_arrays(right, up, roll)
    # Rz(ra) Ry(90° − dec) points z there, with x to the south.
    half, tilt, turn = right / 2, (np.pi / 2 - up) / 2, (np.pi - roll) / 2
    sum_, difference = half + turn, half - turn
    w, z = np.cos(tilt) * np.cos(sum_), np.cos(tilt) * np.sin(sum_)
    x, y = -np.sin(tilt) * np.sin(difference), np.sin(tilt) * np.cos(difference)
    return np.stack([w, x, y, z], axis=-1)


class TableSlew:
    """A slew model with the signature of m4opt: two centers, two rolls, settling inside."""

    def __init__(self, path):
        self.table = slewkit.SlewTable(path)

    def time(self, center1, center2, roll1=0.0, roll2=0.0):
        """Returns the seconds from one pointing to another, angles in radians."""
        first, second = attitude(center1, roll1), attitude(center2, roll2)
        seconds = self.table(first, second, scalar_first=True)
        return np.where(seconds > 0, seconds + self.table.settling_s, 0.0)


def slew_time(x, v, a):
    """The usual law, as dorado-scheduling has it: a turn x, a rate v, an acceleration a."""
    x = np.asarray(x, dtype=float)
    return np.where(x <= v**2 / a, 2 * np.sqrt(x / a), (x + v**2 / a) / v)


def fit(table, count=1000, seed=1):
    """Returns the rate and the acceleration of the law that fits a table best, and its errors."""
    rng = np.random.default_rng(seed)
    quaternions = rng.normal(size=(count, 4))
    quaternions /= np.linalg.norm(quaternions, axis=1)[:, None]
    angles = 2 * np.arccos(np.abs(quaternions[:, 3]).clip(0, 1))
    seconds = table([0, 0, 0, 1], quaternions)
    least = (np.inf, 0.0, 0.0)
    # T = x/v + v/a is linear in 1/v and v/a; a root law has no rate: it is the end of the range.
    slowest = angles.max() / seconds.max()
    for rate in np.geomspace(slowest / 2, 50 * slowest, 80):
        low, high = 1e-3 * rate**2 / angles.max(), 1e6 * rate**2 / angles.max()
        for acceleration in np.geomspace(low, high, 80):
            error = np.abs(slew_time(angles, rate, acceleration) / seconds - 1).mean()
            least = min(least, (error, rate, acceleration))
    _, rate, acceleration = least
    return rate, acceleration, slew_time(angles, rate, acceleration) / seconds - 1


def coarse_table():
    """Returns a model from a table of few turns, which takes seconds to make."""
    program = pathlib.Path(sys.executable).parent / "slew"
    spec = pathlib.Path(__file__).parents[2] / "problems/shortest_rate.toml"
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "slew.npz"
        sizes = ["--divisions", "2", "--checks", "5", "--settling", "15", "--set", "maneuver.steps=40"]
        subprocess.run([program, "table", spec, "-o", path, *sizes], check=True)
        return TableSlew(path)


if __name__ == "__main__":
    model = TableSlew(sys.argv[1]) if len(sys.argv) > 1 else coarse_table()
    crab, vela = (np.radians([83.633]), np.radians([22.014])), (np.radians([128.836]), np.radians([-45.176]))
    there, back = model.time(crab, vela)[0], model.time(vela, crab)[0]
    print(f"Crab to Vela: {there:.1f} s with settling, rolled by 30° {model.time(crab, vela, 0.0, np.pi / 6)[0]:.1f} s")
    assert abs(there - back) < 1e-9 and model.time(crab, crab)[0] == 0
    rate, acceleration, errors = fit(model.table)
    print(f"law: {np.degrees(rate):.3f} °/s and {np.degrees(acceleration):.4f} °/s²", end=", ")
    print(f"wrong by {errors.min():+.0%} to {errors.max():+.0%} on random turns")

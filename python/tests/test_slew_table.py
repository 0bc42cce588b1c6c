"""Slew-time tables: look-up against fresh plans, shapes, orders of quaternions, errors."""

import importlib.util

import numpy as np
import pytest

import slewkit

ROOT_TURN = [0, 0, 0, 1]


@pytest.fixture(scope="module")
def spec_text() -> str:
    return """\
format = 1
[body]
inertia_kg_m2 = [[2.0, 0.1, 0.0], [0.1, 1.6, 0.05], [0.0, 0.05, 1.1]]
[actuators]
torque_limit_n_m = 0.5
[start]
attitude = { axis = [0, 0, 1], angle_deg = 0 }
[end]
attitude = { axis = [1, 0, 0], angle_deg = 90 }
[maneuver]
minimize = "time"
"""


@pytest.fixture(scope="module")
def path(slew, spec_text, tmp_path_factory):
    folder = tmp_path_factory.mktemp("table")
    (folder / "spec.toml").write_text(spec_text)
    written = folder / "slew.npz"
    slew("table", folder / "spec.toml", "-o", written, "--divisions", "2", "--checks", "4", "--settling", "15")
    return written


def test_a_table_is_read_and_looked_up(path, spec_text):
    table = slewkit.SlewTable(path)
    assert table.quantity == "time" and table.settling_s == 15 and table.errors["turns"] == 4
    assert "plans" in repr(table)
    rng = np.random.default_rng(3)
    q = rng.normal(size=(6, 4))
    matrix = table.matrix(q)
    assert matrix.shape == (6, 6) and np.all(np.diag(matrix) < 1e-6)
    assert np.allclose(matrix, matrix.T, rtol=1e-9)
    assert np.allclose(table(q[0], q), matrix[0]) and table(q[0], q[1]) == pytest.approx(matrix[0, 1])
    wxyz = q[:, [3, 0, 1, 2]]
    assert np.array_equal(table(wxyz[:1], wxyz, scalar_first=True), table(q[:1], q))
    assert np.all(table.bound(q[:1], q[1:]) < matrix[0, 1:])
    assert np.all(table.fixed_axis(q[:1], q[1:]) > matrix[0, 1:] * 0.95)
    assert np.isnan(table(ROOT_TURN, [0, 0, 0, np.nan]))


def test_the_arrays_are_those_of_numpy(path):
    arrays = np.load(path)
    directions, angles = arrays["directions"], arrays["angles_rad"]
    assert arrays["values"].shape == (len(angles), len(directions))
    table = slewkit.SlewTable(path)
    half = np.outer(np.sin(angles / 2), directions[3])
    nodes = np.column_stack([half, np.cos(angles / 2)])
    assert np.allclose(table(ROOT_TURN, nodes), arrays["values"][:, 3], rtol=1e-9)
    assert np.all(arrays["bounds"] <= arrays["values"])
    assert np.all(arrays["fixed_axis"] >= arrays["values"] * (1 - 1e-6))


def test_what_is_no_table_is_an_error(path, tmp_path):
    (tmp_path / "no.npz").write_bytes(path.read_bytes()[:-100])
    np.savez(tmp_path / "other.npz", version=np.array([1.0]))
    for name in ("no.npz", "other.npz", "missing.npz"):
        with pytest.raises(slewkit.FileError):
            slewkit.SlewTable(tmp_path / name)
    table = slewkit.SlewTable(path)
    with pytest.raises(ValueError):
        table([0, 0, 1], ROOT_TURN)
    with pytest.raises(ValueError):
        table.matrix(ROOT_TURN)


def test_schedulers_call_the_example(path):
    source = __file__.replace("tests/test_slew_table.py", "examples/scheduler_slews.py")
    loaded = importlib.util.spec_from_file_location("scheduler_slews", source)
    example = importlib.util.module_from_spec(loaded)
    loaded.loader.exec_module(example)
    model = example.TableSlew(path)
    centers = np.radians([[10.0, 200.0, 80.0], [-30.0, 60.0, 89.0]])
    seconds = model.time(centers[:, :1], centers)
    assert seconds.shape == (3,) and seconds[0] == 0 and np.all(seconds[1:] > 15)
    rate, acceleration, errors = example.fit(model.table)
    assert rate > 0 and acceleration > 0 and np.abs(errors).mean() < 0.15
    assert example.slew_time(4.0, 1e9, 1.0) == pytest.approx(4.0)
    assert example.slew_time(4.0, 1.0, 1.0) == pytest.approx(5.0)

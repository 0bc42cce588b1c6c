"""The program ``slew`` of the wheel: what the binary of cargo prints, writes and returns."""

import json
import pathlib
import signal
import subprocess
import sys
import time

import pytest

PROGRAM = pathlib.Path(sys.executable).parent / "slew"


def run(*arguments, **options):
    return subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True, **options)


def test_it_plans_the_readmes_maneuver_as_the_binary_does(problems, slew):
    def told(done):
        document = json.loads(done.stdout)
        return {key: value for key, value in document.items() if not key.endswith("time_s")}

    spec = problems / "xte_20s.toml"
    ours, theirs = run("plan", spec, "-q", "-o", "-"), slew("plan", spec, "-q", "-o", "-")
    assert ours.returncode == 0 and told(ours) == told(theirs)
    assert told(ours)["status"] == "solved"


def test_its_exit_codes_are_those_of_the_binary(tmp_path, slew):
    (tmp_path / "bad.toml").write_text("format = 1\n")
    for code, arguments in [(2, ["fly"]), (3, ["plan", tmp_path / "bad.toml"]), (0, ["--version"])]:
        ours, theirs = run(*arguments), slew(*arguments, code=code)
        assert (ours.returncode, ours.stdout, ours.stderr) == (code, theirs.stdout, theirs.stderr)


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_ctrl_c_keeps_the_best_result_and_ends_what_does_not_listen(problems, tmp_path):
    kept = tmp_path / "plan.json"
    steps = ["--set", "maneuver.steps=100000"]
    work = subprocess.Popen([PROGRAM, "plan", problems / "keep_out_medium.toml", "-q", *steps, "-o", kept])
    time.sleep(2)
    work.send_signal(signal.SIGINT)
    assert work.wait(60) == 130 and json.loads(kept.read_text())["status"] == "interrupted"
    # Reading a spec from a terminal that types nothing.
    waits = subprocess.Popen([PROGRAM, "check", "-"], stdin=subprocess.PIPE)
    time.sleep(1)
    waits.send_signal(signal.SIGINT)
    assert waits.wait(10) in (130, -signal.SIGINT)

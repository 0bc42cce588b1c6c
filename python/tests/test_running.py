"""Progress, stopping, threads, processes, memory."""

import pathlib
import signal
import subprocess
import sys
import textwrap
import threading
import time

import pytest

import slewkit

#: Seconds of work: a search of many starts.
LONG = {"solver.search": "thorough", "maneuver.steps": 100_000, "start.angular_velocity_rad_s": [0.3, -0.2, 0.25]}


def test_progress_is_told(spec):
    told = []
    slewkit.plan(spec, progress=told.append)
    assert told[0].stage == "newton" and told[0].start and 0 <= told[0].elapsed < 60


def test_a_function_stops_a_solve_and_the_best_iterate_is_kept(spec):
    told = []

    def stop_at_the_third(progress):
        told.append(progress)
        return len(told) < 3

    began = time.perf_counter()
    with pytest.raises(slewkit.Interrupted) as caught:
        slewkit.plan(spec, overrides=LONG, progress=stop_at_the_third)
    assert time.perf_counter() - began < 5 and len(told) == 3
    assert caught.value.exit_code == 130 and caught.value.plan.status == "interrupted"
    # A function that says nothing goes on.
    assert slewkit.plan(spec, progress=lambda progress: None).status == "solved"


def test_what_the_function_raises_is_raised(spec):
    def fails(progress):
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough") as caught:
        slewkit.plan(spec, overrides=LONG, progress=fails)
    assert caught.value.plan.status == "interrupted"
    with pytest.raises(RuntimeError, match="enough"):
        slewkit.compare(spec, progress=fails)


@pytest.mark.skipif(sys.platform == "win32", reason="signals of Unix")
@pytest.mark.parametrize("work", ["slewkit.plan(spec, overrides=long)", "slewkit.compare(spec, overrides=long)"])
def test_ctrl_c_ends_the_work_at_once(work, tmp_path):
    program = f"""
        import signal, slewkit, sys, time
        # What a shell starts in the background ignores Ctrl-C, and so would what this test starts.
        signal.signal(signal.SIGINT, signal.default_int_handler)
        spec = {{
            "format": 1,
            "body": {{"inertia_kg_m2": [120, 100, 80]}},
            "start": {{"attitude": {{"axis": [0, 0, 1], "angle_deg": 0}}}},
            "end": {{"attitude": {{"euler_zyx_deg": [30, -40, 70]}}}},
            "maneuver": {{"duration_s": 60}},
        }}
        long = {LONG!r}
        print("begins", flush=True)
        try:
            {work}
            print("was not long", flush=True)
        except KeyboardInterrupt as error:
            print("interrupted", getattr(getattr(error, "plan", None), "status", ""), flush=True)
    """
    script = tmp_path / "script.py"
    script.write_text(textwrap.dedent(program))
    with subprocess.Popen([sys.executable, script], stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout.readline() == "begins\n"
            time.sleep(0.7)
            process.send_signal(signal.SIGINT)
            sent = time.perf_counter()
            said, _ = process.communicate(timeout=30)
            waited = time.perf_counter() - sent
        finally:
            process.kill()
    assert process.returncode == 0
    assert said.startswith("interrupted"), said
    assert not work.startswith("slewkit.plan") or "interrupted interrupted" in said, said
    # A fraction of a second; generous for a machine under load.
    assert waited < 5


def test_other_threads_run_meanwhile(spec):
    counted, done = 0, threading.Event()

    def plan():
        with pytest.raises(slewkit.LimitReached):
            slewkit.plan(spec, overrides={**LONG, "solver.time_limit_s": 0.5})
        done.set()

    thread = threading.Thread(target=plan)
    thread.start()
    while not done.is_set():
        counted += 1
        time.sleep(0.001)
    thread.join()
    # While the lock was held nothing would count.
    assert counted > 20


def test_threads_plan_the_same(spec):
    alone = slewkit.plan(spec).torque
    found = [None] * 8

    def plan(index):
        found[index] = slewkit.plan(spec).torque

    threads = [threading.Thread(target=plan, args=(index,)) for index in range(len(found))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all((torque == alone).all() for torque in found)


@pytest.mark.skipif(not pathlib.Path("/proc/self/statm").exists(), reason="memory is read as Linux tells it")
def test_no_memory_is_lost_over_many_plans(spec, request):
    spec["maneuver"]["steps"] = 10
    problem = slewkit.Problem(spec)
    bad = {"maneuver.duration_s": -1}

    def resident():
        return int(pathlib.Path("/proc/self/statm").read_text().split()[1]) * 4096 / 2**20

    def rounds(count):
        for index in range(count):
            plan = slewkit.plan(problem, progress=lambda progress: None)
            assert plan.torque.shape == (11, 3) and plan.verification and plan.quaternions().shape == (11, 4)
            if index % 10 == 0:
                plan.to_dict(), plan.rotation(), slewkit.plan(spec)
                with pytest.raises(slewkit.SpecError):
                    slewkit.plan(spec, overrides=bad)

    total = request.config.getoption("--plans")
    rounds(total // 10)
    before = resident()
    rounds(total - total // 10)
    # A kilobyte a plan would be seen, and twenty bytes with `--plans 100000`.
    assert resident() - before < 1, f"{before} MiB, then {resident()} MiB"

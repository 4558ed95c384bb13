"""Runs: the same folders as of the command, frames, resuming, Ctrl-C, other threads."""

import os
import signal
import subprocess
import sys
import threading
import time

import numpy
import pytest

import meniscus as mn
from conftest import content


def test_a_run_is_that_of_the_command(scene_file, tmp_path):
    mine, other = tmp_path / "mine", tmp_path / "other"
    with mn.Scene(scene_file).start(mine, threads=1) as sim:
        numbers = [frame.number for frame in sim.frames(until="1.5 ms")]
    assert numbers == [0, 1, 2, 3] and sim.is_closed and sim.time == 0.0015
    command = [sys.executable, "-m", "meniscus", "run", str(scene_file), "--out", str(other)]
    subprocess.run(command + ["--until", "1.5 ms", "--quiet"], check=True)
    assert content(mine) == content(other)
    assert sorted(os.listdir(mine)) == sorted(os.listdir(other))
    assert (mine / "scene.toml").read_text() == (other / "scene.toml").read_text()
    assert sim.summary.keys() == mn.open(other).summary.keys()


def test_a_run_that_is_left_goes_on_with_the_same_bits(scene_file, tmp_path):
    scene = mn.Scene(scene_file)
    whole = mn.run(scene, tmp_path / "whole")
    with scene.start(tmp_path / "cut") as sim:
        for frame in sim.frames():
            if frame.number == 2:
                break
    assert sim.summary["exit_reason"] == "stopped: by the calling program"
    with pytest.raises(mn.OutputError, match="already holds a run"):
        scene.start(tmp_path / "cut")
    with scene.start(tmp_path / "cut", resume=True) as sim:
        assert [frame.number for frame in sim.frames()] == [2, 3, 4]
    assert content(tmp_path / "cut") == content(tmp_path / "whole")
    assert whole.summary["expect"][0]["pass"] and sim.summary["expect"] == whole.summary["expect"]
    before = (tmp_path / "cut" / "summary.json").read_bytes()
    with scene.start(tmp_path / "cut", resume=True) as sim:
        assert [frame.number for frame in sim.frames()] == [4]
        assert sim.frame.number == 4 and sim.summary["exit_reason"] == "finished"
    assert (tmp_path / "cut" / "summary.json").read_bytes() == before
    with scene.start(tmp_path / "cut", resume=True) as sim:
        assert [frame.number for frame in sim.frames(until="3 ms")] == [4, 5, 6]
    assert sim.summary["simulated_seconds"] == 0.003


def test_an_exception_leaves_a_run_that_can_be_resumed(scene_file, tmp_path):
    scene = mn.Scene(scene_file)
    mn.run(scene, tmp_path / "whole")
    with pytest.raises(ZeroDivisionError):
        with scene.start(tmp_path / "cut") as sim:
            for frame in sim.frames():
                1 / (3 - frame.number)
    assert sim.is_closed
    mn.run(scene, tmp_path / "cut", resume=True)
    assert content(tmp_path / "cut") == content(tmp_path / "whole")


def test_frames_have_arrays(scene_file, tmp_path):
    with mn.Scene(scene_file).start(tmp_path / "out") as sim:
        sim.run_to_end()
        frame = sim.frame
        series = sim.series
    assert frame.time == 0.002 and frame.number == 4 and frame.step == len(series["step"]) - 1
    assert frame.phi.shape == frame.pressure.shape == (24, 18) and frame.velocity.shape == (24, 18, 3)
    assert frame.phi is frame.phi and not frame.phi.flags.writeable and frame.phi.dtype == numpy.float64
    x, y = frame.axes
    assert (len(x), len(y)) == (24, 18) and x[1] - x[0] == pytest.approx(frame.dx)
    outside = (frame.phi < 0) & (y > 0.7e-3)
    assert outside.sum() * frame.dx**2 == pytest.approx(frame.ledger.volume, rel=0.15)
    liquid, line = frame.mesh("liquid"), frame.contact_line
    assert liquid.positions.shape == (len(liquid), 3) and liquid.edges.max() < len(liquid)
    assert liquid.triangles.shape == (0, 3) and set(numpy.unique(liquid["kind"])) <= {0.0, 1.0, 2.0}
    assert frame.angle("plate") == pytest.approx(line["angle"].mean()) and line.unit("angle") == "deg"
    assert frame.solid("plate").phi_c.min() < 0 and frame.solid("plate").elements is None
    for wrong in (lambda: frame.solid("plte"), lambda: frame.mesh("plte"), lambda: line["nothing"]):
        with pytest.raises(KeyError, match="there are"):
            wrong()
    with pytest.raises(AttributeError, match="does not deform"):
        frame.solid("plate").displacement
    assert series["time"][-1] == 0.002 and numpy.isnan(series["contact_length"]).any()


def test_meshes_and_frames_are_saved(scene_file, tmp_path):
    with mn.Scene(scene_file).start(tmp_path / "out") as sim:
        sim.run_to_end()
        frame = sim.frame
    for ending in ("ply", "vtp", "obj", "glb", "usda"):
        frame.mesh("plate").save(tmp_path / f"plate.{ending}")
        frame.mesh("liquid").save(tmp_path / f"liquid.{ending}")
    assert (tmp_path / "liquid.ply").read_bytes() == (tmp_path / "out/frames/liquid_0004.ply").read_bytes()
    frame.contact_line.save(tmp_path / "line.csv")
    for ending in ("usda", "glb", "vti"):
        frame.save(tmp_path / f"all.{ending}")
    with pytest.raises(ValueError, match="saved as"):
        frame.mesh("liquid").save(tmp_path / "liquid.stl")
    assert not [name for name in os.listdir(tmp_path) if name.endswith(".parts")]


def test_a_folder_is_read(scene_file, tmp_path):
    with mn.Scene(scene_file).start(tmp_path / "out") as sim:
        live = list(sim.frames())
    run = mn.open(tmp_path / "out")
    assert len(run) == 5 and run.dimension == 2 and run.summary["steps"] == sim.steps
    assert [frame.time for frame in run] == [frame.time for frame in live]
    assert (run[-1].mesh("liquid").positions == live[-1].mesh("liquid").positions).all()
    assert run[-1].angle("plate") == pytest.approx(live[-1].angle("plate"))
    with pytest.raises(AttributeError, match="read from files"):
        run[0].phi
    with pytest.raises(IndexError):
        run[5]
    with pytest.raises(mn.OutputError):
        mn.open(tmp_path)


def test_steps_release_the_interpreter(scene_file, tmp_path):
    ticks, done = [], threading.Event()

    def tick():
        while not done.is_set():
            ticks.append(time.perf_counter())
            time.sleep(0.001)

    beside = threading.Thread(target=tick)
    scene = mn.Scene(scene_file)
    scene["domain.resolution"] = 96
    with scene.start(tmp_path / "out", threads=1) as sim:
        beside.start()
        began = time.perf_counter()
        sim.run_to_end()
        took = time.perf_counter() - began
    done.set()
    beside.join()
    assert sum(began <= t <= began + took for t in ticks) > 0.1 * took / 0.001


INTERRUPTED = """
import sys, meniscus as mn
scene = mn.Scene(sys.argv[1])
scene["domain.resolution"] = 96
try:
    with scene.start(sys.argv[2]) as sim:
        for frame in sim.frames(until="20 ms"):
            print(frame.number, flush=True)
except KeyboardInterrupt:
    print("interrupted", sim.is_closed, flush=True)
"""


def test_ctrl_c_leaves_a_checkpoint(scene_file, tmp_path):
    command = [sys.executable, "-c", INTERRUPTED, str(scene_file), str(tmp_path / "cut")]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert process.stdout.readline().strip() == "0" and process.stdout.readline().strip() == "1"
    process.send_signal(signal.SIGINT)
    rest, _ = process.communicate(timeout=60)
    assert process.returncode == 0 and rest.splitlines()[-1] == "interrupted True", rest
    summary = mn.open(tmp_path / "cut").summary
    assert summary["exit_reason"] == "stopped: signal" and summary["simulated_seconds"] < 0.01
    scene = mn.Scene(scene_file)
    scene["domain.resolution"] = 96
    mn.run(scene, tmp_path / "cut", resume=True, until="2.5 ms")
    mn.run(scene, tmp_path / "whole", until="2.5 ms")
    assert content(tmp_path / "cut") == content(tmp_path / "whole")

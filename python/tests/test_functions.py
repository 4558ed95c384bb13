"""Functions of time: gravity, and the motion of a solid."""

import math

import numpy
import pytest

import meniscus as mn
from conftest import content


def free_drop(scene_file):
    """The small scene with a drop that touches nothing."""
    scene = mn.Scene(scene_file)
    scene["solid.plate.shape"] = {"box": {"lower": ["0.5 mm", "0.1 mm"], "upper": ["3.5 mm", "0.4 mm"]}}
    scene["liquid.body.0.shape"] = {"ball": {"center": ["2 mm", "1.9 mm"], "radius": "0.6 mm"}}
    return scene


def test_gravity_is_a_function_of_time(scene_file, tmp_path):
    period, largest = 4e-3, 30.0
    calls = []

    def gravity(t):
        calls.append(t)
        return [largest * math.cos(2 * math.pi * t / period), 0.0]

    scene = free_drop(scene_file)
    scene["numerics.max_step"] = "0.02 ms"
    with scene.start(tmp_path / "out", gravity=gravity) as sim:
        sim.run_to_end(until="1 ms")
        frame, series = sim.frame, sim.series
    assert calls == list(series["time"][:-1])
    mass = 1000.0 * frame.ledger.volume
    expected = mass * largest * period / (2 * math.pi)
    # Velocities are half a step ahead: gravity is read one step before the middle of the time for which it acts, which is the term of first
    # order in the step. What remains is of second order, 3.1 % squared.
    expected *= 1 + 2 * math.pi * 2e-5 / period
    assert frame.ledger.momentum[0] == pytest.approx(expected, rel=1e-3)
    assert abs(frame.ledger.momentum[1]) < 1e-3 * expected
    assert "Gravity was a function" in (tmp_path / "out" / "scene.toml").read_text()
    with pytest.raises(mn.OutputError, match="another scene"):
        scene.start(tmp_path / "out", resume=True, until="2 ms")


def test_a_run_with_gravity_goes_on_with_the_same_bits(scene_file, tmp_path):
    def gravity(t):
        return [20 * math.sin(3000 * t), -9.81]

    scene = free_drop(scene_file)
    mn.run(scene, tmp_path / "whole", gravity=gravity)
    with scene.start(tmp_path / "cut", gravity=gravity) as sim:
        for frame in sim.frames():
            if frame.number == 1:
                break
    mn.run(scene, tmp_path / "cut", gravity=gravity, resume=True)
    assert content(tmp_path / "cut") == content(tmp_path / "whole")


def test_constant_gravity_of_a_function_is_that_of_the_scene(scene_file, tmp_path):
    scene = mn.Scene(scene_file)
    mn.run(scene, tmp_path / "scene")
    scene["liquid.gravity"] = ["0 m/s^2", "0 m/s^2"]
    mn.run(scene, tmp_path / "function", gravity=lambda t: [0.0, -9.81])
    frames = [content(tmp_path / of) for of in ("scene", "function")]
    for of in frames:
        # What precedes the first call has the gravity of the scene: the potential energy in the first row, the line's forces in frame 0.
        del of["series"], of["contact_line_0000.ply"]
    assert frames[0] == frames[1]


def test_an_error_of_the_function_ends_the_run_with_a_checkpoint(scene_file, tmp_path):
    def gravity(t):
        if t > 5e-4:
            raise RuntimeError("enough")
        return [0.0, -9.81]

    with pytest.raises(RuntimeError, match="enough"):
        with free_drop(scene_file).start(tmp_path / "out", gravity=gravity) as sim:
            sim.run_to_end()
    assert sim.is_closed and mn.open(tmp_path / "out").summary["exit_reason"].startswith("stopped")


def test_a_solid_moves_along_a_function(scene_file, tmp_path):
    scene = free_drop(scene_file)
    scene.move_solid("plate", lambda t: [1e-4 * math.sin(1000 * t), 0.0], until=2e-3, every=1e-4)
    with scene.start(tmp_path / "out") as sim:
        places = [(f.time, f.solid("plate").positions[:, 0].mean()) for f in sim.frames()]
    times, at = numpy.array(places).T
    numpy.testing.assert_allclose(at - at[0], 1e-4 * numpy.sin(1000 * times), atol=2e-7)
    again = mn.run(tmp_path / "out" / "scene.toml", tmp_path / "again")
    assert again.summary["steps"] == sim.steps
    with pytest.raises(ValueError, match="keyframes"):
        scene.move_solid("plate", lambda t: [0.0, 0.0], until=1.0, every=0.0)

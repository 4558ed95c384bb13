"""Cases and sweeps: plain functions that processes map, killed and resumed, and the same results as of the command."""

import concurrent.futures
import csv
import multiprocessing
import os
import pickle
import signal
import subprocess
import sys
import time
import warnings

import numpy
import pytest

import meniscus as mn
from conftest import content

ANGLE = "tension.plate.contact_angle"


def test_cases_are_mapped_by_processes(scene_file, tmp_path):
    assert pickle.loads(pickle.dumps(mn.run_case)) is mn.run_case
    scene = mn.Scene(scene_file)
    settings = [{ANGLE: f"{angle} deg"} for angle in (60, 120)]
    folders = [tmp_path / f"case_{k}" for k in range(2)]
    context = multiprocessing.get_context("spawn")
    with concurrent.futures.ProcessPoolExecutor(2, mp_context=context) as pool:
        results = list(pool.map(mn.run_case, [scene] * 2, settings, folders))
    assert [result["settings"] for result in results] == settings
    assert all(result["exit_reason"] == "finished" for result in results)
    first, second = (result["solids"][0]["contact_angle"] for result in results)
    assert first < second
    mn.run_case(str(scene_file), settings[1], tmp_path / "alone")
    assert content(tmp_path / "alone") == content(folders[1])
    again = mn.run_case(scene, settings[0], folders[0])
    assert again["steps"] == results[0]["steps"] and again["wall_seconds"] == results[0]["wall_seconds"]


def test_a_case_that_is_killed_goes_on(scene_file, tmp_path):
    settings = {"domain.resolution": 128, "output.checkpoint_every": 1}
    arguments = (str(scene_file), settings, tmp_path / "cut")
    process = multiprocessing.get_context("spawn").Process(target=mn.run_case, args=arguments)
    process.start()
    frame = tmp_path / "cut" / "frames" / "liquid_0001.ply"
    until = time.monotonic() + 60
    while not frame.exists() and time.monotonic() < until:
        time.sleep(0.002)
    process.kill()
    process.join()
    assert process.exitcode != 0 and mn.open(tmp_path / "cut").summary["exit_reason"] == "running"
    resumed = mn.run_case(*arguments)
    whole = mn.run_case(str(scene_file), settings, tmp_path / "whole")
    assert resumed["exit_reason"] == "finished" and resumed["steps"] == whole["steps"]
    assert content(tmp_path / "cut") == content(tmp_path / "whole")


def test_a_sweep_is_that_of_the_command(scene_file, tmp_path):
    scene = mn.Scene(scene_file)
    scene["output.duration"] = "1 ms"
    vary = {"domain.resolution": [20, 24], ANGLE: ["60 deg", "120 deg"]}
    table = mn.sweep(scene, vary, out=tmp_path / "mine", jobs=2)
    command = [sys.executable, "-m", "meniscus", "sweep", str(scene_file), "--set", "output.duration=1 ms"]
    command += ["--vary", "domain.resolution=20,24", "--vary", f"{ANGLE}=60 deg,120 deg", "--jobs", "2"]
    subprocess.run(command + ["--quiet", "--out", str(tmp_path / "other")], check=True)
    for case in range(4):
        assert content(tmp_path / "mine" / f"case_{case:04}") == content(tmp_path / "other" / f"case_{case:04}")
    with open(tmp_path / "other" / "sweep.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert list(table["domain.resolution"]) == [20, 20, 24, 24] and list(table[ANGLE]) == [60, 120, 60, 120]
    titles = [f"{name} ({unit})" if unit else name for name, unit in table.units.items()]
    assert titles == list(rows[0])
    for name, title in zip(table, titles):
        if name not in ("state", "wall time"):
            cells = [float(row[title]) if row[title] else numpy.nan for row in rows]
            numpy.testing.assert_array_equal(table[name], cells, err_msg=name)
    assert list(table["state"]) == ["finished"] * 4 and table["volume_drift met"].all() and len(str(table)) > 100
    before = os.stat(tmp_path / "mine" / "case_0000" / "summary.json").st_mtime_ns
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        mn.sweep(scene, vary, out=tmp_path / "mine")
    assert os.stat(tmp_path / "mine" / "case_0000" / "summary.json").st_mtime_ns == before
    with pytest.raises(mn.OutputError, match="another sweep"):
        mn.sweep(scene, {ANGLE: ["60 deg", "80 deg"]}, out=tmp_path / "mine")
    with pytest.raises(mn.SceneError, match="furlong"):
        mn.sweep(scene, {ANGLE: ["60 furlong"]}, out=tmp_path / "wrong")


INTERRUPTED = """
import sys, meniscus as mn
scene = mn.Scene(sys.argv[1])
scene["domain.resolution"] = 128
try:
    mn.sweep(scene, {"tension.plate.contact_angle": ["60 deg", "120 deg"]}, out=sys.argv[2])
except KeyboardInterrupt:
    print("interrupted")
"""


def test_ctrl_c_stops_a_sweep(scene_file, tmp_path):
    command = [sys.executable, "-c", INTERRUPTED, str(scene_file), str(tmp_path / "out")]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    frame = tmp_path / "out" / "case_0000" / "frames" / "liquid_0001.ply"
    until = time.monotonic() + 60
    while not frame.exists() and time.monotonic() < until:
        time.sleep(0.002)
    process.send_signal(signal.SIGINT)
    text, _ = process.communicate(timeout=60)
    assert text == "interrupted\n" and process.returncode == 0
    assert mn.open(tmp_path / "out" / "case_0000").summary["exit_reason"].startswith("stopped: signal")
    assert not (tmp_path / "out" / "case_0001").exists()
    scene = mn.Scene(scene_file)
    scene["domain.resolution"] = 128
    table = mn.sweep(scene, {ANGLE: ["60 deg", "120 deg"]}, out=tmp_path / "out")
    assert list(table["state"]) == ["finished"] * 2


def test_a_table_goes_to_pandas(scene_file, tmp_path):
    pandas = pytest.importorskip("pandas")
    scene = mn.Scene(scene_file)
    scene["output.duration"] = "0.5 ms"
    table = mn.sweep(scene, {ANGLE: ["60 deg", "120 deg"]}, out=tmp_path / "out")
    frame = table.to_pandas()
    assert isinstance(frame, pandas.DataFrame) and list(frame[ANGLE]) == [60.0, 120.0]

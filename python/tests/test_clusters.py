"""Cases on a local cluster of Dask and of Ray. One is killed with its worker; the cluster starts it again, and it goes on to the same bits."""

import os
import pathlib
import signal
import threading
import time

import pytest

import meniscus as mn
from conftest import content

ANGLES = (60, 90, 120)
# Slow enough to be killed on the way.
SLOW = {"domain.resolution": 128, "output.checkpoint_every": 1}


def case(scene: str, folder: str, angle: float) -> dict:
    """One case. It tells the process that it runs in."""
    path = pathlib.Path(folder) / f"angle-{angle}"
    path.with_suffix(".pid").write_text(str(os.getpid()))
    return mn.run_case(scene, {**SLOW, "tension.plate.contact_angle": f"{angle} deg"}, path)


def kill_on_the_way(folder: pathlib.Path, killed: list) -> threading.Thread:
    """Kills the process of the case of 90 degrees when its first frames are there."""

    def work():
        path = folder / "angle-90"
        until = time.monotonic() + 120
        while not (path / "frames" / "liquid_0001.ply").exists() and time.monotonic() < until:
            time.sleep(0.002)
        pid = int(path.with_suffix(".pid").read_text())
        os.kill(pid, signal.SIGKILL)
        killed.append((pid, mn.open(path).summary["exit_reason"]))

    thread = threading.Thread(target=work)
    thread.start()
    return thread


def check(results: list, folder: pathlib.Path, scene: pathlib.Path, killed: list) -> None:
    """Whether all cases are finished, the killed one in another process and with the bits of a run that nobody killed."""
    assert [result["exit_reason"] for result in results] == ["finished"] * 3
    pid, state = killed[0]
    assert state == "running" and int((folder / "angle-90.pid").read_text()) != pid
    angles = [result["solids"][0]["contact_angle"] for result in results]
    assert angles == sorted(angles)
    (folder / "whole").mkdir()
    case(str(scene), str(folder / "whole"), 90)
    assert content(folder / "angle-90") == content(folder / "whole" / "angle-90")


def test_dask_maps_cases(scene_file, tmp_path):
    distributed = pytest.importorskip("distributed")
    killed: list = []
    with distributed.LocalCluster(2, threads_per_worker=1, dashboard_address=None) as cluster:
        with cluster.get_client() as client:
            thread = kill_on_the_way(tmp_path, killed)
            results = client.gather(client.map(case, [str(scene_file)] * 3, [str(tmp_path)] * 3, ANGLES))
            thread.join()
    check(results, tmp_path, scene_file, killed)


def test_ray_maps_cases(scene_file, tmp_path):
    ray = pytest.importorskip("ray")
    killed: list = []
    os.environ["RAY_USAGE_STATS_ENABLED"] = "0"
    # Workers import this module.
    where = {"env_vars": {"PYTHONPATH": str(pathlib.Path(__file__).parent)}}
    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False, configure_logging=False, runtime_env=where)
    try:
        remote = ray.remote(case)
        thread = kill_on_the_way(tmp_path, killed)
        results = ray.get([remote.remote(str(scene_file), str(tmp_path), angle) for angle in ANGLES])
        thread.join()
    finally:
        ray.shutdown()
    check(results, tmp_path, scene_file, killed)

"""Scenes: settings, errors with places, checks, pickling, the command."""

import copy
import pickle
import subprocess
import sys

import pytest

import meniscus as mn


def test_settings_are_those_of_set(scene_file):
    scene = mn.Scene(scene_file)
    scene["tension.plate.contact_angle"] = "60 deg"
    scene["domain.resolution"] = 32
    scene["liquid.gravity"] = ["0 m/s^2", "-1 m/s^2"]
    assert scene["domain.resolution"] == 32 and scene["solid.plate.name"] == "plate"
    assert scene["tension.plate.contact_angle"].endswith(" rad")
    assert scene.settings[0] == "tension.plate.contact_angle=60 deg"
    assert (scene.name, scene.dimension, scene.quality) == ("small", 2, "normal")
    assert scene.toml().startswith("# As run")
    with pytest.raises(KeyError, match="no `nothing`"):
        scene["domain.nothing"]


def test_a_refused_setting_tells_where_and_is_not_kept(scene_file):
    scene = mn.Scene(scene_file)
    with pytest.raises(mn.SceneError, match="unknown unit `furlong`") as caught:
        scene["tension.plate.contact_angle"] = "110 furlong"
    error = caught.value
    assert (error.file, error.line, error.column, error.text) == ("--set", 1, 29, "110 furlong")
    assert error.status == 3 and "deg, rad" in error.help and "--> --set:1:29" in str(error)
    assert scene.settings == []


def test_errors_of_files_tell_where(scene_file, tmp_path):
    wrong = tmp_path / "wrong.toml"
    wrong.write_text(scene_file.read_text().replace("resolution = 24", "resolutoin = 24"))
    with pytest.raises(mn.SceneError) as caught:
        mn.Scene(wrong)
    error = caught.value
    assert (error.file, error.line, error.column) == (str(wrong), 7, 1)
    assert error.text == "resolutoin" and "resolution" in str(error)
    with pytest.raises(mn.OutputError, match="did you mean `oscillating-drop-2d`"):
        mn.Scene("oscilating-drop-2d")
    with pytest.raises(ValueError, match="draft"):
        mn.Scene(scene_file, quality="best")


def test_a_check_is_a_dict_with_a_text(scene_file):
    report = mn.Scene(scene_file).check()
    assert report["dimension"] == 2 and report["memory_bytes"] > 0 and report["run_seconds"] >= 0
    assert "capillary length" in str(report)
    assert str(pickle.loads(pickle.dumps(report))) == str(report)


def test_scenes_can_be_pickled(scene_file):
    scene = mn.Scene(scene_file, quality="draft")
    scene["domain.resolution"] = 20
    other = pickle.loads(pickle.dumps(scene))
    assert (other.source, other.quality, other.settings) == (scene.source, "draft", scene.settings)
    assert copy.copy(scene)["domain.resolution"] == scene["domain.resolution"] == 10  # a draft has half


def test_builtin_scenes_are_listed():
    names = [scene["name"] for scene in mn.builtin_scenes()]
    assert "drop-on-soft-plate" in names and mn.Scene(names[0]).name == names[0]


def test_the_package_is_the_command(scene_file):
    command = [sys.executable, "-m", "meniscus"]
    done = subprocess.run(command + ["check", str(scene_file)], capture_output=True, text=True)
    assert done.returncode == 0 and "capillary length" in done.stdout
    done = subprocess.run(command + ["check", "nothing.toml"], capture_output=True, text=True)
    assert done.returncode == 4 and "nothing.toml" in done.stderr
    assert subprocess.run(command + ["nonsense"], capture_output=True).returncode == 2

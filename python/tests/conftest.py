"""What the tests share."""

import pathlib

import pytest

SCENE = """
format = 1
name = "small"
[domain]
dimension = 2
size = ["4 mm", "3 mm"]
resolution = 24
[liquid]
density = "1 g/cm^3"
kinematic_viscosity = "1 mm^2/s"
gravity = ["0 m/s^2", "-9.81 m/s^2"]
[[liquid.body]]
shape.ball = { center = ["2 mm", "1.4 mm"], radius = "0.7 mm" }
[[solid]]
name = "plate"
density = "1 g/cm^3"
shape.box = { lower = ["0.5 mm", "0.3 mm"], upper = ["3.5 mm", "0.7 mm"] }
material.rigid = { fixed = true }
[tension]
liquid_air = "72 mN/m"
plate = { contact_angle = "90 deg" }
[output]
duration = "2 ms"
frame_interval = "0.5 ms"
formats = ["ply"]
[expect]
volume_drift = { max = 0.01 }
"""


@pytest.fixture
def scene_file(tmp_path: pathlib.Path) -> pathlib.Path:
    """A scene in 2D that runs in less than a second."""
    path = tmp_path / "small.toml"
    path.write_text(SCENE)
    return path


def content(folder: pathlib.Path) -> dict:
    """The frames of a run, and its series without the wall times, for comparisons to the bit."""
    frames = {path.name: path.read_bytes() for path in (pathlib.Path(folder) / "frames").iterdir()}
    rows = (pathlib.Path(folder) / "timeseries.csv").read_text().splitlines()
    wall = rows[0].split(",").index("wall_seconds")
    frames["series"] = [[cell for k, cell in enumerate(row.split(",")) if k != wall] for row in rows]
    return frames

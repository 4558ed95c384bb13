"""Meniscus: liquids with surface tension that meet solids.

A scene is made, checked, run and looked at::

    import meniscus as mn

    scene = mn.Scene("drop-on-soft-plate", quality="draft")
    scene["tension.plate.contact_angle"] = "110 deg"
    print(scene.check())
    with scene.start("out/soft", resume=True) as sim:
        for frame in sim.frames(until="32 ms"):
            print(frame.time, frame.angle("plate"))

All numbers are in SI units and angles in degrees; scenes have units of their own (``"110 deg"``). A run has the same folder and the same
bits as one of the command ``meniscus run``.
"""

from ._cases import Check, builtin_scenes, run, run_case
from ._meniscus import (
    Elements,
    Frame,
    Frames,
    Ledger,
    Mesh,
    MeniscusError,
    OutputError,
    Run,
    Scene,
    SceneError,
    Simulation,
    Solid,
    SolverError,
    __version__,
    open,
)
from ._table import Table, sweep

__all__ = [
    "Check",
    "Elements",
    "Frame",
    "Frames",
    "Ledger",
    "MeniscusError",
    "Mesh",
    "OutputError",
    "Run",
    "Scene",
    "SceneError",
    "Simulation",
    "Solid",
    "SolverError",
    "Table",
    "__version__",
    "builtin_scenes",
    "open",
    "run",
    "run_case",
    "sweep",
]

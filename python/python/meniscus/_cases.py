"""Checks of scenes, and runs as plain functions."""

from __future__ import annotations

import json
import os
from typing import Any, Dict, List, Mapping, Optional, Union

from . import _meniscus
from ._meniscus import Scene

PathLike = Union[str, "os.PathLike[str]"]


class Check(Dict[str, Any]):
    """The report of a check: a dict as of ``meniscus check --json``; ``print`` shows it as text.

    Among its keys: ``bond``, ``weber``, ``ohnesorge`` (numbers or None), ``capillary_length``, ``radius``, ``dx`` (m), ``cell_count``,
    ``memory_bytes``, ``steps``, ``run_seconds`` (s, a rough estimate), ``pairs`` (Young's angles), ``warnings``.
    """

    def __init__(self, text: str, values: Mapping[str, Any]) -> None:
        super().__init__(values)
        self.text = text

    def __str__(self) -> str:
        return self.text

    def __reduce__(self) -> Any:
        return (Check, (self.text, dict(self)))


def builtin_scenes() -> List[Dict[str, Any]]:
    """The built-in scenes: a list of dicts with ``name``, ``dimension``, ``figure``, ``line`` and ``cost``."""
    return json.loads(_meniscus.builtin_scenes())


def run(scene: Union[Scene, PathLike], out: Optional[PathLike] = None, **options: Any) -> _meniscus.Run:
    """Runs a scene to its end, and opens its folder.

    ``options`` are those of ``Scene.start``: ``resume``, ``force``, ``until``, ``threads``, ``gravity``. Raises what that raises.
    """
    made = scene if isinstance(scene, Scene) else Scene(scene)
    with made.start(out, **options) as simulation:
        simulation.run_to_end()
    return _meniscus.open(simulation.folder)


def run_case(
    scene: Union[Scene, PathLike],
    settings: Optional[Mapping[str, Any]] = None,
    folder: Optional[PathLike] = None,
    *,
    threads: Optional[int] = 1,
    until: Optional[str] = None,
) -> Dict[str, Any]:
    """Runs one case of many: the scene with these settings, into this folder; returns its results.

    It can be pickled with all its arguments, so that multiprocessing, ``concurrent.futures``, Dask and Ray can map it. A case that was
    killed goes on from its last checkpoint when it is called again with the same arguments, and has the same bits; one that is finished is
    not run again.

    ``settings`` are values by path, as of ``scene[path] = value``. The result is the summary of the run (``summary.json``) as a dict with two
    more entries, ``settings`` and ``folder``. Its numbers are in SI units, angles in degrees.
    """
    made = Scene(scene.source, scene.quality, scene.settings) if isinstance(scene, Scene) else Scene(scene)
    for path, value in (settings or {}).items():
        made[path] = value
    with made.start(folder, resume=True, threads=threads, until=until) as simulation:
        simulation.run_to_end()
    results = dict(simulation.summary)
    results["settings"] = dict(settings or {})
    results["folder"] = os.fspath(simulation.folder)
    return results

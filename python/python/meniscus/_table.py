"""Sweeps and their tables."""

from __future__ import annotations

import json
import os
import sys
import warnings
from typing import TYPE_CHECKING, Any, Dict, Iterator, List, Mapping, Optional, Sequence, Union

from . import _meniscus
from ._meniscus import Scene

if TYPE_CHECKING:
    import numpy

PathLike = Union[str, "os.PathLike[str]"]

# Exit statuses of a case that is no failure: finished, a check is missed, stopped.
_FINE = (0, 6, 75)


class Table(Mapping[str, "numpy.ndarray"]):
    """The table of a sweep: columns by name, each a numpy array with an entry for each case.

    The columns are ``case``, the varied parameters by their paths, ``state``, ``met`` (1 where all checks are met, 0 where one is missed,
    nan where the case is not finished), the checks of ``[expect]`` (each followed by ``NAME met``), and measures of the run. Columns of numbers
    are float64, with nan where there is no value; others are of strings. ``units`` has the unit of each column, ``folder`` is the folder of
    the sweep, whose ``sweep.csv`` and ``index.html`` have the same table.
    """

    def __init__(self, columns: Dict[str, "numpy.ndarray"], units: Dict[str, str], folder: str) -> None:
        self._columns = columns
        self.units = units
        self.folder = folder

    def __getitem__(self, name: str) -> "numpy.ndarray":
        return self._columns[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    def to_pandas(self) -> Any:
        """The table as a ``pandas.DataFrame``; pandas has to be installed."""
        import pandas  # type: ignore

        return pandas.DataFrame(dict(self._columns))

    def __str__(self) -> str:
        titles = [f"{name} ({unit})" if unit else name for name, unit in self.units.items()]
        texts = [[title] + [_short(v) for v in column] for title, column in zip(titles, self._columns.values())]
        widths = [max(len(text) for text in column) for column in texts]
        lines = zip(*[[text.ljust(width) for text in column] for column, width in zip(texts, widths)])
        return "\n".join("  ".join(line).rstrip() for line in lines)

    def __repr__(self) -> str:
        return f"<meniscus.Table of {len(self['case'])} cases in {self.folder}>"


def _short(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _column(values: Sequence[Any]) -> "numpy.ndarray":
    """Numbers, flags and missing values as float64; anything else as strings."""
    import numpy

    def number(value: Any) -> float:
        return float("nan") if value is None else float(value)

    try:
        return numpy.array([number(value) for value in values], dtype=numpy.float64)
    except ValueError:
        return numpy.array(values, dtype=str)


def _text(value: Any) -> str:
    """A value as the text of a setting."""
    if isinstance(value, bool):
        return "true" if value else "false"
    return value if isinstance(value, str) else repr(value)


def sweep(
    scene: Union[Scene, PathLike],
    vary: Mapping[str, Sequence[Any]],
    *,
    out: Optional[PathLike] = None,
    jobs: int = 1,
    threads: Optional[int] = None,
) -> Table:
    """Runs a scene with all combinations of values, as ``meniscus sweep`` does, and returns the table.

    ``vary`` has the values of each parameter by its path, such as ``{"tension.plate.contact_angle": ["60 deg", "90 deg"]}``; the last
    parameter changes from case to case. ``out`` is the folder, by default ``out/NAME-sweep``; ``jobs`` cases run at a time, each in a process
    of its own with ``threads`` threads (by default those of the machine, shared by the jobs).

    The same call goes on where it was stopped or killed. Ctrl-C stops it with a checkpoint of each case that runs. Raises ``SceneError`` for a
    wrong value before anything runs, and ``OutputError`` for a folder that holds another sweep; warns of cases that failed.
    """
    made = scene if isinstance(scene, Scene) else Scene(scene)
    values: List[Any] = [(path, [_text(value) for value in of]) for path, of in vary.items()]
    program = [sys.executable, "-m", "meniscus"]
    options = {"out": out, "jobs": jobs, "threads": threads, "program": program}
    folder, text = _meniscus._sweep(made, values, options)
    result = json.loads(text)
    for case, status in result["ended"]:
        if status not in _FINE:
            log = os.path.join(folder, f"case_{case:04}.log")
            warnings.warn(f"case {case} failed with exit status {status}, see {log}", stacklevel=2)
    columns = {column["name"]: _column(column["values"]) for column in result["columns"]}
    return Table(columns, {column["name"]: column["unit"] for column in result["columns"]}, os.fspath(folder))

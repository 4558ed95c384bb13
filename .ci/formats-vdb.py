"""Reads the VDB files of a run with OpenVDB, and compares them with the fields of the VTK files, which formats-check.py has kept.

    python3 formats-vdb.py RUN    a Python that has OpenVDB's module, such as Debian's with python3-openvdb
"""

import sys
from pathlib import Path

import numpy as np

try:
    import openvdb
except ImportError:
    import pyopenvdb as openvdb

BAND = 3


def closed(phi, dx):
    """phi in a margin of the band around the grid, cut off at the ends of the grid."""
    padded = np.pad(phi.astype("f8"), BAND, mode="edge")
    off = [np.maximum(-x, x - n) for x, n in ((np.arange(m) - BAND + 0.5, m - 2 * BAND) for m in padded.shape)]
    off = np.meshgrid(*off, indexing="ij")
    outside = np.sqrt(sum(np.maximum(x, 0) ** 2 for x in off))
    inside = np.minimum(np.max(off, axis=0), 0)
    return np.maximum(padded, (outside + inside) * dx)


def array_of(grid, shape, lower, kind):
    values = np.zeros(shape, kind)
    grid.copyToArray(values, ijk=lower)
    return values


def active_of(grid, shape, lower):
    mask = np.zeros(shape, bool)
    for item in grid.citerOnValues():
        assert item.count == 1, "active tiles are not expected"
        mask[tuple(a - b for a, b in zip(item.min, lower))] = True
    return mask


def check_closed(path, level):
    """Every edge of the surface that OpenVDB makes of the level set belongs to two faces."""
    _, triangles, quads = level.convertToPolygons()
    faces = [np.asarray(f, int).reshape(-1, n) for f, n in ((triangles, 3), (quads, 4))]
    edges = [np.sort(np.stack([f, np.roll(f, -1, axis=1)], axis=-1).reshape(-1, 2), axis=1) for f in faces]
    _, counts = np.unique(np.concatenate(edges), axis=0, return_counts=True)
    assert len(counts) and (counts == 2).all(), (path, np.bincount(counts))


def check(path):
    fields = np.load(path.with_suffix(".npz"))
    dx, first = float(fields["dx"]), fields["first"]
    grids, metadata = openvdb.readAll(str(path))
    assert metadata["time"] == float(fields["time"]) and metadata["creator"].startswith("Meniscus"), metadata
    assert [grid.name for grid in grids] == ["phi", "velocity"], [grid.name for grid in grids]
    level, velocity = grids
    for grid in grids:
        assert grid.transform.voxelSize() == (dx, dx, dx), grid.transform.voxelSize()
        assert np.allclose(grid.transform.indexToWorld((1, 2, 3)), first + np.array([1, 2, 3]) * dx, rtol=1e-14)
    assert level.gridClass == openvdb.GridClass.LEVEL_SET and velocity.gridClass == openvdb.GridClass.UNKNOWN
    background = np.float32(BAND) * np.float32(dx)
    assert np.float32(level.background) == background and tuple(velocity.background) == (0, 0, 0)
    # Arrays [x, y, z], as OpenVDB has them; far beyond the grid all is outside.
    phi = closed(fields["phi"].transpose(2, 1, 0), dx).astype("f4")
    wide = np.pad(phi, 8, constant_values=background)
    found = array_of(level, wide.shape, (-BAND - 8,) * 3, "f4")
    expected = np.clip(wide, -background, background)
    off = np.abs(found - expected).max()
    # VTK's file has phi in single precision, so that one rounding more is in the comparison where the surface is cut.
    assert off <= 2e-7 * background, (path, off)
    active = active_of(level, phi.shape, (-BAND,) * 3)
    edge = np.abs(np.abs(phi) - background) <= 2e-7 * background
    assert (active == (np.abs(phi) < background))[~edge].all(), path
    assert level.activeVoxelCount() == active.sum() and active.any()
    check_closed(path, level)
    inner = phi[BAND:-BAND, BAND:-BAND, BAND:-BAND]
    values = fields["velocity"].transpose(2, 1, 0, 3)
    found = array_of(velocity, values.shape, (0, 0, 0), "f4")
    moving = active_of(velocity, inner.shape, (0, 0, 0))
    edge = edge[BAND:-BAND, BAND:-BAND, BAND:-BAND]
    assert (moving == (inner < background))[~edge].all(), path
    assert np.array_equal(found[moving], values[moving]) and not found[~moving].any(), path
    return active.sum(), moving.sum(), off / dx


def main(run):
    files = sorted((run / "frames").glob("fields_*.vdb"))
    assert len(files) == len(sorted((run / "frames").glob("fields_*.vti"))) > 2, files
    told = [check(path) for path in files]
    band, moving, off = (max(row[k] for row in told) for k in range(3))
    print(
        f"formats-test: {run.name}: {len(files)} VDB files, up to {band} voxels of phi and {moving} of velocity, "
        f"phi to {off:.0e} cells, velocity to the bit"
    )


main(Path(sys.argv[1]))

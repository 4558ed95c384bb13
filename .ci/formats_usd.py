"""Reads the USD files of a run with Pixar's library, and compares them with the PLY files."""

import numpy as np
from formats_common import edges_of, same
from pxr import Usd, UsdGeom, UsdShade, UsdValidation

INTEGERS = ("kind", "solid")


def identifier(name):
    return "".join(c if c.isalnum() and c.isascii() else "_" for c in name)


def single(values):
    return np.asarray(values, "f8").astype("f4")


def check_mesh(what, prim, ply, n):
    mesh = UsdGeom.Mesh(prim)
    assert mesh.GetSubdivisionSchemeAttr().Get() == "none", what
    same(f"{what} counts", np.array(mesh.GetFaceVertexCountsAttr().Get(n)), np.full(len(ply.triangles), 3))
    same(f"{what} indices", np.array(mesh.GetFaceVertexIndicesAttr().Get(n)).reshape(-1, 3), ply.triangles)
    normals = np.array(mesh.GetNormalsAttr().Get(n))
    same(f"{what} normals", normals.shape, ply.points.shape)
    assert mesh.GetNormalsInterpolation() == "vertex" and np.allclose(np.linalg.norm(normals, axis=1), 1, atol=1e-6)
    if len(ply.points):
        # A closed surface encloses a volume, with a sign that tells where outside is.
        a, b, c = (ply.points[ply.triangles[:, k]] for k in range(3))
        volume = (np.cross(a, b) * c).sum() / 6
        faces = np.cross(b - a, c - a)
        assert (normals[ply.triangles[:, 0]] * faces).sum() > 0, what
        assert volume > 0, what
    return np.arange(len(ply.points))


def check_curves(what, prim, ply, n):
    """Order of the vertices of the curves in the PLY file."""
    curves = UsdGeom.BasisCurves(prim)
    assert (curves.GetTypeAttr().Get(), curves.GetWrapAttr().Get()) == ("linear", "nonperiodic"), what
    assert curves.GetWidthsInterpolation() == "constant" and curves.GetWidthsAttr().Get(n)[0] > 0, what
    counts = np.array(curves.GetCurveVertexCountsAttr().Get(n), int)
    points = np.array(curves.GetPointsAttr().Get(n)).reshape(-1, 3)
    assert counts.sum() == len(points) and (counts >= 2).all(), what
    place = {}
    for vertex, x in enumerate(single(ply.points)):
        assert tuple(x) not in place, f"{what}: two vertices at one place, which this comparison cannot tell apart"
        place[tuple(x)] = vertex
    order = np.array([place[tuple(x)] for x in points], int)
    lines = np.split(order, np.cumsum(counts)[:-1]) if len(counts) else []
    same(f"{what} edges", edges_of(lines), edges_of(ply.edges))
    return order


def check_prim(what, prim, ply, n, interval):
    kind = prim.GetTypeName()
    if kind == "Mesh":
        order = check_mesh(what, prim, ply, n)
    elif kind == "BasisCurves":
        order = check_curves(what, prim, ply, n)
    else:
        assert kind == "Points", (what, kind)
        order = np.arange(len(ply.points))
    same(f"{what} points", np.array(prim.GetAttribute("points").Get(n)).reshape(-1, 3), single(ply.points)[order])
    velocities = prim.GetAttribute("velocities").Get(n)
    assert (velocities is not None) == ("vx" in ply.attributes), what
    if velocities is not None:
        # Units a second of playback, at 24 frames a second.
        expected = ply.vectors(["vx", "vy", "vz"])[order] * interval * 24
        found = np.array(velocities).reshape(-1, 3)
        assert np.allclose(found, expected, rtol=1e-6, atol=1e-12), what
    api = UsdGeom.PrimvarsAPI(prim)
    primvars = {p.GetPrimvarName(): p for p in api.GetPrimvarsWithAuthoredValues()}
    primvars.pop("displayColor")
    assert sorted(primvars) == sorted(identifier(name) for name in ply.data()), (what, sorted(primvars))
    for name, values in ply.data().items():
        primvar = primvars[identifier(name)]
        expected = np.asarray(values, "i4" if name in INTEGERS else "f8")
        expected = expected if name in INTEGERS else single(expected)
        same(f"{what} {name}", np.array(primvar.Get(n)), expected[order])
        assert primvar.GetInterpolation() == "vertex", what
    if "angle" in primvars:
        assert primvars["angle"].GetAttr().GetCustomDataByKey("unit") == "deg", what
    extent = np.array(prim.GetAttribute("extent").Get(n))
    half = 0 if kind == "Mesh" else prim.GetAttribute("widths").Get(n)[0] / 2
    low, high = single(ply.points).min(axis=0) - half, single(ply.points).max(axis=0) + half
    assert np.allclose(extent, [low, high], rtol=1e-5, atol=1e-9), (what, extent, low, high)


def check_stage(stage, first, last, dimension):
    assert (UsdGeom.GetStageMetersPerUnit(stage), UsdGeom.GetStageUpAxis(stage)) == (1, "Z" if dimension == 3 else "Y")
    assert (stage.GetStartTimeCode(), stage.GetEndTimeCode()) == (first, last)
    root = stage.GetDefaultPrim()
    assert root.GetPath() == "/frame"
    return root


def check_materials(stage):
    found = {}
    for name in ("liquid", "contact_line"):
        material, _ = UsdShade.MaterialBindingAPI(stage.GetPrimAtPath(f"/frame/{name}")).ComputeBoundMaterial()
        shader, _, _ = material.ComputeSurfaceSource()
        assert shader.GetIdAttr().Get() == "UsdPreviewSurface", name
        found[name] = {i.GetBaseName(): i.Get() for i in shader.GetInputs()}
    assert np.isclose(found["liquid"]["ior"], 1.333) and found["liquid"]["opacity"] < 0.5, found
    assert found["contact_line"]["opacity"] == 1, found


def check_validity(stage):
    """All validators of the library."""
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    errors = UsdValidation.ValidationContext(validators).Validate(stage)
    said = [(error.GetName(), error.GetMessage()) for error in errors]
    assert len(validators) > 10 and not said, said


def check_usd(folder, stored, times, dimension):
    numbers = sorted(times)
    interval = times[numbers[-1]] / int(numbers[-1])
    assert sorted(p.name for p in folder.glob("*.usda")) == [f"frame_{n}.usda" for n in numbers] + ["run.usda"]
    run = Usd.Stage.Open(str(folder / "run.usda"))
    root = check_stage(run, int(numbers[0]), int(numbers[-1]), dimension)
    check_materials(run)
    check_validity(run)
    names = {stem.rsplit("_", 1)[0] for stem in stored}
    shown = {prim.GetDisplayName(): prim for prim in root.GetChildren() if prim.GetTypeName() != "Scope"}
    assert sorted(shown) == sorted(names), (folder, sorted(shown), sorted(names))
    for number in numbers:
        n, layer = int(number), Usd.Stage.Open(str(folder / f"frame_{number}.usda"))
        alone = check_stage(layer, n, n, dimension)
        for stage_root in (root, alone):
            same(f"{folder} time", stage_root.GetAttribute("meniscus:time").Get(n), times[number])
            for name in sorted(names):
                prim = stage_root.GetChild(identifier(name))
                what = f"{folder}/{name} {number}"
                ply = stored.get(f"{name}_{number}")
                if ply is None:
                    same(what, len(prim.GetAttribute("points").Get(n)), 0)
                else:
                    check_prim(what, prim, ply, n, interval)
        # A frame holds until the next one.
        for name in sorted(names):
            points = root.GetChild(identifier(name)).GetAttribute("points")
            same(f"{folder} {name} held", np.array(points.Get(n + 0.5)), np.array(points.Get(n)))

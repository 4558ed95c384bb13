"""Reads all files of a run and of its exports with meshio, trimesh, VTK, PyVista and USD, and compares them with the PLY files as read here.

    python formats-check.py RUN             RUN has frames/ with all formats, export/FORMAT/ of each, and turned/ with a scaled OBJ
    python formats-check.py --fields RUN    only keeps the fields of the VTK files as arrays, for formats-vdb.py
"""

import csv
import json
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import formats_common
import meshio
import numpy as np
import pyvista
import trimesh
import vtk
from formats_common import Ply, edges_of, same
from formats_usd import check_usd
from vtk.util.numpy_support import vtk_to_numpy


def check_ply(path, ply):
    mesh = meshio.read(path)
    same(path, mesh.points, ply.points)
    assert [block.type for block in mesh.cells] == ["triangle"] * bool(len(ply.triangles)), (path, mesh.cells)
    for block in mesh.cells:
        same(path, block.data, ply.triangles)
    assert sorted(mesh.point_data) == sorted(ply.attributes)
    for name, values in ply.attributes.items():
        same(f"{path} {name}", mesh.point_data[name], values)
    loaded = trimesh.load(path, process=False)
    same(path, loaded.vertices, ply.points)
    if len(ply.triangles):
        same(path, loaded.faces, ply.triangles)
        normals = ply.vectors(["nx", "ny", "nz"])
        assert np.allclose(np.linalg.norm(normals, axis=1), 1, atol=1e-6), path
        a, b, c = (ply.points[ply.triangles[:, k]] for k in range(3))
        assert (normals[ply.triangles[:, 0]] * np.cross(b - a, c - a)).sum() > 0, path


def cells_of(array):
    """Lists of points of the cells of a vtkCellArray."""
    ends = vtk_to_numpy(array.GetOffsetsArray())
    points = vtk_to_numpy(array.GetConnectivityArray())
    return [points[a:b] for a, b in zip(ends[:-1], ends[1:])]


def read_vtk(reader, path):
    reader.SetFileName(str(path))
    reader.Update()
    assert reader.GetErrorCode() == 0, path
    return reader.GetOutput()


def data_of(data):
    return {data.GetArrayName(i): vtk_to_numpy(data.GetArray(i)) for i in range(data.GetNumberOfArrays())}


def check_time(path, output, time):
    same(f"{path} time", output.GetFieldData().GetArray("TimeValue").GetValue(0), time)


def check_vtp(path, ply):
    output = read_vtk(vtk.vtkXMLPolyDataReader(), path)
    check_time(path, output, ply.time)
    same(path, vtk_to_numpy(output.GetPoints().GetData()), ply.points)
    same(path, np.array(cells_of(output.GetPolys()), int).reshape(-1, 3), ply.triangles)
    same(path, np.array(edges_of(cells_of(output.GetLines()))).reshape(-1, 2), np.array(edges_of(ply.edges)).reshape(-1, 2))
    same(path, output.GetNumberOfVerts(), len(ply.points) if ply.is_points else 0)
    data = data_of(output.GetPointData())
    assert sorted(data) == sorted(ply.data()), (path, list(data))
    for name, values in ply.data().items():
        same(f"{path} {name}", data[name], values)
        assert data[name].dtype == values.dtype.newbyteorder("="), (path, name)
    angle = output.GetPointData().GetArray("angle")
    if angle:
        assert angle.GetInformation().Get(vtk.vtkDataArray.UNITS_LABEL()) == "deg", path


def check_obj(path, ply, scale=1.0, turn=False):
    x, y, z = ply.points.T * scale
    points = np.stack([x, z, -y] if turn else [x, y, z], axis=1)
    for mesh in (meshio.read(path), trimesh.load(path, process=False)):
        same(path, mesh.points if hasattr(mesh, "points") else mesh.vertices, points)
    if len(ply.triangles):
        mesh = trimesh.load(path, process=False)
        same(path, mesh.faces, ply.triangles)
        normals = meshio.read(path).point_data["obj:vn"]
        assert np.allclose(np.linalg.norm(normals, axis=1), 1, atol=1e-6), path
    lines = [[int(v) - 1 for v in line.split()[1:]] for line in path.read_text().splitlines() if line.startswith("l ")]
    same(path, np.array(edges_of(lines)).reshape(-1, 2), np.array(edges_of(ply.edges)).reshape(-1, 2))


def glb_edges(path):
    """Edges of the lines of a GLB file by mesh. trimesh ignores the indices of lines and joins all vertices in their order."""
    data = path.read_bytes()
    length = int.from_bytes(data[12:16], "little")
    document, binary = json.loads(data[20 : 20 + length]), data[28 + length :]
    edges = {}
    for mesh in document["meshes"]:
        (primitive,) = mesh["primitives"]
        if primitive["mode"] == 1:
            accessor = document["accessors"][primitive["indices"]]
            view = document["bufferViews"][accessor["bufferView"]]
            edges[mesh["name"]] = np.frombuffer(binary, "<u4", accessor["count"], view["byteOffset"]).reshape(-1, 2)
    return edges


def check_glb(path, meshes, dimension):
    scene, lines = trimesh.load(path, process=False), glb_edges(path)
    assert sorted(scene.geometry) == sorted(meshes), (path, list(scene.geometry))
    for name, ply in meshes.items():
        mesh = scene.geometry[name]
        if len(ply.edges):
            same(f"{path} {name}", edges_of(lines[name]), edges_of(ply.edges))
        same(f"{path} {name}", np.asarray(mesh.vertices, "f4"), ply.points.astype("f4"))
        if not len(ply.triangles):
            continue
        same(f"{path} {name}", mesh.faces, ply.triangles)
        same(f"{path} {name}", mesh.visual.vertex_attributes["color"].shape, (len(ply.points), 4))
        for attribute, values in ply.data().items():
            found = mesh.vertex_attributes["_" + attribute.upper()]
            same(f"{path} {attribute}", np.asarray(found, "f4").reshape(-1), values.astype("f4"))
        outward = (mesh.vertex_normals * (mesh.vertices - mesh.vertices.mean(axis=0))).sum(axis=1)
        assert outward.mean() > 0, path
        turned, _ = scene.graph.get([n for n in scene.graph.nodes_geometry if scene.graph[n][1] == name][0])
        expected = [0, 1, 0] if dimension == 3 else [0, 0, 1]
        assert np.allclose(turned[:3, :3] @ [0, 0, 1], expected, atol=1e-7), (path, turned)


def check_csv(path, ply):
    with path.open(newline="") as file:
        head, *rows = csv.reader(file)
    names = [column.split(" ")[0] for column in head]
    assert names[:4] == ["time", "x", "y", "z"] and "angle (deg)" in head and "speed (m/s)" in head, head
    table = np.array(rows, float)
    same(path, table[:, 0], np.full(len(ply.points), ply.time))
    same(path, table[:, 1:4], ply.points)
    assert sorted(names[4:]) == sorted(ply.data())
    for column, name in enumerate(names[4:], 4):
        same(f"{path} {name}", table[:, column], ply.attributes[name])


def check_vtu(path, surface):
    output = read_vtk(vtk.vtkXMLUnstructuredGridReader(), path)
    check_time(path, output, surface.time)
    mesh, data = meshio.read(path), data_of(output.GetPointData())
    same(path, vtk_to_numpy(output.GetPoints().GetData()), mesh.points)
    same(path, np.array(cells_of(output.GetCells())), mesh.cells[0].data)
    same(path, data_of(output.GetCellData())["green_strain"], mesh.cell_data["green_strain"][0].reshape(-1, 9))
    place = {tuple(x): i for i, x in enumerate(mesh.points)}
    at = [place[tuple(x)] for x in surface.points]
    for axis, name in enumerate(["ux", "uy", "uz"]):
        same(f"{path} {name}", data["displacement"][at, axis], surface.attributes[name])
        same(f"{path} {name}", data["velocity"][at, axis], surface.attributes[name.replace("u", "v")])
    same(f"{path} strain", mesh.point_data["strain"][at], surface.attributes["strain"])
    corners = mesh.points[mesh.cells[0].data]
    assert (np.linalg.det(corners[:, 1:] - corners[:, :1]) > 0).all(), f"{path}: inverted elements"
    tensors = mesh.cell_data["green_strain"][0].reshape(-1, 3, 3)
    same(path, tensors, tensors.transpose(0, 2, 1))
    # What carries weight is pressed; without strain there is no stress.
    stress = data["stress"].reshape(-1, 3, 3)
    assert np.isfinite(stress).all() and np.allclose(stress, stress.transpose(0, 2, 1), atol=1e-9 * np.abs(stress).max(initial=1))
    assert (stress.any() and surface.time > 0) or np.abs(tensors).max() < 1e-12, path


def check_vti(path, liquid):
    output = read_vtk(vtk.vtkXMLImageDataReader(), path)
    check_time(path, output, liquid.time)
    data = data_of(output.GetPointData())
    assert sorted(data) == ["phi", "pressure", "velocity"], list(data)
    same(path, data["velocity"].shape, (output.GetNumberOfPoints(), 3))
    assert all(np.isfinite(values).all() for values in data.values()), path
    # The free surface is where phi is zero.
    probe, points, surface = vtk.vtkProbeFilter(), vtk.vtkPoints(), vtk.vtkPolyData()
    for x in liquid.points[liquid.attributes["kind"] == 0]:
        points.InsertNextPoint(*x)
    surface.SetPoints(points)
    probe.SetInputData(surface)
    probe.SetSourceData(output)
    probe.Update()
    phi = vtk_to_numpy(probe.GetOutput().GetPointData().GetArray("phi"))
    assert len(phi) and np.abs(phi).max() < 0.5 * output.GetSpacing()[0], (path, np.abs(phi).max())
    keep_fields(path, output, data)


def keep_fields(path, output, data):
    """Keeps the fields as arrays [z, y, x], for the Python that has OpenVDB."""
    shape = output.GetDimensions()[::-1]
    np.savez(
        path.with_suffix(".npz"),
        phi=data["phi"].reshape(shape),
        velocity=data["velocity"].reshape(*shape, 3),
        first=output.GetOrigin(),
        dx=output.GetSpacing()[0],
        time=output.GetFieldData().GetArray("TimeValue").GetValue(0),
    )


def check_pvd(path, times):
    """Files and times of a collection, also as PyVista reads it."""
    entries = ET.parse(path).getroot().find("Collection").findall("DataSet")
    files = sorted(p.name for p in path.parent.iterdir() if p.suffix in (".vtp", ".vtu"))
    assert sorted(e.get("file") for e in entries) == files, path
    parts = {}
    for entry in entries:
        stem, number = entry.get("file").split(".")[0].rsplit("_", 1)
        same(f"{path} {stem}", float(entry.get("timestep")), times[number])
        name = (stem, entry.get("file").split(".")[1])
        assert parts.setdefault(entry.get("part"), name) == name, path
    order = [float(e.get("timestep")) for e in entries]
    assert order == sorted(order), path
    reader = pyvista.get_reader(str(path))
    same(path, reader.time_values, sorted(times.values()))
    reader.set_active_time_value(reader.time_values[-1])
    blocks = reader.read()
    last = [e.get("file") for e in entries if float(e.get("timestep")) == order[-1]]
    assert blocks.n_blocks == len(last) and all(block.n_points for block in blocks), path


def main(run):
    frames = run / "frames"
    stored = {path.stem: Ply(path) for path in sorted(frames.glob("*.ply"))}
    numbers = sorted({stem.rsplit("_", 1)[1] for stem in stored})
    dimension = 3 if len(stored[f"liquid_{numbers[0]}"].triangles) else 2
    lines = [stem for stem in stored if stem.startswith("contact_line")]
    assert len(numbers) > 2 and lines, "the scene should have frames and contact lines"
    times = {number: stored[f"liquid_{number}"].time for number in numbers}
    for stem, ply in stored.items():
        assert len(ply.points), stem
        check_ply(frames / f"{stem}.ply", ply)
        for folder in (frames, run / "export/vtk"):
            check_vtp(folder / f"{stem}.vtp", ply)
        for folder in (frames, run / "export/obj"):
            check_obj(folder / f"{stem}.obj", ply)
        if stem in lines:
            for folder in (frames, run / "export/csv"):
                check_csv(folder / f"{stem}.csv", ply)
        if "ux" in ply.attributes:
            check_vtu(frames / f"{stem}.vtu", ply)
    for number in numbers:
        meshes = {stem.rsplit("_", 1)[0]: ply for stem, ply in stored.items() if stem.endswith(f"_{number}")}
        for folder in (frames, run / "export/glb"):
            check_glb(folder / f"frame_{number}.glb", meshes, dimension)
        check_vti(frames / f"fields_{number}.vti", meshes["liquid"])
    for folder in (frames, run / "export/usd"):
        check_usd(folder, stored, times, dimension)
    check_pvd(frames / "run.pvd", times)
    check_pvd(run / "export/vtk/run.pvd", times)
    check_obj(run / "turned/liquid_0001.obj", stored["liquid_0001"], 100.0, turn=dimension == 3)
    print(f"formats-test: {run.name}: {dimension}D, {len(numbers)} frames, {len(lines)} with a line, {formats_common.checks} comparisons")


if sys.argv[1] == "--fields":
    for image in sorted(Path(sys.argv[2], "frames").glob("*.vti")):
        fields = read_vtk(vtk.vtkXMLImageDataReader(), image)
        keep_fields(image, fields, data_of(fields.GetPointData()))
else:
    main(Path(sys.argv[1]))

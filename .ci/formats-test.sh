#!/usr/bin/env bash
# Runs two small scenes with all formats of frames, exports them again, and reads every file back with the programs that our users have:
# meshio, trimesh, VTK, PyVista, USD and OpenVDB. Without Python 3.10 or newer, or a package index to install them from, the test is left
# out; OpenVDB's Python module comes from Debian, and its part alone is left out where it cannot be installed.
#   .ci/formats-test.sh MENISCUS     the binary; PYTHON=… chooses a Python that has the packages already, VDB_PYTHON=… one with OpenVDB
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
[ $# -eq 1 ] || { echo "usage: formats-test.sh MENISCUS" >&2; exit 2; }
meniscus=$(cd "$(dirname "$1")" && pwd)/$(basename "$1")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

python=${PYTHON:-}
if [ -z "$python" ]; then
    if ! python3 -c 'import sys; sys.exit(sys.version_info < (3, 10))' 2>/dev/null || ! python3 -m venv "$work/venv" 2>/dev/null; then
        echo "formats-test: LEFT OUT: there is no Python 3.10 with venv"
        exit 0
    fi
    python=$work/venv/bin/python
    if ! "$python" -m pip install -q --disable-pip-version-check "numpy<2" meshio==5.3.5 trimesh==5.2.0 vtk==9.7.2 pyvista==0.49.1 scipy usd-core==26.11 >"$work/pip" 2>&1; then
        echo "formats-test: LEFT OUT: pip cannot install meshio, trimesh, vtk and usd-core here: $(tail -n 1 "$work/pip")"
        exit 0
    fi
fi

vdb_python=${VDB_PYTHON:-/usr/bin/python3}
has_vdb() { "$vdb_python" -c 'import pyopenvdb' 2>/dev/null || "$vdb_python" -c 'import openvdb' 2>/dev/null; }
if ! has_vdb && [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; then
    apt-get install -y -q --no-install-recommends python3-openvdb >"$work/apt" 2>&1 || true
fi

cat > "$work/plate-2d.toml" <<'SCENE'
format = 1
name = "plate-2d"
domain = { dimension = 2, size = ["6 mm", "4 mm"], resolution = 48 }
liquid = { density = "1 g/cm^3", kinematic_viscosity = "0.05 cm^2/s", gravity = ["0 m/s^2", "-9.81 m/s^2"], body = [
  { shape.ball = { center = ["3 mm", "1.9 mm"], radius = "1 mm" } } ] }
tension = { liquid_air = "72.8 mN/m", plate.contact_angle = "60 deg" }
output = { duration = "2 ms", frame_interval = "0.5 ms" }
[[solid]]
name = "plate"
shape.half_space = { point = ["3 mm", "1.03 mm"], normal = [0.1, 1] }
material.rigid.fixed = true
SCENE
cat > "$work/soft-3d.toml" <<'SCENE'
format = 1
name = "soft-3d"
domain = { dimension = 3, size = ["8 mm", "8 mm", "8 mm"], resolution = 24 }
liquid = { density = "1 g/cm^3", kinematic_viscosity = "0.1 cm^2/s", gravity = ["0 m/s^2", "0 m/s^2", "-9.81 m/s^2"], body = [
  { shape.ball = { center = ["4 mm", "4 mm", "4.4 mm"], radius = "1.5 mm" } } ] }
tension = { liquid_air = "72.8 mN/m", plate.contact_angle = "70 deg" }
output = { duration = "4 ms", frame_interval = "2 ms" }
[[solid]]
name = "plate"
density = "1 g/cm^3"
shape.box = { lower = ["1 mm", "1 mm", "2 mm"], upper = ["7 mm", "7 mm", "3.1 mm"] }
mesh.edge = "0.5 mm"
material.neo_hookean = { young_modulus = "2 kPa", poisson_ratio = 0.4 }
fixed = [{ box = { lower = ["0 mm", "0 mm", "1.9 mm"], upper = ["8 mm", "8 mm", "2.2 mm"] } }]
SCENE
# Liquid at all sides: the level set is closed there.
cat > "$work/tank-3d.toml" <<'SCENE'
format = 1
name = "tank-3d"
domain = { dimension = 3, size = ["8 mm", "6 mm", "8 mm"], resolution = 40 }
liquid = { density = "1 g/cm^3", kinematic_viscosity = "0.1 cm^2/s", body = [
  { shape.half_space = { point = ["4 mm", "3 mm", "5 mm"], normal = [0.2, 0, 1] } } ] }
tension.liquid_air = "72.8 mN/m"
output = { duration = "1 ms", frame_interval = "0.5 ms", formats = ["vti", "vdb"] }
SCENE

formats='"ply", "vtk", "vti", "obj", "glb", "usd", "csv"'
for scene in plate-2d soft-3d; do
    [ $scene = plate-2d ] || formats="$formats, \"vdb\""
    "$meniscus" run "$work/$scene.toml" --set "output.formats=[$formats]" --out "$work/$scene" --quiet
    for format in ply vtk obj glb usd csv; do
        "$meniscus" export "$work/$scene" --to "$format" >/dev/null 2>"$work/said" || { cat "$work/said" >&2; exit 1; }
    done
    "$meniscus" export "$work/$scene" --to obj --frames 1 --scale 100 --up y --out "$work/$scene/turned" >/dev/null
    "$python" "$here/formats-check.py" "$work/$scene"
done
if has_vdb; then
    "$meniscus" run "$work/tank-3d.toml" --out "$work/tank-3d" --quiet
    "$python" "$here/formats-check.py" --fields "$work/tank-3d"
    for scene in soft-3d tank-3d; do
        "$vdb_python" "$here/formats-vdb.py" "$work/$scene"
    done
else
    echo "formats-test: VDB LEFT OUT: $vdb_python has no module of OpenVDB (Debian: python3-openvdb)"
fi

#!/usr/bin/env bash
# Builds the wheel of the Python package from the crates that the release build has already, installs it into a fresh environment, and runs
# its tests. Without Python 3.10 or newer, or a package index to install maturin, numpy and pytest from, the test is left out.
#   .ci/python-test.sh     PYTHON=… chooses the interpreter
set -euo pipefail
cd "$(dirname "$0")/.."
python=${PYTHON:-python3}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# Largest size of the wheel, bytes, and longest time to import the package, s.
largest_wheel=12000000
longest_import=0.3

if ! "$python" -c 'import sys; sys.exit(sys.version_info < (3, 10))' 2>/dev/null || ! "$python" -m venv "$work/venv" 2>/dev/null; then
    echo "python-test: LEFT OUT: there is no Python 3.10 with venv"
    exit 0
fi
pip=("$work/venv/bin/python" -m pip --disable-pip-version-check)
if ! "${pip[@]}" install -q "maturin>=1.10,<2" numpy pytest >"$work/pip" 2>&1; then
    echo "python-test: LEFT OUT: pip cannot install maturin, numpy and pytest here: $(tail -n 1 "$work/pip")"
    exit 0
fi

# The wheel is made as `pip install ./python` makes it, but with the maturin that is installed.
TIMEFORMAT='wheel: %R s, %U s of the processors'
time MATURIN_PEP517_ARGS=--locked PATH="$work/venv/bin:$PATH" \
    "${pip[@]}" wheel -q --no-deps --no-build-isolation -w "$work" ./python
wheel=$(echo "$work"/meniscus-*.whl)
size=$(wc -c < "$wheel")
echo "$(basename "$wheel"): $size bytes"
case $wheel in *-cp310-abi3-*) ;; *) echo "the wheel is not one for Python 3.10 and newer" && exit 1 ;; esac
[ "$size" -le "$largest_wheel" ] || { echo "too large: at most $largest_wheel bytes"; exit 1; }

"$python" -m venv "$work/fresh"
pip=("$work/fresh/bin/python" -m pip --disable-pip-version-check)
"${pip[@]}" install -q "$wheel" pytest
"${pip[@]}" install -q distributed ray >"$work/pip" 2>&1 || echo "python-test: without Dask and Ray: $(tail -n 1 "$work/pip")"

# The best of five: other work on the machine does not count.
"$work/fresh/bin/python" - "$longest_import" <<'PROGRAM'
import subprocess, sys, time

program = "import time; t = time.perf_counter(); import meniscus; print(time.perf_counter() - t)"
times = [float(subprocess.check_output([sys.executable, "-c", program])) for _ in range(5)]
print(f"import: {min(times):.3f} s")
sys.exit(min(times) > float(sys.argv[1]))
PROGRAM

TIMEFORMAT='tests: %R s, %U s of the processors'
time "$work/fresh/bin/python" -m pytest -q -p no:cacheprovider python/tests

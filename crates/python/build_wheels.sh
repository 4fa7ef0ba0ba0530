#!/usr/bin/env bash
# Builds the wheel of the Python package for this machine's architecture into target/wheels, and tests it in a fresh environment:
#   crates/python/build_wheels.sh
# One wheel serves every CPython from 3.9 on. Its tag says which glibc it needs:
#   - with zig (pip install ziglang, or zig in the path) it is built for glibc 2.28: manylinux_2_28
#   - without, maturin gives it the tag that the symbols of the local glibc allow
# Needs Rust, CPython 3.9 or newer with venv, and the network for maturin and NumPy.
set -euo pipefail
cd "$(dirname "$0")/../.."

tools=target/python/tools
if [ ! -x "$tools/bin/maturin" ]; then
    python3 -m venv "$tools"
    "$tools/bin/pip" install --quiet --disable-pip-version-check 'maturin>=1.9.4,<2'
fi

options=(--release --out target/wheels)
if command -v zig >/dev/null || "$tools/bin/python" -c 'import ziglang' 2>/dev/null; then
    options+=(--zig --compatibility manylinux_2_28)
else
    echo "build_wheels.sh: no zig: the wheel needs a glibc like the one here ($(ldd --version | head -n 1))" >&2
fi
rm -f target/wheels/clearance-*.whl
"$tools/bin/maturin" build "${options[@]}"

wheel=$(echo target/wheels/clearance-*.whl)
fresh=$(mktemp -d)
trap 'rm -rf "$fresh"' EXIT
python3 -m venv "$fresh"
"$fresh/bin/pip" install --quiet --disable-pip-version-check "$wheel"
"$fresh/bin/python" - <<'PYTHON'
import clearance as cl
import numpy as np

robot = cl.Robot.from_urdf("urdf/demo_arm/demo_arm.urdf", "urdf/demo_arm/demo_arm.srdf")
checker = cl.Checker(robot, cl.World.from_file("config/demo_world.yaml", robot))
free = checker.is_free(robot.random(0, 1000))
assert isinstance(free, np.ndarray) and 0 < free.sum() < 1000
PYTHON
"$fresh/bin/clearance" check --urdf urdf/demo_arm/demo_arm.urdf --srdf urdf/demo_arm/demo_arm.srdf --state joint2=0.1
echo "$wheel: $(stat -c %s "$wheel") bytes"

#!/usr/bin/env bash
# Installs the Python package in a fresh virtual environment and runs its tests: ./run.sh [pytest arguments]
# CLEARANCE_PYTHON_LIBRARY is the built library; without it, cargo builds it here.
# Everything runs in a private network namespace, since some tests start the node.
# Needs, beside what environment.sh needs: unshare (util-linux), ip (iproute2).
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
root=$(cd "$here/../.." && pwd)
for name in ${!ROS_*} AMENT_PREFIX_PATH LD_LIBRARY_PATH PYTHONPATH PYTHONHOME; do
    unset "$name"
done

if [ -z "${CLEARANCE_PYTHON_LIBRARY:-}" ]; then
    cargo build --quiet --manifest-path "$root/Cargo.toml" --package clearance-python
    CLEARANCE_PYTHON_LIBRARY="$root/target/debug/libclearance_python.so"
fi

# the package as pip would install the wheel; the wheel itself is built and tested by crates/python/build_wheels.sh
packages=$("$here/environment.sh")
venv=$(mktemp -d "${TMPDIR:-/tmp}/clearance-python.XXXXXX")
trap 'rm -rf "$venv"' EXIT
"$packages/bin/python" -m venv --without-pip "$venv"
site=$("$venv/bin/python" -c 'import sysconfig; print(sysconfig.get_paths()["purelib"])')
"$packages/bin/python" -c 'import sysconfig; print(sysconfig.get_paths()["purelib"])' >"$site/packages.pth"
cp -r "$root/crates/python/python/clearance" "$site/"
cp "$CLEARANCE_PYTHON_LIBRARY" "$site/clearance/_clearance.abi3.so"
entry=$(sed -n 's/^clearance = "\(.*\)"$/\1/p' "$root/pyproject.toml")
printf '#!%s\nimport sys\nfrom %s import %s as main\nsys.exit(main())\n' \
    "$venv/bin/python" "${entry%:*}" "${entry#*:}" >"$venv/bin/clearance"
chmod +x "$venv/bin/clearance"

private_network=(unshare --net)
[ "$(id -u)" -eq 0 ] || private_network=(unshare -rn)
cd "$root"
"${private_network[@]}" bash -c 'ip link set lo up; ip link set lo multicast on; exec "$@"' bash \
    "$venv/bin/python" -B -m pytest -p no:cacheprovider -c "$here/pytest.ini" "$here" "$@"

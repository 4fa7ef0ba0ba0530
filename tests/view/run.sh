#!/usr/bin/env bash
# Tests the live view in a real headless browser: ./run.sh [arguments of node --test]
# CLEARANCE_BIN is the binary under test; without it, the release build of this repository.
# CLEARANCE_VIEW_PICTURE=FILE keeps a picture of the page: docs/view.png was made so.
# Node, browser and tests share one private network namespace, so nothing reaches the machine's network.
# Needs Node.js 20 or newer with npm, chromium, unshare and flock (util-linux), ip (iproute2), and what the tests with rclpy need:
# joint states come from there.
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
root=$(cd "$here/../.." && pwd)

die() { echo "view tests: $*" >&2; exit 1; }

export CLEARANCE_BIN="${CLEARANCE_BIN:-$root/target/release/clearance}"
[ -x "$CLEARANCE_BIN" ] || die "no binary at $CLEARANCE_BIN: cargo build --release, or set CLEARANCE_BIN"
for tool in node npm; do
    command -v "$tool" >/dev/null || die "needs $tool (Debian: apt-get install nodejs npm)"
done
CHROMIUM=$(command -v chromium || command -v chromium-browser || command -v google-chrome) \
    || die "needs chromium (Debian: apt-get install chromium)"
export CHROMIUM

# Two test runs at once wait for each other.
exec 9>"$here/.lock"
flock 9
"$root/view/build.sh" --check
if ! cmp -s "$here/package-lock.json" "$here/node_modules/.from-lock"; then
    (cd "$here" && npm ci --ignore-scripts --no-audit --no-fund --loglevel=error)
    cp "$here/package-lock.json" "$here/node_modules/.from-lock"
fi
flock --unlock 9

PYTHON="$("$root/tests/rclpy/environment.sh")/bin/python"
export PYTHON

for name in ${!ROS_*} ${!RMW_*} ${!FASTDDS_*} ${!FASTRTPS_*} AMENT_PREFIX_PATH CMAKE_PREFIX_PATH \
    LD_LIBRARY_PATH PYTHONPATH PYTHONHOME _ROS_WHEELS_BOOTSTRAP_COMPLETE; do
    unset "$name"
done
private_network=(unshare --net)
[ "$(id -u)" -eq 0 ] || private_network=(unshare -rn)
"${private_network[@]}" true \
    || die "no private network namespace: ${private_network[*]} is refused on this machine"

cd "$root"
exec "${private_network[@]}" bash -c \
    'ip link set lo up; ip link set lo multicast on; ip route add 224.0.0.0/4 dev lo; exec "$@"' bash \
    node --test --test-reporter=tap "$@" "$here/view.test.mjs"

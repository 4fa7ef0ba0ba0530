#!/usr/bin/env bash
# Measures the node: ./run.sh [--trial | --short | --long] [--binary PATH] [--rows NAMES] [--out FILE]; README.md says what.
# Without --out, a run with --long and neither --rows nor --robot writes docs/node_benchmarks.md, any other target/node_benchmarks.md.
# Without --binary, the release build of this repository is measured. Exit code 1: a row is missed.
# Everything runs in a private network namespace, with the real rclpy of tests/rclpy (CLEARANCE_ROS: kilted or jazzy).
# Needs what tests/rclpy needs: CPython with headers, g++, make, unshare, ip.
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
root=$(cd "$here/../.." && pwd)

# Only a whole long run takes the place of the results that are kept.
out="$root/target/node_benchmarks.md"
case " $* " in
    *" --rows"* | *" --robot"*) ;;
    *" --long "*) out="$root/docs/node_benchmarks.md" ;;
esac
mkdir -p "$root/target"

venv=$("$root/tests/rclpy/environment.sh")

# Whatever ROS the caller's shell is set up for must not decide what is measured.
for name in ${!ROS_*} ${!RMW_*} ${!FASTDDS_*} ${!FASTRTPS_*} AMENT_PREFIX_PATH CMAKE_PREFIX_PATH \
    LD_LIBRARY_PATH PYTHONPATH PYTHONHOME _ROS_WHEELS_BOOTSTRAP_COMPLETE; do
    unset "$name"
done

# A process namespace beside it, so that nothing that was started outlives this, however it ends.
private_network=(unshare --net --pid --fork --kill-child --mount-proc)
[ "$(id -u)" -eq 0 ] || private_network=(unshare -rn --pid --fork --kill-child --mount-proc)
"${private_network[@]}" true \
    || { echo "no private network namespace: ${private_network[*]} is refused on this machine" >&2; exit 2; }

exec "${private_network[@]}" bash -c \
    'ip link set lo up; ip link set lo multicast on; ip route add 224.0.0.0/4 dev lo; exec "$@"' bash \
    "$venv/bin/python" -B "$here/measure.py" --out "$out" "$@"  # of two --out the last counts

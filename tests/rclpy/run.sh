#!/usr/bin/env bash
# Runs the tests against real rclpy: ./run.sh [pytest arguments]
# CLEARANCE_BIN is the binary under test; without it, the release build of this repository.
# CLEARANCE_NETWORK=ethernet puts all of it on a pair of Ethernet interfaces instead of the loopback network; where the machine has none,
# the exit status is 77.
# CLEARANCE_ROS is the distribution whose rclpy speaks with it: kilted (the default) or jazzy.
# Node and tests share one private network namespace, so nothing reaches the machine's network.
# Needs, beside what environment.sh needs: unshare and flock (util-linux), ip (iproute2).
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
root=$(cd "$here/../.." && pwd)

export CLEARANCE_BIN="${CLEARANCE_BIN:-$root/target/release/clearance}"
[ -x "$CLEARANCE_BIN" ] || { echo "no binary at $CLEARANCE_BIN: cargo build --release, or set CLEARANCE_BIN" >&2; exit 1; }

venv=$("$here/environment.sh")

# Whatever ROS the caller's shell is set up for must not decide what the tests see.
for name in ${!ROS_*} ${!RMW_*} ${!FASTDDS_*} ${!FASTRTPS_*} AMENT_PREFIX_PATH CMAKE_PREFIX_PATH \
    LD_LIBRARY_PATH PYTHONPATH PYTHONHOME _ROS_WHEELS_BOOTSTRAP_COMPLETE; do
    unset "$name"
done

private_network=(unshare --net)
[ "$(id -u)" -eq 0 ] || private_network=(unshare -rn)
"${private_network[@]}" true \
    || { echo "no private network namespace: ${private_network[*]} is refused on this machine" >&2; exit 1; }

case "${CLEARANCE_NETWORK:-loopback}" in
    loopback)
        network='ip link set lo multicast on && ip route add 224.0.0.0/4 dev lo' ;;
    ethernet)
        # 192.0.2.0/24 is nobody's (RFC 5737), and the other end of the cable is free
        network='ip link add ethernet type veth peer name free_end || exit 77
            ip address add 192.0.2.1/24 dev ethernet && ip link set free_end up && ip link set ethernet up multicast on &&
            ip route add 224.0.0.0/4 dev ethernet' ;;
    *)
        echo "CLEARANCE_NETWORK is $CLEARANCE_NETWORK, but has to be loopback or ethernet" >&2; exit 1 ;;
esac

cd "$root"
exec "${private_network[@]}" bash -c 'ip link set lo up; eval "$1" || exit; exec "${@:2}"' bash "$network" \
    "$venv/bin/python" -B -m pytest -p no:cacheprovider -c "$here/pytest.ini" "$here" "$@"

#!/usr/bin/env bash
# Makes a Python environment with real rclpy (wheels from PyPI), clearance_msgs built from this repository and what of
# MoveIt's interfaces the node speaks, readers of MCAP and a Cyclone DDS, and prints its path. CLEARANCE_ROS is the
# distribution: kilted (the default) or jazzy. Nothing is installed outside the cache folder:
#   ${CLEARANCE_CACHE:-${XDG_CACHE_HOME:-~/.cache}/clearance}/rclpy-<hash of all that it is made from>
# Needs CPython 3.10 to 3.13 (for Jazzy: 3.11; without it, the exit status is 76) with its headers, g++ and make. The first run takes two minutes or three.
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
root=$(cd "$here/../.." && pwd)

# A sourced ROS installation, or the wheels of another environment, would mix with this one.
unset AMENT_PREFIX_PATH CMAKE_PREFIX_PATH LD_LIBRARY_PATH PYTHONPATH PYTHONHOME _ROS_WHEELS_BOOTSTRAP_COMPLETE

say() { echo "rclpy environment: $*" >&2; }
die() { say "$*"; exit 1; }

# What differs between the distributions: versions of rclpy, ament and its packages.
case "${CLEARANCE_ROS:=kilted}" in
    kilted)
        pythons="3.11 3.12 3.13 3.10" rclpy=9.1.2 ament=2.7.3 ament_package=0.17.2
        more_ament=ros-ament-cmake-ros-core
        ;;
    jazzy)
        pythons="3.11" rclpy=7.1.6 ament=2.5.4 ament_package=0.16.4
        more_ament=ros-python-cmake-module==0.11.1
        ;;
    *) die "CLEARANCE_ROS is '$CLEARANCE_ROS', but must be kilted or jazzy" ;;
esac

find_python() {
    local candidate version
    for candidate in $(printf "python%s " $pythons) python3; do
        version=$("$candidate" -c 'import sys; print("%d.%d" % sys.version_info[:2])' 2>/dev/null) || continue
        if [[ " $pythons " == *" $version "* ]]; then
            echo "$candidate"
            return
        fi
    done
    say "needs CPython ${pythons// /, }: there are no rclpy wheels of $CLEARANCE_ROS for others"
    exit 76
}

check_tools() {
    local tool
    for tool in g++ make; do
        command -v "$tool" >/dev/null || die "needs $tool (Debian: apt-get install g++ make)"
    done
    "$python" -c 'import os, sys, sysconfig; sys.exit(not os.path.exists(sysconfig.get_paths()["include"] + "/Python.h"))' \
        || die "needs Python.h of $("$python" --version) (Debian: apt-get install python3-dev)"
}

# The same inputs give the same folder wherever the repository lies.
hash_of_inputs() {
    {
        "$python" --version
        echo "$CLEARANCE_ROS"
        cd "$root"
        find tests/rclpy/{environment.sh,interface_packages.py,moveit_interfaces.txt} interfaces -type f -print0 | LC_ALL=C sort -z | xargs -0 sha256sum
    } | sha256sum | cut -c1-16
}

install_wheels() {
    "$python" -m venv "$venv"
    "$venv/bin/pip" install --quiet --disable-pip-version-check \
        "setuptools<80" numpy catkin_pkg cmake pytest pytest-timeout mcap==1.6.0 mcap-ros2-support==0.6.0 cyclonedds==11.0.1 \
        ros-rclpy==$rclpy ros-diagnostic-msgs ros-ament-package==$ament_package $more_ament \
        ros-ament-cmake-{core,python,libraries,include-directories,target-dependencies,test,gtest,gmock,pytest,version,gen-version-h}==$ament \
        ros-ament-cmake-export-{definitions,dependencies,include-directories,interfaces,libraries,link-flags,targets}==$ament \
        ros-$CLEARANCE_ROS-{rmw-fastrtps-cpp,ament-cmake,ament-cmake-ros,rosidl-core-generators,rosidl-default-generators} \
        ros-$CLEARANCE_ROS-{std,sensor,geometry,shape,trajectory,visualization,diagnostic}-msgs ros-$CLEARANCE_ROS-std-srvs
}

# The CMake exports of the wheels carry the paths of the machine that built them.
point_exports_at_this_python() {
    local python_include numpy_include
    python_include=$("$venv/bin/python" -c 'import sysconfig; print(sysconfig.get_paths()["include"])')
    numpy_include=$("$venv/bin/python" -c 'import numpy; print(numpy.get_include())')
    grep -rlE /opt/python/cp31 "$venv/share" --include='*.cmake' | xargs -r sed -i -E \
        -e "s#/opt/python/[^;\"]*/numpy/_?core/include#$numpy_include#g" \
        -e "s#/opt/python/[^;\"]*/include/python3\.[0-9]+#$python_include#g"
}

build_interfaces() {
    local source=$1 package build
    package=$(basename "$source")
    build="$venv/build/$package"
    (
        export PATH="$venv/bin:$PATH" AMENT_PREFIX_PATH="$venv" LD_LIBRARY_PATH="$venv/lib"
        cmake -S "$source" -B "$build" -DCMAKE_PREFIX_PATH="$venv" -DCMAKE_INSTALL_PREFIX="$venv" \
            -DPython3_EXECUTABLE="$venv/bin/python" -DCMAKE_BUILD_TYPE=None -DBUILD_TESTING=OFF
        cmake --build "$build" -j2
        cmake --install "$build"
    ) >"$venv/$package.log" 2>&1 || { tail -n 60 "$venv/$package.log" >&2; die "$package does not build"; }
    rm -rf "$build"
}

build_moveit_interfaces() {
    local package packages
    packages=$("$venv/bin/python" "$here/interface_packages.py" "$here/moveit_interfaces.txt" "$venv/build/sources")
    for package in $packages; do
        build_interfaces "$venv/build/sources/$package"
    done
}

python=$(find_python)
venv="${CLEARANCE_CACHE:-${XDG_CACHE_HOME:-$HOME/.cache}/clearance}/rclpy-$(hash_of_inputs)"
mkdir -p "$(dirname "$venv")"

# Two test runs at once wait for each other; the lock ends with this process.
exec 9>"$venv.lock"
flock 9

# The stamp is written last: a folder without it is what an interrupted build left behind.
if [ ! -e "$venv/.complete" ]; then
    check_tools
    say "building $venv"
    rm -rf "$venv"
    install_wheels
    point_exports_at_this_python
    build_interfaces "$root/interfaces/clearance_msgs"
    build_moveit_interfaces
    "$venv/bin/python" -c 'import rclpy; from clearance_msgs.msg import CollisionState; from clearance_msgs.srv import CheckMotion, CheckMotions, CheckStates, CheckTrajectory, GetDistances; from clearance_msgs.action import CheckTrajectory as Action'
    "$venv/bin/python" -c 'from moveit_msgs.msg import PlanningScene; from moveit_msgs.srv import GetStateValidity'
    touch "$venv/.complete"
    say "ready"
fi
echo "$venv"

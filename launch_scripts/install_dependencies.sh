#!/usr/bin/env bash
# Installs the Debian 12 packages that build, run and test omniflight. Says what is missing before it installs;
# does nothing when everything is there. Needs root or sudo only then.
# Example: ./launch_scripts/install_dependencies.sh          (everything)
#          ./launch_scripts/install_dependencies.sh --list   (print the packages)
#          ./launch_scripts/install_dependencies.sh --benchmarks   (also what benchmark.sh compares with)
#          ./launch_scripts/install_dependencies.sh --docs         (only what docs.sh needs)
#          ./launch_scripts/install_dependencies.sh --list-libraries   (print what a program that links the libraries needs)
set -euo pipefail

libraries=(
  cyclonedds-dev cyclonedds-tools libeigen3-dev liboctomap-dev libompl-dev libassimp-dev libboost-serialization-dev
  libboost-filesystem-dev libboost-system-dev liburdfdom-dev libyaml-cpp-dev libcli11-dev libfmt-dev
  libhwy-dev nlohmann-json3-dev libexpected-dev libceres-dev libblis-serial-dev libzstd-dev liblz4-dev libbz2-dev libsqlite3-dev
  zlib1g-dev libssl-dev libwebsockets-dev
)
packages=(
  # build
  g++ cmake ninja-build python3 python3-distutils colcon python3-colcon-metadata python3-colcon-defaults python3-colcon-output
  python3-colcon-notification python3-colcon-package-information python3-colcon-package-selection
  python3-colcon-parallel-executor python3-colcon-test-result python3-colcon-cmake python3-colcon-ros
  python3-colcon-recursive-crawl python3-colcon-library-path python3-colcon-bash
  "${libraries[@]}"
  # second plant, the one of the proof; without it omniflight_proof is left out and its tests skip
  libmujoco-dev
  # the Python package; without them omniflight_python is left out
  pybind11-dev python3-dev python3-numpy
  # reports and the live view: put into the pages at build time
  libjs-dygraphs libjs-katex libjs-three
  # tests; without Fast DDS the bus's test against a second vendor's DDS is left out
  libgtest-dev libfastrtps-dev
)
# peers of the benchmarks, used for nothing else
benchmark_packages=(
  libbenchmark-dev libnlopt-dev libdlib-dev r-cran-quadprog libfcl-dev libode-dev libbullet-dev libmujoco-dev
)
docs_packages=(git mkdocs mkdocs-material python3-yaml doxygen libjs-katex)
case "${1:-}" in
  --docs) packages=("${docs_packages[@]}") ;;
  --benchmarks) packages+=("${benchmark_packages[@]}") ;;
  --list-libraries) printf '%s\n' "${libraries[@]}"; exit 0 ;;
  --list) printf '%s\n' "${packages[@]}"; exit 0 ;;
  "") ;;
  *) sed -n '2,9p' "$0"; exit 4 ;;
esac

missing=()
for package in "${packages[@]}"; do
  if [ "$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null || true)" != installed ]; then
    missing+=("$package")
  fi
done
[ "${#missing[@]}" -gt 0 ] || exit 0
echo "installing with apt: ${missing[*]}"
sudo=()
if [ "$(id -u)" -ne 0 ]; then
  if ! command -v sudo >/dev/null; then
    echo "these packages are missing, and there is neither root nor sudo: ask an administrator to install them" >&2
    exit 4
  fi
  sudo=(sudo)
fi
export DEBIAN_FRONTEND=noninteractive
"${sudo[@]}" apt-get update -qq
"${sudo[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null

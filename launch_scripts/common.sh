# Sourced by the scripts beside it: where the workspace is, and which Python the build tools need.
set -euo pipefail
OMNIFLIGHT_ROOT="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
export OMNIFLIGHT_ROOT
cd "$OMNIFLIGHT_ROOT"
# colcon and the message generator need Debian's Python, not one that a version manager puts in front of it.
export PATH="/usr/bin:/bin:/usr/sbin:/sbin:${PATH}"
export PYTHONDONTWRITEBYTECODE=1
JOBS="${OMNIFLIGHT_JOBS:-$(nproc)}"
export JOBS

say() { printf '\n== %s\n' "$*"; }

omniflight_version() { sed -n 's/^project(.* VERSION \([0-9.]*\).*/\1/p' "$OMNIFLIGHT_ROOT/src/omniflight_cli/CMakeLists.txt"; }

# omniflight_build BASE [cmake arguments]: configures and builds the workspace into BASE/build and BASE/install;
# OMNIFLIGHT_COLCON_SELECT may select packages ("--packages-up-to a b"), OMNIFLIGHT_WITHOUT_CCACHE=yes builds as if there
# were none, OMNIFLIGHT_JOINED=yes joins sources all the same.
omniflight_build() {
  local base="$1"
  shift
  mkdir -p "$base"
  # with a compiler cache every source is its own object; from nothing, small ones are quicker several at a time
  local joined=ON speed=()
  if [ -z "${OMNIFLIGHT_WITHOUT_CCACHE:-}" ] && command -v ccache >/dev/null; then
    speed=(-DCMAKE_C_COMPILER_LAUNCHER=ccache -DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
    [ "${OMNIFLIGHT_JOINED:-}" = yes ] || joined=OFF
  fi
  local packages n=0 line
  packages="$(colcon --log-base /dev/null list --names-only --base-paths src ${OMNIFLIGHT_COLCON_SELECT:-} | wc -l)"
  # one package at a time, all processors inside it: memory stays bounded and nothing waits for a slot
  PYTHONUNBUFFERED=1 CMAKE_GENERATOR=Ninja CMAKE_BUILD_PARALLEL_LEVEL="$JOBS" MAKEFLAGS="-j$JOBS" \
    colcon --log-base "$base/log" build --metas "$OMNIFLIGHT_ROOT/colcon.meta" \
    --event-handlers console_direct- console_stderr- summary+ status- console_start_end+ \
    --base-paths src --build-base "$base/build" --install-base "$base/install" --executor sequential \
    ${OMNIFLIGHT_COLCON_SELECT:-} \
    --cmake-args -DCMAKE_BUILD_TYPE=Release -DOMNIFLIGHT_UNITY="$joined" "${speed[@]}" "$@" |
    while IFS= read -r line; do
      case "$line" in
        "Starting >>> "*) printf 'package %d of %d: %s\n' "$((++n))" "$packages" "${line#Starting >>> }" ;;
        *) printf '%s\n' "$line" ;;
      esac
    done
}

#!/usr/bin/env bash
# Builds the container image and runs the tests in it, with docker, podman or buildah, whichever works here.
# Options: --base IMAGE       base image (default: docker.io/library/debian:bookworm)
#          --engine NAME      docker | podman | buildah (default: the first that works)
#          --demo             run the demo in it as well
#          --build-timeout S  longest build [s] (default: 3600); --test-timeout S: longest run [s] (default: 3600)
# Example: ./launch_scripts/container_ci.sh --engine buildah --base localhost/debian:bookworm-local
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

usage() { sed -n '2,7s/^# \{0,1\}//p' "$0"; }
bad_input() { echo "container_ci.sh: $*" >&2; exit 4; }

image=localhost/omniflight-ci base="" engine="" demo=no build_timeout=3600 test_timeout=3600
while [ $# -gt 0 ]; do
  case "$1" in
    --base | --engine | --build-timeout | --test-timeout)
      [ $# -ge 2 ] || bad_input "$1 needs a value; see --help"
      case "$1" in
        --base) base="$2" ;;
        --engine) engine="$2" ;;
        --build-timeout) build_timeout="$2" ;;
        --test-timeout) test_timeout="$2" ;;
      esac
      shift 2 ;;
    --demo) demo=yes; shift ;;
    -h | --help) usage; exit 0 ;;
    *) bad_input "unknown option '$1'; see --help" ;;
  esac
done
for seconds in "$build_timeout" "$test_timeout"; do
  [[ "$seconds" =~ ^[1-9][0-9]{0,5}$ ]] || bad_input "'$seconds' is no timeout in whole seconds"
done

# An engine that is installed need not work: docker without its daemon, podman without its cgroups.
works() {
  command -v "$1" >/dev/null || return 1
  case "$1" in
    docker) timeout 20 docker info >/dev/null 2>&1 ;;
    podman) timeout 60 podman info >/dev/null 2>&1 ;;
    buildah) timeout 60 buildah images >/dev/null 2>&1 ;;
  esac
}
case "$engine" in
  "")
    for candidate in docker podman buildah; do
      if works "$candidate"; then engine="$candidate"; break; fi
    done
    [ -n "$engine" ] || bad_input "neither docker, podman nor buildah works here: install one (apt-get install buildah)" ;;
  docker | podman | buildah) works "$engine" || bad_input "$engine is not installed or does not answer" ;;
  *) bad_input "unknown engine '$engine': docker, podman or buildah" ;;
esac

build_args=(-f docker/Dockerfile -t "$image")
[ -z "$base" ] || build_args+=(--build-arg "BASE=$base")

container="" child=""
cleanup() {
  [ -z "$child" ] || kill "$child" 2>/dev/null || true
  [ -z "$container" ] || timeout 120 buildah rm "$container" >/dev/null || true
}
trap cleanup EXIT
trap 'exit 130' INT TERM

# bounded SECONDS command...: stops it after that time, and says so. In the background, so that Ctrl-C is heard.
bounded() {
  local seconds="$1" status=0
  shift
  timeout --kill-after=30 "$seconds" "$@" &
  child=$!
  wait "$child" || status=$?
  child=""
  if [ "$status" -eq 124 ] || [ "$status" -eq 137 ]; then echo "container_ci.sh: stopped after $seconds s: $*" >&2; fi
  return "$status"
}

build_image() {
  case "$engine" in
    docker) bounded "$build_timeout" docker build --network host "${build_args[@]}" . ;;
    podman) bounded "$build_timeout" podman build --network host "${build_args[@]}" . ;;
    # chroot isolation needs neither cgroups nor a daemon; layers, so that what is installed is installed once
    buildah) bounded "$build_timeout" buildah bud --layers --isolation chroot --network host "${build_args[@]}" . ;;
  esac
}

run_in_image() {
  case "$engine" in
    # the outer limit ends the client; the inner one ends what runs in the container
    docker | podman)
      bounded "$((test_timeout + 60))" "$engine" run --rm --network host "$image" timeout "$test_timeout" "$@" ;;
    buildah)
      container="$(timeout 300 buildah from "$image")"
      bounded "$test_timeout" buildah run --isolation chroot --network host "$container" -- "$@"
      timeout 120 buildah rm "$container" >/dev/null
      container="" ;;
  esac
}

echo "== building $image with $engine"
build_image
echo "== testing in $image"
run_in_image ./launch_scripts/test.sh
if [ "$demo" = yes ]; then
  echo "== demo in $image"
  run_in_image ./launch_scripts/demo.sh
fi

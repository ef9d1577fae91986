#!/usr/bin/env bash
# The first ten minutes of three users, each in a clean Debian 12 of its own that debootstrap makes: who installs the packages
# (try_packages.sh), who writes Python (try_python.sh), who links the libraries (try_cmake.sh). Tells the minutes of each step.
# Needs root and debootstrap, but no container engine; mounts are in a namespace of their own and end with it.
# Options: --packages FOLDER   made by package.sh (default: build/packages)
#          --roots FOLDER      keeps the roots there; one that has a base already is used again (default: temporary)
#          --mirror URL        of Debian (default: http://deb.debian.org/debian)
#          --only USER         packages | python | cmake
# Example: sudo ./launch_scripts/try_clean_roots.sh
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
packages="$PWD/build/packages" roots="" mirror=http://deb.debian.org/debian users=(packages python cmake)
while [ $# -gt 0 ]; do
  case "$1" in
    --packages) packages="$(realpath "${2:?--packages needs a folder}")"; shift 2 ;;
    --roots) roots="$(realpath -m "${2:?--roots needs a folder}")"; shift 2 ;;
    --mirror) mirror="${2:?--mirror needs an address}"; shift 2 ;;
    --only) users=("${2:?--only needs a user}"); shift 2 ;;
    *) sed -n '2,10p' "$0"; exit 4 ;;
  esac
done
fail() { echo "try_clean_roots.sh: $*" >&2; exit 4; }
[ "$(id -u)" -eq 0 ] || fail "needs root, for debootstrap and chroot"
for program in debootstrap ip; do
  command -v "$program" >/dev/null || fail "$program is missing: apt-get install debootstrap iproute2"
done
for name in omniflight libomniflight-dev python3-omniflight; do
  compgen -G "$packages/${name}_*.deb" >/dev/null || fail "$name is not in $packages: run ./launch_scripts/package.sh first"
done
if [ -z "$roots" ]; then
  roots="$(mktemp -d)"
  trap 'rm -rf --one-file-system "$roots"' EXIT
fi
mkdir -p "$roots"

# timed WHAT command...: runs it, its output into a log that is shown when it fails, and tells the minutes
timed() {
  local what="$1" begin=$SECONDS
  shift
  if ! "$@" >"$roots/log.txt" 2>&1; then
    tail -n 60 "$roots/log.txt" >&2
    fail "$what failed after $((SECONDS - begin)) s"
  fi
  printf '  %-34s %5.1f min\n' "$what" "$(awk -v s=$((SECONDS - begin)) 'BEGIN { print s / 60 }')"
}

# inside ROOT net|alone command...: in the root, with /proc, devices, shared memory and nothing of this system's environment;
# alone: with no network but a loopback of its own
inside() {
  local root="$1" alone=()
  [ "$2" = net ] || alone=(--net)
  shift 2
  # shellcheck disable=SC2016 # expanded by the inner shell
  unshare --mount --pid --fork --kill-child "${alone[@]}" bash -ec '
    ip link set lo up
    mount -t proc proc "$0/proc"
    mount --rbind /dev "$0/dev"
    mount --make-rslave "$0/dev"
    root="$0"
    exec chroot "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 DEBIAN_FRONTEND=noninteractive "$@"' "$root" "$@"
}

# install_in ROOT PACKAGE...: what is in /packages of the root, and these of Debian
install_in() {
  inside "$1" net sh -ec 'apt-get update -qq && apt-get install -y -qq --no-install-recommends /packages/*.deb "$@"' install "${@:2}"
}

if [ ! -f "$roots/base/complete" ]; then
  rm -rf --one-file-system "$roots/base"
  timed "a clean Debian 12" debootstrap --variant=minbase bookworm "$roots/base" "$mirror"
  touch "$roots/base/complete"
fi
for user in "${users[@]}"; do
  root="$roots/$user" extra=()
  case "$user" in
    packages | python) wanted=(omniflight python3-omniflight) ;;
    cmake) wanted=(omniflight libomniflight-dev) extra=(cmake make g++) ;;
    *) fail "unknown user '$user': packages, python or cmake" ;;
  esac
  # the site of docs.sh, where it has been made
  if [ "$user" = packages ] && compgen -G "$packages/omniflight-doc_*.deb" >/dev/null; then wanted+=(omniflight-doc); fi
  echo "$user:"
  rm -rf --one-file-system "$root"
  cp -a --reflink=auto "$roots/base" "$root"
  cp -L /etc/resolv.conf /etc/hosts "$root/etc/"
  mkdir -p "$root/packages"
  for name in "${wanted[@]}"; do cp "$packages/${name}_"*.deb "$root/packages/"; done
  cp "launch_scripts/try_$user.sh" "$root/packages/"
  timed "apt-get install" install_in "$root" "${extra[@]}"
  if [ "$user" != cmake ] && inside "$root" alone sh -c 'command -v g++ c++ gcc cc clang' >"$roots/compiler.txt"; then
    fail "the packages brought a compiler: $(head -n 1 "$roots/compiler.txt")"
  fi
  if [[ " ${wanted[*]} " == *" omniflight-doc "* ]] && [ ! -s "$root/usr/share/doc/omniflight-doc/html/index.html" ]; then
    fail "omniflight-doc has no first page"
  fi
  timed "try_$user.sh" inside "$root" alone "/packages/try_$user.sh"
  tail -n 1 "$roots/log.txt"
done

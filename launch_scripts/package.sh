#!/usr/bin/env bash
# Makes Debian packages of what is built: omniflight (command, components, configs, manual, completion), libomniflight-dev
# (headers, libraries, CMake), python3-omniflight, and omniflight-doc (the site of docs.sh, where it has been made).
# Options: --install FOLDER   what colcon installed (default: install/, made by build.sh)
#          --out FOLDER       where the packages go (default: build/packages)
# Example: ./launch_scripts/build.sh && ./launch_scripts/docs.sh && ./launch_scripts/package.sh
#          sudo apt-get install ./build/packages/*.deb
source "$(dirname "$0")/common.sh"
installed="$OMNIFLIGHT_ROOT/install" out="$OMNIFLIGHT_ROOT/build/packages"
while [ $# -gt 0 ]; do
  case "$1" in
    --install) installed="$(realpath "${2:?--install needs a folder}")"; shift 2 ;;
    --out) out="$(realpath -m "${2:?--out needs a folder}")"; shift 2 ;;
    *) sed -n '2,7p' "$0"; exit 4 ;;
  esac
done
command -v dpkg-shlibdeps >/dev/null || { echo "package.sh: dpkg-shlibdeps is missing: apt-get install dpkg-dev" >&2; exit 4; }
for package in omniflight_cli omniflight_components omniflight_cmake; do
  [ -d "$installed/$package" ] || { echo "package.sh: $package is not in $installed: run ./launch_scripts/build.sh first" >&2; exit 4; }
done
version="$(omniflight_version)"
architecture="$(dpkg --print-architecture)"
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
tools="$work/omniflight" dev="$work/libomniflight-dev" python="$work/python3-omniflight" doc="$work/omniflight-doc"

say "sorting what is in $installed"
mkdir -p "$tools/usr/bin" "$tools/usr/share/omniflight" "$dev/usr/include" "$dev/usr/lib" "$dev/usr/share/doc/libomniflight-dev" "$out"
for prefix in "$installed"/omniflight_*; do
  name="$(basename "$prefix")"
  [ ! -d "$prefix/bin" ] || cp -a "$prefix/bin/." "$tools/usr/bin/"
  [ ! -d "$prefix/include" ] || cp -a "$prefix/include/." "$dev/usr/include/"
  for library in "$prefix"/lib/*.a; do [ ! -f "$library" ] || cp -a "$library" "$dev/usr/lib/"; done
  mkdir -p "$dev/usr/share/$name"
  cp -a "$prefix/share/$name/package.xml" "$dev/usr/share/$name/"
  [ ! -d "$prefix/share/$name/cmake" ] || cp -a "$prefix/share/$name/cmake" "$dev/usr/share/$name/"
  if [ "$name" != omniflight_python ] && [ -d "$prefix/share/$name/examples" ]; then
    cp -a "$prefix/share/$name/examples" "$dev/usr/share/doc/libomniflight-dev/"
  fi
done
cp -a "$installed/omniflight_cmake/share/omniflight" "$dev/usr/share/"
cp -a configs "$tools/usr/share/omniflight/"
for folder in bash-completion zsh fish man; do
  [ ! -d "$installed/omniflight_cli/share/$folder" ] || cp -a "$installed/omniflight_cli/share/$folder" "$tools/usr/share/"
done
mkdir -p "$tools/usr/share/man"
[ ! -d "$tools/usr/share/man/man1" ] || gzip -9nf "$tools"/usr/share/man/man1/*.1
strip --strip-unneeded "$tools"/usr/bin/*
strip --strip-debug "$dev"/usr/lib/*.a

# depends_on FILE...: the Debian packages whose shared libraries these need
depends_on() {
  mkdir -p "$work/debian"
  printf 'Source: omniflight\n\nPackage: omniflight\nArchitecture: any\n' >"$work/debian/control"
  (cd "$work" && dpkg-shlibdeps -O "$@" 2>/dev/null) | sed -n 's/^shlibs:Depends=//p'
}

# build FOLDER ARCHITECTURE DEPENDS DESCRIPTION
build() {
  local folder="$1" name
  name="$(basename "$1")"
  mkdir -p "$folder/DEBIAN" "$folder/usr/share/doc/$name"
  cp LICENSE "$folder/usr/share/doc/$name/copyright"
  gzip -9nc CHANGELOG.md >"$folder/usr/share/doc/$name/changelog.gz"
  chmod -R u=rwX,go=rX "$folder"
  cat >"$folder/DEBIAN/control" <<CONTROL
Package: $name
Version: $version
Architecture: $2
Maintainer: $(sed -n 's/.*<maintainer email="\([^"]*\)">\([^<]*\)<.*/\2 <\1>/p' src/omniflight_cli/package.xml)
Section: science
Priority: optional
Installed-Size: $(du -sk "$folder/usr" | cut -f1)
Depends: $3
Description: $4
CONTROL
  dpkg-deb --root-owner-group -Zzstd --build "$folder" "$out/${name}_${version}_$2.deb" >/dev/null
  echo "$out/${name}_${version}_$2.deb: $(du -k "$out/${name}_${version}_$2.deb" | cut -f1) KiB"
}

say "packing"
build "$tools" "$architecture" "$(depends_on "$tools"/usr/bin/*)" "plan, fly, record multirotors, and find physics that simulation left out"
build "$dev" "$architecture" "omniflight (= $version), $(./launch_scripts/install_dependencies.sh --list-libraries | paste -sd, | sed 's/,/, /g')" \
  "headers and static libraries of omniflight, for CMake"
if [ -d "$installed/omniflight_python" ]; then
  mkdir -p "$python/usr/lib/python3/dist-packages" "$python/usr/share/doc/python3-omniflight"
  cp -a "$installed/omniflight_python/share/omniflight_python/examples" "$python/usr/share/doc/python3-omniflight/"
  cp -a "$installed"/omniflight_python/lib/python3*/site-packages/omniflight "$python/usr/lib/python3/dist-packages/"
  rm -rf "$python/usr/lib/python3/dist-packages/omniflight/__pycache__"
  strip --strip-unneeded "$python"/usr/lib/python3/dist-packages/omniflight/*.so
  minor="$(/usr/bin/python3 -c 'import sys; print(sys.version_info.minor)')"
  build "$python" "$architecture" "python3 (>= 3.$minor), python3 (<< 3.$((minor + 1))), python3-numpy, omniflight (= $version), \
$(depends_on "$python"/usr/lib/python3/dist-packages/omniflight/*.so)" "Python package of omniflight"
fi
if [ -d build/docs/site ]; then
  mkdir -p "$doc/usr/share/doc/omniflight-doc"
  cp -a build/docs/site "$doc/usr/share/doc/omniflight-doc/html"
  build "$doc" all "omniflight (>= $version)" "documentation of omniflight, as a site"
else
  echo "no omniflight-doc: run ./launch_scripts/docs.sh first"
fi

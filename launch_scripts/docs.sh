#!/usr/bin/env bash
# Makes the site of the documentation from the tracked pages, and the API pages of the public headers, in build/docs/site.
# A link to nothing fails, and so does a new warning of Doxygen.
# Options: --out FOLDER   another folder than build/docs
# Example: ./launch_scripts/docs.sh
source "$(dirname "$0")/common.sh"
base="$OMNIFLIGHT_ROOT/build/docs"
while [ $# -gt 0 ]; do
  case "$1" in
    --out) base="$(realpath -m "${2:?--out needs a folder}")"; shift 2 ;;
    *) sed -n '2,5p' "$0"; exit 4 ;;
  esac
done
# of Doxygen 1.9: one template that it does not match with its declaration, one <word> that it takes for HTML, four times
known_warnings=5
./launch_scripts/install_dependencies.sh --docs
mkdir -p "$base"
python3 docs/site/stage.py "$base"
{
  cat docs/site/Doxyfile
  echo "PROJECT_NUMBER = $(omniflight_version)"
  echo "OUTPUT_DIRECTORY = \"$base/pages\""
  echo "WARN_LOGFILE = \"$base/doxygen_warnings.txt\""
} >"$base/Doxyfile"
doxygen "$base/Doxyfile"
mkdocs build --quiet --strict --config-file "$base/mkdocs.yml"
warnings="$(grep -c 'warning:' "$base/doxygen_warnings.txt" || true)"
echo "$(find "$base/site" -name '*.html' -not -path '*/api/*' | wc -l) pages: $base/site/index.html"
echo "API pages: $base/site/api/index.html ($warnings warnings)"
if [ "$warnings" -gt "$known_warnings" ]; then
  cat "$base/doxygen_warnings.txt" >&2
  echo "docs.sh: Doxygen knows $known_warnings warnings, these are $warnings" >&2
  exit 1
fi

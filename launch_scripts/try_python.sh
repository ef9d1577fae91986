#!/usr/bin/env bash
# The first ten minutes with the package python3-omniflight: its examples, from reading a recording to a diagnosis, and a refusal
# that names what is wrong. Uses nothing of the checkout.
# Example: ./launch_scripts/try_python.sh
set -euo pipefail
[ $# -eq 0 ] || { sed -n '2,4p' "$0"; exit 4; }
examples=/usr/share/doc/python3-omniflight/examples
[ -d "$examples" ] || { echo "try_python.sh: python3-omniflight is not installed" >&2; exit 4; }
unset OMNIFLIGHT_CONFIGS PYTHONPATH
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
cd "$work"
count=0
for example in "$examples"/*.py; do
  printf '\n== %s\n' "$(basename "$example")"
  /usr/bin/python3 "$example"
  count=$((count + 1))
done
[ "$count" -ge 5 ]
/usr/bin/python3 - <<'PY'
import omniflight as of

try:
    of.load_vehicle("omnimorf")
except of.Error as error:
    assert "omnimorph" in str(error), error
    print("a misspelt vehicle:", error)
else:
    raise SystemExit("a misspelt vehicle was loaded")
PY
echo "the Python package works"

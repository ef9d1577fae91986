#!/usr/bin/env bash
# Makes docs/pictures/report.png, the README's picture, from the report of a demo. Needs chromium.
# Example: ./launch_scripts/demo.sh && docs/pictures/make_report_picture.sh runs/demo-*/diagnosis/report.html
set -euo pipefail
report="$(realpath "${1:?give the report.html of a demo}")"
picture="$(dirname "$(realpath "$0")")/report.png"
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
timeout 120 chromium --headless --no-sandbox --disable-gpu --disable-background-networking --hide-scrollbars \
  --user-data-dir="$work/profile" --virtual-time-budget=8000 --window-size=1280,1500 \
  --screenshot="$work/page.png" "file://$report" 2>"$work/log" || { cat "$work/log" >&2; exit 1; }
mv "$work/page.png" "$picture"
echo "$picture: $(stat -c %s "$picture") bytes"

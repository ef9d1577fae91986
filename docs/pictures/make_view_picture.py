#!/usr/bin/python3
"""Makes docs/pictures/view.png from a recording, as a browser shows it. Needs chromium and the built command.

Example: PATH=$PWD/install/omniflight_cli/bin:$PATH docs/pictures/make_view_picture.py runs/demo-*/tethered/flight.mcap 25
"""
import json
import os
import pathlib
import subprocess
import sys
import time
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
os.environ.update(OMNIFLIGHT_COMMAND="omniflight", OMNIFLIGHT_PROGRAMS="", OMNIFLIGHT_SOURCE_ROOT=str(ROOT))
sys.path.insert(0, str(ROOT / "src/omniflight_cli/test"))
from browser import Browser  # noqa: E402

if len(sys.argv) != 3:
    sys.exit(__doc__)
recording, at = sys.argv[1], float(sys.argv[2])
view = subprocess.Popen(["omniflight", "view", recording, "--port", "0", "--json", "--for-s", "120"], text=True,
                        stdout=subprocess.PIPE)
clean_up = unittest.TestCase()
try:
    text = ""
    while not text.endswith("}\n"):
        text += view.stdout.readline() or sys.exit("omniflight view ended: see above")
    browser = Browser(clean_up, webgl=True)
    browser.go(json.loads(text)["url"])
    browser.wait_for("window.omniflightView && omniflightView.frames")
    browser.value(f"omniflightView.seek({at})")
    time.sleep(9)  # the camera glides to the vehicle
    picture = ROOT / "docs/pictures/view.png"
    picture.write_bytes(browser.picture())
    print(f"{picture}: {picture.stat().st_size} bytes")
finally:
    view.terminate()
    clean_up.doCleanups()

"""A headless Chromium that tests drive over its DevTools protocol; skips where none is installed."""

import base64
import json
import pathlib
import shutil
import subprocess
import tempfile
import unittest

from system import wait_until
from tiny_websocket import WebSocket, fetch

PROGRAM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")


class Browser:
    def __init__(self, test, width=1280, height=800):
        if not PROGRAM:
            raise unittest.SkipTest("no browser: apt-get install chromium")
        profile = tempfile.TemporaryDirectory(prefix="omniflight_browser_", ignore_cleanup_errors=True)
        test.addCleanup(profile.cleanup)
        self.process = subprocess.Popen(
            [PROGRAM, "--headless=new", "--no-sandbox", "--disable-gpu-sandbox", "--use-angle=swiftshader",
             "--enable-unsafe-swiftshader", "--disable-background-networking", "--no-first-run", "--hide-scrollbars",
             "--disable-dev-shm-usage", "--remote-debugging-port=0", f"--user-data-dir={profile.name}", "about:blank"],
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        test.addCleanup(self.close)
        told = pathlib.Path(profile.name) / "DevToolsActivePort"
        port = int(wait_until("the browser", lambda: told.exists() and told.read_text().split("\n")[0], 60))
        pages = wait_until("a tab", lambda: [t for t in json.loads(fetch(port, "/json")[1]) if t["type"] == "page"], 30)
        self.socket = WebSocket(port, pages[0]["webSocketDebuggerUrl"].split(str(port), 1)[1], timeout=30)
        self.number, self.errors = 0, []
        for domain in ("Page", "Runtime", "Log"):
            self.call(domain + ".enable")
        self.size(width, height)

    def close(self):
        self.process.kill()
        self.process.wait(timeout=10)

    def call(self, method, **parameters):
        self.number += 1
        self.socket.send_json({"id": self.number, "method": method, "params": parameters})
        while True:
            answer = json.loads(self.socket.receive(60))
            if answer.get("method") == "Runtime.exceptionThrown":
                self.errors.append(answer["params"]["exceptionDetails"])
            if answer.get("method") == "Log.entryAdded" and answer["params"]["entry"]["level"] == "error":
                self.errors.append(answer["params"]["entry"])
            if answer.get("id") == self.number:
                if "error" in answer:
                    raise AssertionError(answer["error"])
                return answer["result"]

    def size(self, width, height, phone=False):
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=phone)

    def go(self, url):
        self.call("Page.navigate", url=url)

    def value(self, expression):
        """Of a JavaScript expression; None for undefined."""
        return self.call("Runtime.evaluate", expression=expression, returnByValue=True)["result"].get("value")

    def wait_for(self, expression, timeout=30):
        return wait_until(expression, lambda: self.value(f"(() => {{ try {{ return {expression}; }} catch (e) "
                                                         "{ return null; } })()"), timeout)

    def picture(self):
        return base64.b64decode(self.call("Page.captureScreenshot", format="png")["data"])

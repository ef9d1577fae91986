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
    def __init__(self, test, width=1280, height=800, webgl=False):
        """Without webgl pages are painted by the processor alone: the first frame that goes through an emulated graphics card takes
        up to 11 s of a busy machine, and the browser answers to no key before it is painted."""
        if not PROGRAM:
            raise unittest.SkipTest("no browser: apt-get install chromium")
        profile = tempfile.TemporaryDirectory(prefix="omniflight_browser_", ignore_cleanup_errors=True)
        test.addCleanup(profile.cleanup)
        self.process = subprocess.Popen(
            [PROGRAM, "--headless=new", "--no-sandbox",
             *(("--disable-gpu-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader") if webgl else ("--disable-gpu",)),
             "--disable-background-networking", "--no-first-run", "--hide-scrollbars",
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

    def wait_for(self, expression, timeout=120):
        return wait_until(expression, lambda: self.value(f"(() => {{ try {{ return {expression}; }} catch (e) "
                                                         "{ return null; } })()"), timeout)

    def picture(self):
        return base64.b64decode(self.call("Page.captureScreenshot", format="png")["data"])

    def press(self, key, code=0, text=None):
        """A key, down and up: "Tab" with its code 9, or a character with its text."""
        for kind in ("keyDown", "keyUp"):
            self.call("Input.dispatchKeyEvent", type=kind, key=key, windowsVirtualKeyCode=code, **({"text": text} if text and kind == "keyDown"
                                                                                                   else {}))

    def media(self, scheme="light", kind=""):
        """The reader's colour scheme, and "print" for paper."""
        self.call("Emulation.setEmulatedMedia", media=kind, features=[{"name": "prefers-color-scheme", "value": scheme}])

    def wider_than_the_screen(self):
        """Sentences: the page, or an element of it, is wider than the screen and does not scroll by itself."""
        return self.value(WIDE)

    def torn_words(self):
        """Sentences: labels of a table's cells that are too narrow for their words, and exponents that stand away from their number."""
        return self.value(TORN)

    def faint_texts(self):
        """Sentences: texts whose contrast with their ground is below 4.5 (3 where they are large), as WCAG 2.1 AA asks."""
        return self.value(FAINT)


def pages_on_paper(path):
    """Pages of a file as the browser prints it, by a process of its own: emulated media make a print wait for ever."""
    with tempfile.TemporaryDirectory(prefix="omniflight_print_", ignore_cleanup_errors=True) as folder:
        pdf = pathlib.Path(folder) / "page.pdf"
        subprocess.run([PROGRAM, "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run",
                        f"--user-data-dir={folder}/profile", f"--print-to-pdf={pdf}", path.as_uri()], check=True, timeout=120,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        document = pdf.read_bytes()
        return document.count(b"/Type /Page") - document.count(b"/Type /Pages")


WIDE = """(() => {
  const out = [], page = document.documentElement;
  if (page.scrollWidth > innerWidth) out.push(`the page is ${page.scrollWidth} wide on ${innerWidth}`);
  for (const e of document.querySelectorAll('main *, nav *')) {
    if (e.closest('.matrix .scroll, .equation, canvas, svg, .chart')) continue;
    const box = e.getBoundingClientRect(), style = getComputedStyle(e);
    if (box.width && box.right > innerWidth + 1) out.push(`${e.tagName} ${e.className} ends at ${Math.round(box.right)}`);
    if (/auto|scroll/.test(style.overflowX) && e.scrollWidth > e.clientWidth + 1) out.push(`${e.className} scrolls sideways`);
  }
  return out.slice(0, 8);
})()"""

TORN = """(() => {
  const out = new Set(), pen = document.createElement('canvas').getContext('2d');
  for (const td of document.querySelectorAll('.wide td[data-label]')) {
    const label = getComputedStyle(td, '::before');
    if (!td.getClientRects().length || label.content === 'none') continue;
    pen.font = `${label.fontWeight} ${label.fontSize} ${label.fontFamily}`;
    for (const word of td.dataset.label.split(/\\s+/))
      if (pen.measureText(word).width > parseFloat(label.width) + 1) out.add(`the label '${td.dataset.label}' breaks in '${word}'`);
  }
  for (const raised of document.querySelectorAll('td sup, td sub')) {
    if (!raised.getClientRects().length || !raised.previousSibling) continue;
    const range = document.createRange();
    range.selectNode(raised.previousSibling);
    const before = [...range.getClientRects()].pop(), box = raised.getBoundingClientRect();
    if (before && (Math.abs(box.left - before.right) > 3 || box.bottom < before.top || box.top > before.bottom))
      out.add(`${raised.parentElement.textContent}: '${raised.textContent}' stands away`);
  }
  return [...out].slice(0, 8);
})()"""

FAINT = """(() => {
  const numbers = c => {
    const n = c.match(/[-\\d.]+(e-?\\d+)?%?/g).map(Number);
    return c.startsWith('color(') ? [...n.slice(0, 3).map(v => 255 * v), n[3] ?? 1] : [...n.slice(0, 3), n[3] ?? 1];
  };
  const over = (a, b) => a.slice(0, 3).map((v, i) => a[3] * v + (1 - a[3]) * b[i]).concat(1);
  const light = c => {
    const [r, g, b] = c.map(v => (v /= 255) <= 0.03928 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4);
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const ground = e => {
    const layers = [];
    for (; e; e = e.parentElement) layers.unshift(numbers(getComputedStyle(e).backgroundColor));
    return layers.reduce((below, layer) => over(layer, below), [255, 255, 255, 1]);
  };
  const out = new Map(), walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walk.nextNode()) {
    const e = walk.currentNode.parentElement;
    if (!walk.currentNode.data.trim() || e.closest('script, style, noscript, .skip, title, [aria-pressed=false]') || !e.getClientRects().length) continue;
    const style = getComputedStyle(e), below = ground(e), size = parseFloat(style.fontSize);
    const ink = over(numbers(e.closest('svg') ? style.fill : style.color), below);
    const [a, b] = [light(ink.slice(0, 3)), light(below.slice(0, 3))].sort((x, y) => y - x), ratio = (a + 0.05) / (b + 0.05);
    const large = size >= 24 || (size >= 18.66 && style.fontWeight >= 700);
    if (ratio < (large ? 3 : 4.5)) out.set(`${e.tagName} ${e.getAttribute('class')}: ${ratio.toFixed(2)}`, e.textContent.trim().slice(0, 30));
  }
  return [...out].slice(0, 8).map(([where, text]) => `${where} '${text}'`);
})()"""

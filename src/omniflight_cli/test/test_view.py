"""`omniflight view`: the page of a recording and of a run, over its own protocol and in a real browser."""

import json
import os
import pathlib
import re
import shutil
import struct
import subprocess
import time
import unittest
import xml.etree.ElementTree as ET

import system
from browser import Browser
from tiny_websocket import Refused, WebSocket, fetch

NO_RESULT, BAD_INPUT = 2, 4
PAGE = "omniflight.view.v1"


class View(system.SystemTest):
    def view(self, *arguments):
        """Starts it; the port that it says."""
        process = self.start_command("view", *arguments, "--port", "0", "--json", "--for-s", "120")
        text = ""
        while not text.endswith("}\n"):
            line = process.stdout.readline()
            self.assertTrue(line, process.stderr.read() if process.poll() is not None else text)
            text += line
        return json.loads(text)["port"]

    def recorded(self):
        self.fly(self.short_mission(), "--in-process", "--sensors", "laboratory")
        return "flight/flight.mcap"


class Replay(View):
    def test_the_recording_is_served_to_this_machine_alone(self):
        port = self.view(self.recorded())
        status, scene = fetch(port, "/scene.json")
        scene = json.loads(scene)
        self.assertEqual((status, scene["schema"], scene["live"]), (200, "omniflight.view_scene/1", False))
        self.assertEqual(len(scene["vehicle"]["rotors"]), 8)
        replay = json.loads(fetch(port, "/replay.json")[1])
        flight = self.json("flight/flight.json")
        self.assertGreater(replay["t"][-1] - replay["t"][0], 4)
        self.assertAlmostEqual(replay["p"][2][-1] - replay["p"][2][0], 0.1, delta=0.01)
        self.assertLess(max(x for column in replay["load"] for x in column if x is not None), 1.0)
        self.assertEqual(flight["verdict"], "flown")
        self.assertEqual(fetch(port, "/", host="rebound.example")[0], 403)
        with self.assertRaises(Refused):
            WebSocket(port, protocol=PAGE, origin="https://evil.example")

    def test_what_cannot_be_shown_is_said(self):
        log = self.write("log.csv", "t_s,px_m,py_m,pz_m\n0,0,0,1\n1,0,0,1\n")
        done = self.run_command("view", log, "--port", "0", expect=BAD_INPUT)
        self.assertIn("--vehicle", done.stderr)
        self.write("empty.csv", "t_s,vbat_V\n0,16\n1,16\n")
        done = self.run_command("view", "empty.csv", "--vehicle", "omnimorph", "--port", "0", expect=BAD_INPUT)
        self.assertIn("position", done.stderr)
        port = self.view(log, "--vehicle", "omnimorph")
        done = self.run_command("view", log, "--vehicle", "omnimorph", "--port", port, expect=BAD_INPUT)
        self.assertIn("--port", done.stderr)

    def test_a_browser_shows_it(self):
        recording = self.recorded()
        browser = Browser(self, webgl=True)
        port = self.view(recording, "--mission", self.dir / "short.yaml")
        browser.go(f"http://127.0.0.1:{port}/")
        frames = browser.wait_for("window.omniflightView && omniflightView.frames")
        self.assertGreater(frames, 200)
        first = browser.value("document.getElementById('height').textContent")
        browser.value("omniflightView.seek(1e9)")
        last = browser.value("document.getElementById('height').textContent")
        self.assertAlmostEqual(float(last.split()[0]) - float(first.split()[0]), 0.1, delta=0.01)
        self.assertEqual(browser.value("document.querySelectorAll('.rotor').length"), 8)
        self.assertRegex(browser.value("document.querySelector('.rotor span').textContent"), r"^\d+ %$")
        self.assertTrue(browser.value("document.getElementById('stopbar').hidden"), "nothing flies")
        # three dimensions: something else than one colour
        colours = browser.value("""(() => { const c = document.createElement('canvas'); c.width = c.height = 64;
            const g = c.getContext('2d'); g.drawImage(document.getElementById('world'), 0, 0, 64, 64);
            return new Set(new Uint32Array(g.getImageData(0, 0, 64, 64).data.buffer)).size; })()""")
        self.assertGreater(colours, 20)
        browser.value("document.getElementById('play').click()")
        browser.wait_for("document.getElementById('play').textContent === 'pause' && "
                         "Number(document.getElementById('slider').value) > 5")
        self.phone(browser)
        self.assertEqual(browser.errors, [])

    def phone(self, browser):
        browser.size(390, 844, phone=True)
        browser.wait_for("innerWidth === 390")
        time.sleep(0.3)
        wide = browser.value("""[...document.querySelectorAll('body *')].filter((e) => e.getBoundingClientRect().right > 391)
            .map((e) => e.tagName + '#' + e.id + '.' + e.className)""")
        self.assertEqual(wide, [])
        self.assertLessEqual(browser.value("document.documentElement.scrollWidth"), 390)


class OnADomain(View):
    domain = str(110 + os.getpid() % 80)  # its own: a stop must not reach a run of somebody else

    def take_off(self):
        fly = self.start_command("fly", self.hovering_mission(), "--plant", "emulator", "--domain", self.domain, "--out", "flight")
        said = self.dir / "flight/log/gateway.log"
        system.wait_until("the gateway", lambda: said.exists() and "activated" in said.read_text(), 30)
        return fly


class Live(OnADomain):
    def test_a_page_follows_a_run_and_stops_its_rotors(self):
        fly = self.take_off()
        port = self.view("--mission", self.dir / "short.yaml", "--domain", self.domain)
        page = WebSocket(port, protocol=PAGE, origin=f"http://127.0.0.1:{port}")
        self.assertEqual(page.protocol, PAGE)
        path = json.loads(page.receive_until(lambda m: "path" in json.loads(m), 20))["path"]
        self.assertAlmostEqual(path[-1][2] - path[0][2], 0.1, delta=0.01)
        armed = json.loads(page.receive_until(lambda m: json.loads(m).get("gate", "").startswith("armed"), 20))
        self.assertEqual(len(armed["q"]), 4)
        page.send("arm them")  # no wish of a page
        page.send_json({"wish": "arm"})
        flying = json.loads(page.receive_until(lambda m: min(json.loads(m).get("load") or [0]) > 0.01, 20))
        self.assertEqual(len(flying["load"]), 8)
        begin = time.monotonic()
        page.send_json({"wish": "cut"})
        stopped = json.loads(page.receive_until(lambda m: json.loads(m).get("gate", "").startswith("stopped"), 10))
        print(f"\nstopped {1e3 * (time.monotonic() - begin):.0f} ms after the page's wish")
        self.assertIn("emergency_stop", stopped["gate"])
        output = fly.communicate(timeout=20)
        self.assertEqual(fly.returncode, NO_RESULT, output)
        self.assertIn("emergency_stop", self.json("flight/flight.json")["reason"])

    def test_a_browser_follows_a_run_and_stops_its_rotors(self):
        browser = Browser(self, 390, 844, webgl=True)
        port = self.view("--mission", "trajectory_1", "--domain", self.domain)
        browser.go(f"http://127.0.0.1:{port}/")
        browser.wait_for("document.getElementById('link').textContent === 'waiting for a flight'")
        fly = self.take_off()
        browser.wait_for("omniflightView.frames > 30", 40)
        browser.wait_for("document.getElementById('gate').textContent.startsWith('gate: armed')")
        browser.wait_for("document.getElementById('link').textContent === 'live'")
        browser.value("document.getElementById('stop').click()")
        browser.wait_for("document.getElementById('stopped').textContent.startsWith('Rotors stopped')", 10)
        output = fly.communicate(timeout=20)
        self.assertEqual(fly.returncode, NO_RESULT, output)
        self.assertEqual(browser.errors, [])


class Foxglove(OnADomain):
    """The protocol as github.com/foxglove/ws-protocol has it."""

    def test_topics_arrive_as_they_are_on_the_bus(self):
        mission = self.short_mission()
        port = self.view("--mission", mission, "--domain", self.domain)
        self.start_command("fly", mission, "--rate", "realtime", "--domain", self.domain, "--out", "flight", "--quiet")
        fox = WebSocket(port, protocol="foxglove.websocket.v1", origin=None)
        self.assertEqual(json.loads(fox.receive())["op"], "serverInfo")
        channels = {c["topic"]: c for c in json.loads(fox.receive())["channels"]}
        imu = channels["/omniflight/imu"]
        self.assertEqual((imu["encoding"], imu["schemaName"], imu["schemaEncoding"]), ("cdr", "sensor_msgs/msg/Imu", "ros2msg"))
        self.assertIn("geometry_msgs/Vector3 linear_acceleration", imu["schema"])
        wanted = {1: "/omniflight/imu", 2: "/view/transform", 3: "/view/vehicle", 4: "/view/world", 5: "/command_trajectory"}
        fox.send_json({"op": "subscribe", "subscriptions": [{"id": i, "channelId": channels[t]["id"]} for i, t in wanted.items()]})
        heard = {}
        deadline = time.monotonic() + 30
        while set(heard) != set(wanted) and time.monotonic() < deadline:
            message = fox.receive(20)
            if isinstance(message, bytes):
                opcode, subscription, ns = struct.unpack("<BIQ", message[:13])
                self.assertEqual(opcode, 1)
                heard[subscription] = (ns, message[13:])
        self.assertEqual(set(heard), set(wanted))
        ns, cdr = heard[1]
        self.assertEqual(cdr[:4], b"\0\1\0\0")  # little-endian CDR
        stamp = struct.unpack("<iI", cdr[4:12])
        self.assertEqual(ns, stamp[0] * 10**9 + stamp[1])
        self.assertEqual(json.loads(heard[2][1])["child_frame_id"], "body")
        self.assertEqual(len(json.loads(heard[3][1])["entities"][0]["cylinders"]), 16)
        self.assertGreater(len(json.loads(heard[4][1])["entities"][0]["cylinders"]), 3)
        fox.send_json({"op": "publish"})
        self.assertEqual(json.loads(fox.receive_until(lambda m: isinstance(m, str)))["op"], "status")
        with self.assertRaises(Refused):
            WebSocket(port, protocol="foxglove.websocket.v1", origin="https://evil.example")

    def test_foxgloves_own_client_decodes_every_topic(self):
        """The npm packages of Foxglove: their client, and their reader of ROS 2 messages."""
        modules = pathlib.Path(os.environ.get("OMNIFLIGHT_NODE_MODULES", ""))
        if not shutil.which("node") or not (modules / "@foxglove/ws-protocol").exists():
            self.skipTest("OMNIFLIGHT_NODE_MODULES names no folder with @foxglove/ws-protocol, @foxglove/rosmsg, "
                          "@foxglove/rosmsg2-serialization and ws")
        mission = self.short_mission()
        port = self.view("--mission", mission, "--domain", self.domain)
        self.start_command("fly", mission, "--rate", "realtime", "--domain", self.domain, "--out", "flight", "--quiet")
        topics = ["/omniflight/imu", "/omniflight/rotors", "/omniflight/truth", "/command_trajectory", "/view/transform",
                  "/view/vehicle", "/view/world"]
        done = subprocess.run(["node", system.ROOT / "src/omniflight_cli/test/check_foxglove.mjs", str(port), "40", *topics],
                              capture_output=True, text=True, timeout=60, check=False)
        print("\n" + done.stdout)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertGreater(json.loads(done.stdout)["/omniflight/imu"], 0)


class Layouts(unittest.TestCase):
    """The shipped layouts name topics and fields that there are."""

    def fields(self):
        """{topic: names of its fields}, of our own messages."""
        header = (system.ROOT / "src/omniflight_components/include/omniflight_components/topics.hpp").read_text()
        names = dict(re.findall(r'(\w+) =\s+"(/[^"]+)"', header))
        types = re.findall(r'\{(\w+), "omniflight_msgs/msg/(\w+)"', header)
        folder = system.ROOT / "src/omniflight_msgs/msg/omniflight_msgs"
        return {names[variable]: set(re.findall(r"^[\w/\[\]]+ (\w+)$", (folder / f"{kind}.msg").read_text(), re.M))
                for variable, kind in types}

    def check(self, paths):
        fields, checked = self.fields(), 0
        for topic, field in paths:
            if topic in fields:
                self.assertIn(field, fields[topic], topic)
                checked += 1
        self.assertGreater(checked, 10)

    def test_foxglove(self):
        text = (system.CONFIGS / "layouts/foxglove.json").read_text()
        layout = json.loads(text)
        shown = set(re.findall(r'"((?:\w+)!\w+)"', json.dumps(layout["layout"])))
        self.assertEqual(shown, set(layout["configById"]))
        self.check(re.findall(r'"(/omniflight/\w+)\.(\w+)', text))

    def test_plotjuggler(self):
        curves = [c.get("name") for c in ET.parse(system.CONFIGS / "layouts/plotjuggler.xml").iter("curve")]
        self.check([c.split("[")[0].rsplit("/", 1) for c in curves])

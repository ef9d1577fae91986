"""A flight through emulated boards that a test ends somehow, with what the boards received in a log."""

import os
import time

import system

NATNET = """schema: omniflight.natnet/1
server: 127.0.0.1
interface: 127.0.0.1
multicast: 239.255.42.{group}
data_port: {data}
command_port: {command}
version: auto
up_axis: {up}
unit: {unit}
bodies:
  - {{name: OmniMorph, topic: /omniflight/mocap}}
"""


class BoardFlight(system.SystemTest):
    def take_off(self, out="flight", parameters=(), mission=None, **options):
        """A flight through emulated boards that flies freely, of the short mission or another: (process, {component: pid})."""
        self.log = self.dir / "line.txt"
        fly = self.start_command("fly", mission or self.short_mission(), "--plant", "emulator", "--sensors", "laboratory", "--out", out,
                                 "-p", f"emulator.line_log={self.log}", *parameters, **options)
        try:
            # 2 s of the gateway's hold after the first command
            system.wait_until("commands on the line",
                              lambda: self.log.exists() and self.log.stat().st_size > 20_000 or fly.poll() is not None, 30)
        except AssertionError as late:
            fly.terminate()
            said = "".join(fly.communicate(timeout=20))
            logs = "".join(f"\n{log.name}: {log.read_text()[-2000:]}" for log in sorted((self.dir / out / "log").glob("*.log")))
            raise AssertionError(f"{late}; the flight said: {said}{logs}") from None
        time.sleep(2.5)
        if fly.poll() is not None:
            self.fail("the flight ended early: " + "".join(fly.communicate()))
        return fly, system.children(fly.pid)

    def natnet_config(self, **values):
        """File of a motion capture that only this test hears."""
        port = 20000 + os.getpid() % 10000 * 4
        return self.write("natnet.yaml", NATNET.format(**({"group": 1 + os.getpid() % 200, "data": port, "command": port + 1,
                                                           "up": "y", "unit": "mm"} | values)))

"""The page that `fly` writes beside a recording says how the flight ended, and what to do with it."""

import html

import system

NO_RESULT = 2


class FlightPage(system.SystemTest):
    def page(self, *arguments, expect=0):
        self.run_command("fly", self.short_mission(), "--in-process", "--sensors", "laboratory", "--out", "flight", "--quiet",
                         *arguments, expect=expect)
        return html.unescape((self.dir / "flight/report.html").read_text())

    def test_a_flown_flight(self):
        page = self.page("--effects", system.CONFIGS / "effects/tether.yaml")
        flight = self.json("flight/flight.json")
        for words in ("Flown to the end, within its bounds", "Flight path", "Position error, flight", "rotor 8",
                      "Rotors: thrust against its limit", "Power, mechanical", "Tilt of the rotors",
                      "physics that the controller did not know", "omniflight diagnose flight/flight.mcap --vehicle omnimorph"):
            self.assertIn(words, page)
        self.assertIn(f"{flight['metrics']['power_W']:.1f}", page)
        events = page[page.index(">Events</h2>"):page.index("What else the recording says of itself")]
        self.assertNotIn("has no known signal", events, "topics that nothing reads are no events")

    def test_a_lost_flight_says_why(self):
        page = self.page("--faults", "rotor_loss", "-p", "allocator.drop_lost_rotors=false", expect=NO_RESULT)
        flight = self.json("flight/flight.json")
        self.assertNotEqual(flight["verdict"], "flown")
        self.assertNotIn("Flown to the end, within its bounds", page)
        self.assertIn(flight["reason"], page)

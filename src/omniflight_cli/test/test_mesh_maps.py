"""A mission among a triangle mesh: planned, certified against its voxels, verified again; what is no mesh is refused."""

import struct
import unittest

import system


def box(low, high):
    """The twelve triangles of an axis-aligned box."""
    corners = [[(low, high)[i >> k & 1][k] for k in range(3)] for i in range(8)]
    faces = ((0, 2, 1), (1, 2, 3), (4, 5, 6), (5, 7, 6), (0, 1, 4), (1, 5, 4), (2, 6, 3), (3, 6, 7), (0, 4, 2),
             (2, 4, 6), (1, 3, 5), (3, 7, 5))
    return [[corners[i] for i in face] for face in faces]


def stl(triangles):
    out = b"\0" * 80 + struct.pack("<I", len(triangles))
    for corners in triangles:
        out += struct.pack("<3f", 0, 0, 0) + b"".join(struct.pack("<3f", *p) for p in corners) + b"\0\0"
    return out


# a hall of 6 m x 4 m x 3 m with a pillar in its middle
HALL = (box((-3.1, -2.1, -0.1), (3.1, 2.1, 0)) + box((-3.1, -2.1, 3), (3.1, 2.1, 3.1)) +
        box((-3.1, -2.1, 0), (-3, 2.1, 3)) + box((3, -2.1, 0), (3.1, 2.1, 3)) +
        box((-3, -2.1, 0), (3, -2, 3)) + box((-3, 2, 0), (3, 2.1, 3)) + box((-0.3, -0.6, 0), (0.3, 0.6, 3)))

MISSION = """schema: omniflight.mission/1
name: hall
vehicle: omnimorph
test_bed: hall.stl
alpha_deg: 48
clearance_m: 0.05
budget_ms: 50000
start: {position: [-1.8, 0, 1.5]}
waypoints:
  - {position: [1.8, 0, 1.5]}
"""


class MeshMaps(system.SystemTest):
    def setUp(self):
        super().setUp()
        (self.dir / "hall.stl").write_bytes(stl(HALL))
        self.mission = self.write("hall.yaml", MISSION)

    def test_a_plan_leads_round_the_pillar_and_is_verified(self):
        self.run_command("plan", self.mission, "--out", "plan", "--threads", 2)
        certificate = self.json("plan/certificate.json")
        self.assertEqual(certificate["verdict"], "certified")
        self.assertEqual(certificate["threads"], 2)
        self.assertTrue(certificate["map"]["file"].endswith("hall.stl"))
        knots = self.json("plan/trajectory.json")["knots"]
        self.assertGreater(max(abs(k["p"][1]) for k in knots if abs(k["p"][0]) < 0.3), 0.65)
        done = self.run_command("plan", "verify", "plan")
        self.assertIn("verified", done.stdout)
        # another mesh under the same name is another map
        (self.dir / "hall.stl").write_bytes(stl(HALL[:-12]))
        self.assertIn("has changed", self.run_command("plan", "verify", "plan", expect=2).stderr)

    def test_hostile_meshes_are_refused_with_the_reason(self):
        good = stl(HALL)
        for bytes_, word in ((good[:-1], "84 + 50 a triangle"), (b"solid x\nfacet", "is due"),
                             (stl([[[1e4 * x for x in p] for p in t] for t in HALL]), "--scale"),
                             (good[:100] + struct.pack("<f", float("nan")) + good[104:], "not finite")):
            (self.dir / "hall.stl").write_bytes(bytes_)
            done = self.run_command("plan", self.mission, "--out", "refused", expect=4)
            self.assertIn(word, done.stderr)
            self.assertIn("hall.stl", done.stderr)
        self.assertFalse((self.dir / "refused").exists())


if __name__ == "__main__":
    unittest.main()

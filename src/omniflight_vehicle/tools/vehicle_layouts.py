#!/usr/bin/env python3
"""Prints mass, inertia, centre of mass and rotors of vehicles whose figures are computed from published ones.

Example: ./vehicle_layouts.py lynchpin        the lines of configs/vehicles/lynchpin/lynchpin.yaml
         ./vehicle_layouts.py --list
         ./seven_rotor_design.py              the search behind o7_plus

The sources of the numbers below stand under `provenance` in the YAML of each vehicle.
"""

import sys

import numpy as np


def rotation(axis, angle):
    """3 x 3, by `angle` [rad] about "x", "y" or "z"."""
    c, s = np.cos(angle), np.sin(angle)
    i, j = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    out = np.eye(3)
    out[i, i] = out[j, j] = c
    out[i, j], out[j, i] = -s, s
    return out


def from_rpy(roll, pitch, yaw):
    return rotation("z", yaw) @ rotation("y", pitch) @ rotation("x", roll)


def symmetric(xx, yy, zz, xy=0.0, xz=0.0, yz=0.0):
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def composed(parts):
    """Mass [kg], centre of mass [m] and inertia about it [kg m2] of (mass, centre, inertia about the centre)."""
    mass = sum(m for m, _, _ in parts)
    centre = sum(m * np.asarray(c, float) for m, c, _ in parts) / mass
    inertia = np.zeros((3, 3))
    for m, c, own in parts:
        r = np.asarray(c, float) - centre
        inertia += own + m * (r @ r * np.eye(3) - np.outer(r, r))
    return mass, centre, inertia


class Propeller:
    def __init__(self, coefficient, drag_ratio, max_thrust, radius, time_constant, min_thrust=0.0, both_ways=False):
        self.coefficient, self.drag_ratio, self.max_thrust = coefficient, drag_ratio, max_thrust
        self.radius, self.time_constant, self.min_thrust, self.both_ways = radius, time_constant, min_thrust, both_ways


# what other vehicles of configs/vehicles fly with
OMNICOPTER = Propeller(2.50972e-05, 0.06, 30.3676, 0.127, 0.0125, both_ways=True)
OMAV = Propeller(7.2e-06, 0.015, 20.808, 0.1143, 0.0125)


def number(x, digits=6):
    text = f"{x:.{digits}g}"
    return "0" if float(text) == 0 or abs(x) < 1e-9 else text


def vector(v, digits=6):
    return "[" + ", ".join(number(x, digits) for x in v) + "]"


def rotor_line(position, axis, spin, propeller, tilt_axis=None, board=0):
    p = propeller
    return (f"  - {{position: {vector(position)}, axis: {vector(axis)}, "
            f"tilt_axis: {'null' if tilt_axis is None else vector(tilt_axis)}, spin: {spin:+d}, "
            f"thrust_coefficient: {number(p.coefficient)}, drag_ratio: {number(p.drag_ratio)}, "
            f"bidirectional: {'true' if p.both_ways else 'false'}, min_thrust: {number(p.min_thrust)}, "
            f"max_thrust: {number(p.max_thrust)}, radius: {number(p.radius)}, "
            f"time_constant: {number(p.time_constant)}, board: {board}}}")


def lines_of(body, rotors):
    mass, centre, J = body
    six = [J[0, 0], J[1, 1], J[2, 2], J[0, 1], J[0, 2], J[1, 2]]
    return [f"mass: {number(mass)}", f"inertia: {vector(six)}", f"center_of_mass: {vector(centre)}", "rotors:"] + rotors


def lynchpin():
    """Gazebo's model: joint poses, masses, and blades as two lifting surfaces each (lift-drag system)."""
    commanded, density, area, arm = 0.5 * 2762, 1.2041, 0.003, 0.05
    lift, drag = 4.25 * 0.3, 0.10 * 0.3  # slope times zero-lift angle
    coefficient = 2 * 0.5 * density * area * lift * arm**2
    # the velocity loop of the joint gives 2.5 Nm at most, which friction of 0.002 Nm s and drag take
    torque = 2 * 0.5 * density * area * drag * arm**3
    speed = min(commanded, (-0.002 + np.sqrt(0.002**2 + 4 * torque * 2.5)) / (2 * torque))
    propeller = Propeller(coefficient, drag * arm / lift, coefficient * speed**2, arm, 0.0125, both_ways=True)
    third = 2 * np.pi / 3
    joints = [([0.10147914, 0, -0.06590132], (0, 0.57595865, 0), +1),
              ([-0.05073957, -0.08788351, -0.06590132], (0, 0.57595865, -third), +1),
              ([-0.05073957, 0.08788351, -0.06590132], (0, 0.57595865, third), -1),
              ([0.04894553, -0.08477614, 0.07112202], (np.pi / 2, 0, third), -1),
              ([-0.09789106, 0, 0.07112202], (-np.pi / 2, 0, 0), +1),
              ([0.04894553, 0.08477614, 0.07112202], (-np.pi / 2, 0, -third), -1)]
    parts = [(1.5, [0, 0, 0], 0.009375 * np.eye(3)), (0.15, [0, 0, 0], 2e-5 * np.eye(3))]
    rotors = []
    for place, rpy, spin in joints:
        R = from_rpy(*rpy)
        parts.append((0.025, place, R @ np.diag([9.75e-6, 0.000166704, 0.000167604]) @ R.T))
        rotors.append(rotor_line(np.asarray(place) + 0.018 * R[:, 2], R[:, 2], spin, propeller))
    return lines_of(composed(parts), rotors)


def odar():
    """Two crosses at the ends of a beam; the axes of the second are those of the first, its hubs opposite."""
    mass, beam, arm, turns = 2.6, 0.4, 0.24 * np.sqrt(0.5), [-1, 1, 1, 1]
    hubs = [[beam, -arm, arm], [beam, arm, arm], [beam, -arm, -arm], [beam, arm, -arm]]
    axes = [[0.68, 0.28, 0.68], [0.68, 0.28, -0.68], [0.68, -0.28, 0.68], [0.68, -0.28, -0.68]]
    forward_left_up = np.array([1, -1, -1])  # from forward, right, down
    rotors = []
    for side in (1, -1):
        for hub, axis, turn in zip(hubs, axes, turns):
            n = forward_left_up * axis / np.linalg.norm(axis)
            rotors.append(rotor_line(side * forward_left_up * hub, n, side * turn, OMNICOPTER, board=(1 - side) // 2))
    around, along = 0.5 * mass * 0.24**2, mass * (3 * 0.24**2 + (2 * beam)**2) / 12  # solid cylinder
    return lines_of((mass, np.zeros(3), np.diag([around, along, along])), rotors)


PRISMA = Propeller(9.84e-06, 0.09, 9.84e-06 * 1100**2, 0.128, 0.0125)


def prisma(hubs, tilt_axis_of, arms):
    """A body, arms in its origin and rotors, as the SDF files have them. hubs: place, spin."""
    parts = [(2.260803677220633, [0, 0, 0], symmetric(0.088329, 0.101628, 0.104362, 0.000113, -2.4e-05, 0.7e-06)),
             (0.015, [0, 0, 0], 1e-5 * np.eye(3))]
    parts += [(0.4031180930624021, [0, 0, 0], R @ np.diag([0.001829, 0.000448, 0.001461]) @ R.T) for R in arms]
    rotors = []
    for place, spin in hubs:
        # the blades turn: the mean of their two cross moments
        parts.append((0.005, place, np.diag([0.5 * (9.75e-07 + 0.000273104)] * 2 + [0.000274004])))
        rotors.append(rotor_line(place, [0, 0, 1], spin, PRISMA, tilt_axis=tilt_axis_of(place)))
    return lines_of(composed(parts), rotors)


def coaxial_fam():
    hubs = []
    for x, y, top, spin in [(0.32, -0.36, 0.11, -1), (0.327, 0.35, 0.115, +1), (-0.32, 0.357, 0.115, -1),
                            (-0.328, -0.35, 0.115, +1)]:
        hubs += [([x, y, top], spin), ([x, y, -0.035], -spin)]

    def tilt_axis(place):  # out along the arm, and in, in turn
        out = np.array([np.sign(place[0]), np.sign(place[1]), 0.0]) / np.sqrt(2)
        return out if place[0] * place[1] > 0 else -out

    return prisma(hubs, tilt_axis, [rotation("z", yaw) for yaw in (0, 1.5, 3.1415, 4.64)])


def tiltable_airframe():
    hubs = []
    for x, y, spin in [(0.185, -0.18, -1), (0.185, 0.18, +1), (-0.185, 0.18, -1), (-0.185, -0.18, +1)]:
        hubs += [([x, y, 0.0135], spin), ([x, y, -0.0685], -spin)]
    return prisma(hubs, lambda place: [0, 1, 0], [rotation("z", yaw) for yaw in (0, np.pi)])


DRAGON_FAN = Propeller(15 / 4200**2, 0.01, 15.0, 0.035, 0.03, min_thrust=1.0)


def dragon():
    """Four links in a square, each with two fans on a gimbal that turns about the link's lateral axis."""
    length, joint, lift = 0.424, 0.02575, 0.037
    gimbal = np.array([length / 2, 0, 0])
    # head, with flight controller, general, end: mass, centre from the middle of the link [mm], inertia
    links = [(0.7968, (15.09, -6.67, -27.21), symmetric(0.00095, 0.0151, 0.0148, -0.00098, 0.0003, 0.0001)),
             (1.1348, (9.54, -4.74, -15.68), symmetric(0.0018, 0.0228, 0.0219, -0.0009, -0.0006, 0.0001)),
             (0.9289, (-12.78, -5.80, -16.95), symmetric(0.0015, 0.0198, 0.0189, -0.0008, -0.0001, 0.0001)),
             (0.7943, (-44.26, -0.11, -20.72), symmetric(0.0012, 0.0145, 0.0134, 0, 0.0003, 0))]
    parts, fans, origin = [], [], np.zeros(3)
    for k, (mass, centre, inertia) in enumerate(links):
        R = rotation("z", k * np.pi / 2)
        for m, place, own in [
                (mass, gimbal + 1e-3 * np.array(centre), inertia),
                (0.4604, gimbal + [-0.01 - 0.0176, 0.00042, 0.01548], symmetric(0.0004, 0.0004, 0.0003, 0, -0.0003)),
                (0.5301, gimbal + [0, 0.00033, lift - 0.00871], symmetric(0.0061, 0.0001, 0.0061))]:
            parts.append((m, origin + R @ place, R @ own @ R.T))
        if k < 3:
            parts.append((0.1329, origin + R @ [length + joint + 0.00343, -0.00427, -0.00155], 1e-4 * np.eye(3)))
        for side in (1, -1):  # the tilt axes of every second link are turned over: thrusts at one tilt lean against one another
            tilt_axis = R @ [0, 1 if k % 2 == 0 else -1, 0]
            fans.append((origin + R @ (gimbal + [0, side * 0.1115, lift]), side, tilt_axis, k))
        origin = origin + R @ [length + 2 * joint, 0, 0]
    middle = np.mean([place for place, _, _, _ in fans], axis=0) * [1, 1, 0]
    rotors = [rotor_line(place - middle, [0, 0, 1], side, DRAGON_FAN, tilt_axis=axis, board=k) for place, side, axis, k in fans]
    return lines_of(composed([(m, place - middle, own) for m, place, own in parts]), rotors)


VEHICLES = {f.__name__: f for f in (lynchpin, odar, coaxial_fam, tiltable_airframe, dragon)}


def main():
    if sys.argv[1:] == ["--list"]:
        print("\n".join(VEHICLES))
    elif len(sys.argv) == 2 and sys.argv[1] in VEHICLES:
        print("\n".join(VEHICLES[sys.argv[1]]()))
    else:
        sys.exit(__doc__)


if __name__ == "__main__":
    main()

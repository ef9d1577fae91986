#!/usr/bin/env python3
"""Searches a layout of seven rotors that turn one way and still give force and torque in every direction.

Example: ./seven_rotor_design.py --starts 200     prints the best layout as lines of a vehicle file
         ./seven_rotor_design.py --check FILE     tells how the rotors of a vehicle file fulfil the criterion

Criterion (Tognon and Franchi, Omnidirectional Aerial Vehicles With Unidirectional Thrusters, RA-L 3(3), 2018):
seven rotors are the fewest; the design is balanced, so that equal thrusts give no wrench (then any wrench is
reached by adding equal thrusts until all are positive); and the condition number of the allocation matrix is
least. Torques are divided by the length that makes their mean square that of the forces. Hubs lie on a sphere and
leave room for their discs. The search is Levenberg-Marquardt from random layouts; what it finds is a local optimum.
"""

import argparse
import json
import re
import sys

import numpy as np

from vehicle_layouts import OMAV, rotor_line

ROTORS = 7
RADIUS = 0.3  # m, of the sphere of hubs: omav's arm
SPIN = np.array([1, 1, 1, 1, -1, -1, -1])
ROOM = 2.2 * OMAV.radius  # m, least distance of two hubs
PAIRS = np.triu_indices(ROTORS, 1)
UPPER = np.triu_indices(6)


def unit(x):
    return x / np.linalg.norm(x, axis=-1, keepdims=True)


def allocation(places, axes, spin=SPIN, drag_ratio=OMAV.drag_ratio):
    """(..., 6, n): forces [N/N], then torques divided by the length that equals both in the mean."""
    torque = np.cross(places, axes) + drag_ratio * spin[:, None] * axes
    length = np.sqrt(np.sum(torque**2, axis=(-1, -2), keepdims=True) / axes.shape[-2])
    return np.concatenate([axes, torque / length], axis=-1).swapaxes(-1, -2)


def split(x):
    x = x.reshape(x.shape[:-1] + (2, ROTORS, 3))
    return RADIUS * unit(x[..., 1, :, :]), unit(x[..., 0, :, :])


def residuals(x, balance):
    places, axes = split(x)
    A = allocation(places, axes)
    isotropy = (A @ A.swapaxes(-1, -2) - ROTORS / 3 * np.eye(6))[..., UPPER[0], UPPER[1]]
    apart = np.linalg.norm(places[..., PAIRS[0], :] - places[..., PAIRS[1], :], axis=-1)
    crowded = np.maximum(0, ROOM - apart) / RADIUS
    return np.concatenate([balance * A.sum(axis=-1), isotropy, 30 * crowded], axis=-1)


def descend(x, balance, steps):
    damping, r = 1e-2, residuals(x, balance)
    for _ in range(steps):
        J = ((residuals(x + 1e-6 * np.eye(x.size), balance) - r) / 1e-6).T
        step = np.linalg.solve(J.T @ J + damping * np.eye(x.size), -J.T @ r)
        after = residuals(x + step, balance)
        if after @ after < r @ r:
            gain = 1 - after @ after / (r @ r)
            x, r, damping = x + step, after, 0.4 * damping
            if gain < 1e-10:
                break
        elif (damping := 4 * damping) > 1e8:
            break
    return x


def measures(places, axes, spin=SPIN, drag_ratio=OMAV.drag_ratio):
    A = allocation(places, axes, spin, drag_ratio)
    values = np.linalg.svd(A, compute_uv=False)
    apart = np.linalg.norm(places[PAIRS[0]] - places[PAIRS[1]], axis=-1)
    return {"rank": int(np.sum(values > 1e-9 * values[0])), "condition": float(values[0] / values[5]),
            "unbalance": float(np.linalg.norm(A.sum(axis=1)) / ROTORS), "least_distance": float(apart.min())}


def search(starts, seed):
    random, best = np.random.default_rng(seed), None
    for k in range(starts):
        x = descend(random.normal(size=2 * 3 * ROTORS), 3.0, 150)
        for balance in (30.0, 1e3, 1e5):
            x = descend(x, balance, 30)
        places, axes = split(x)
        m = measures(places, axes)
        if m["unbalance"] > 1e-6 or m["least_distance"] < 0.999 * ROOM:
            continue
        if best is None or m["condition"] < best[0]["condition"] - 1e-6:
            best = m, places, axes
            print(f"# start {k}: {m}", file=sys.stderr, flush=True)
    return best


def turned(places, axes):
    """The first hub on +x, the second one at y > 0, z = 0: the body axes are free."""
    x = unit(places[0])
    y = unit(places[1] - (places[1] @ x) * x)
    R = np.array([x, y, np.cross(x, y)])
    return places @ R.T, axes @ R.T


def read(file):
    text = open(file, encoding="utf-8").read()
    vectors = lambda key: np.array([[float(n) for n in v.split(",")] for v in re.findall(r"[{ ]" + key + r": \[([^\]]*)\]", text)])
    numbers = lambda key: np.array([float(n) for n in re.findall(key + r": ([^,}]+)", text)])
    return vectors("position"), vectors("axis"), numbers("spin"), numbers("drag_ratio")[0]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--starts", type=int, default=200)
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--check", metavar="FILE")
    options = parser.parse_args()
    if options.check:
        print(json.dumps(measures(*read(options.check))))
        return
    found = search(options.starts, options.seed)
    if not found:
        sys.exit("no start led to a balanced layout with room for the discs: try more --starts")
    for p, n, s in zip(*turned(found[1], found[2]), SPIN):
        print(rotor_line(p, n, int(s), OMAV))


if __name__ == "__main__":
    main()

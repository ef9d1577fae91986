"""A recording as numpy arrays: how fast did the vehicle go, and how much did it pull?

    python3 t01_recording_as_arrays.py flight.mcap      (any supported log; without one, a simulated flight)
"""
import sys

import numpy as np
import omniflight as of

if len(sys.argv) > 1:
    recording = of.load(sys.argv[1])
else:
    recording = of.simulate(of.plan("trajectory_1"), of.load_vehicle("omnimorph"), sensors="laboratory")

print(recording)
for name in recording:
    signal = recording[name]
    print(f"  {name:26} {signal.unit:12} {len(signal):6} samples, {1 / max(signal.median_period_s, 1e-9):7.1f} Hz")
for note in recording.notes:
    print(f"  {note.kind}: {note.text}")

position = recording["position"]                       # views: nothing is copied
speed = np.linalg.norm(np.diff(position.values, axis=0), axis=1) / np.diff(position.t_s)
print(f"median speed {np.median(speed):.3f} m/s")
if "acc" in recording:
    # two signals on one time base
    force = recording["acc"].resample(position.t_s, max_gap_s=0.05)
    print(f"specific force, RMS: {np.sqrt(np.nanmean(force ** 2, axis=0)).round(3)} m/s2")

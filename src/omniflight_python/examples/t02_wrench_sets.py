"""What can a tilting vehicle exert, over its tilt?"""
import numpy as np
import omniflight as of

vehicle = of.load_vehicle("omnimorph")
print(f"{vehicle.name}: {vehicle.mass_kg} kg, {len(vehicle.rotors)} rotors, {vehicle.actuation()}")
weight = vehicle.mass_kg * 9.81
for degrees in range(10, 61, 10):
    wrenches = of.WrenchSet(vehicle, np.radians(degrees))
    forces = wrenches.force_at_torque()
    hover = wrenches.load([0, 0, weight, 0, 0, 0])
    print(f"tilt {degrees:2} deg: rank {wrenches.rank}, {len(forces.vertices):3} corners, weakest direction "
          f"{forces.inradius:6.2f} N of {weight:.2f} N weight, upright hover needs {100 * hover:5.1f} % of the rotors")
design = of.design(vehicle, [np.radians(54.7356)], f_max_N=5.95)
print("smallest omnidirectional tilt:", design["smallest_omnidirectional_tilt_deg"], "deg")

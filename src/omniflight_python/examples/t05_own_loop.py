"""The plant alone, in a loop of your own: hover with a PD law on height, with and without 20 g that the law does not know."""
import numpy as np
import omniflight as of

vehicle = of.load_vehicle("quadrotor_1200g")
matrix = vehicle.allocation_matrix()
to_thrust = np.linalg.pinv(matrix)
for title, model in (("nominal", of.Model()), ("20 g more", of.Model([("payload_mass", {"mass": 0.02})]))):
    plant = of.Plant(vehicle, model, position_m=[0, 0, 1])
    hover = [r.speed(vehicle.mass_kg * 9.81 / len(vehicle.rotors)) for r in vehicle.rotors]
    plant.set_command(hover)
    plant.step(500, held=True)
    for _ in range(1000):                                   # 4 s at 250 Hz
        lift = vehicle.mass_kg * (9.81 + 16 * (1 - plant.position_m[2]) - 8 * plant.velocity_mps[2])
        thrust = to_thrust @ np.array([0, 0, lift, 0, 0, 0])
        plant.set_command([r.speed(f) for r, f in zip(vehicle.rotors, thrust)])
        plant.step(4)
    print(f"{title}: rests at {plant.position_m[2]:.4f} m, {plant.mechanical_power_W:.1f} W")

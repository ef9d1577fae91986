"""A flight with a payload that the model does not know: what is missing? And is it gone once the model has it?"""
import pathlib

import numpy as np
import omniflight as of

# a mass shows only beyond what the laboratory does not know of its thrust and of the air
told = pathlib.Path("told.yaml")
told.write_text("tolerance: {thrust_scale: 0.005}\nenvironment: {air_density_kgpm3: 1.2}\n")

vehicle = of.load_vehicle("omnimorph")
plan = of.plan("trajectory_2")
print("hidden: 0.15 kg more at the body's origin")
flight = of.simulate(plan, vehicle, of.Model([("payload_mass", {"mass": 0.15})]), sensors="laboratory", seed=8)
answer = of.diagnose([flight], vehicle, told=told)
print(answer.verdict, "-", answer.summary)
for finding in answer.findings:
    for p in finding["parameters"]:
        low, high = p["interval95"]
        print(f"  {finding['effect']}: {p['name']} = {p['value']:.4f} [{low:.4f}, {high:.4f}] {p['unit']}")
again = of.simulate(plan, vehicle, answer.model, sensors="laboratory", seed=9)
for name, recording in (("flight", flight), ("model found", again)):
    lift = recording["thrust_command"].values.sum(axis=1)
    print(f"  mean of the commanded thrusts, {name}: {np.mean(lift):.3f} N")

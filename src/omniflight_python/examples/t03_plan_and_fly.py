"""Plan a mission, fly it in this process without and with a cable that nobody told the controller of, compare."""
import omniflight as of

vehicle = of.load_vehicle("omnimorph")
plan = of.plan("trajectory_1")
print(plan.explain())
nominal = of.simulate(plan, vehicle, sensors="laboratory", seed=1)
tethered = of.simulate(plan, vehicle, of.Model([("hung_cable", {"linear_density": 0.3})]), sensors="laboratory", seed=2)
for row in of.compare(nominal, tethered, vehicle):
    print(f"  {row.channel:32} {row.simulated:10.5f} {row.real:10.5f} {row.unit:10} ratio {row.ratio:.2f}")

"""Three axes towards a target that changes on the way, cycle by cycle as a controller would: online.png."""

import matplotlib
import numpy as np

import arcfeed

matplotlib.use("Agg")
import matplotlib.pyplot as plt

CYCLE = 1e-3
generator = arcfeed.OnlineGenerator(
    start=[[0.0, 0.0, 0.0]],
    velocity=[1.0, 1.0, 0.5],
    acceleration=[5.0, 5.0, 2.0],
    jerk=[50.0, 50.0, 20.0],
    cycle=CYCLE,
    ranges=[(-2.0, 2.0)] * 3,
)
generator.set_target([[1.0, -0.5, 0.2]])
steps = []
while not (steps and steps[-1].reached):
    steps.append(generator.step())
    if len(steps) == 400:  # something was seen elsewhere
        generator.set_target([[0.2, 0.5, 0.4]])
    if len(steps) == 900:
        generator.hold()
    if len(steps) == 1300:
        generator.resume()

t = CYCLE * np.arange(1, len(steps) + 1)
figure, rows = plt.subplots(3, 1, sharex=True, layout="constrained")
for row, name, unit in zip(rows, ("q", "qd", "qdd"), ("rad", "rad/s", "rad/s²")):
    row.plot(t, [getattr(step, name) for step in steps])
    row.set_ylabel(unit)
rows[-1].set_xlabel("time [s]")
figure.savefig("online.png", dpi=120)
print(f"{generator}: reached after {t[-1]:.3f} s at {steps[-1].q}")

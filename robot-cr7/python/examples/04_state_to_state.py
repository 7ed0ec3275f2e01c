"""Three axes from a moving start to a target, together: state_to_state.png."""

import matplotlib
import numpy as np

import arcfeed

matplotlib.use("Agg")
import matplotlib.pyplot as plt

motion = arcfeed.state_to_state(
    start=[[0.0, 0.0, 0.0], [0.5, 0.0, -0.2]],
    target=[[1.0, -0.5, 0.2]],
    velocity=[1.0, 1.0, 0.5],
    acceleration=[5.0, 5.0, 2.0],
    jerk=[50.0, 50.0, 20.0],
)
t = np.linspace(0, motion.duration, 500)
q, qd, qdd = motion.sample(t)
figure, rows = plt.subplots(3, 1, sharex=True, layout="constrained")
for row, values, unit in zip(rows, (q, qd, qdd), ("m", "m/s", "m/s²")):
    row.plot(t, values)
    row.set_ylabel(unit)
rows[-1].set_xlabel("time [s]")
figure.savefig("state_to_state.png", dpi=120)
print(motion)

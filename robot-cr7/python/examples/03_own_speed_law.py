"""A speed law of one's own from the rows of the problem, held by every limit of the job: own_speed_law.png.

The law: at each place the greatest speed that the caps allow, made smooth, and less of it until the check finds no excess.
"""

import matplotlib
import numpy as np

import arcfeed

path = arcfeed.Path.butterfly()
problem = arcfeed.problem(path, "cr7")
s, length = problem.s, problem.s[-1]

# Where the acceleration along the path is 0, rows of acceleration bound x = v^2 too: b x <= hi.
x = problem.cap.copy()
rows = problem.rows
falls = rows["b"] != 0
bound = np.where(rows["b"] > 0, rows["hi"], rows["lo"])[falls] / rows["b"][falls]
np.minimum.at(x, rows["at"][falls], bound)

# Ramps of 0.4 m/s^2 before and after every slow place, and at both ends.
x[0] = x[-1] = 0
for order in (range(1, len(s)), range(len(s) - 2, -1, -1)):
    for i in order:
        before = i - 1 if order.step > 0 else i + 1
        x[i] = min(x[i], x[before] + 2 * 0.4 * abs(s[i] - s[before]))

for part in [1.0, 0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3]:
    v = part * np.sqrt(x)
    check = problem.verify(s, v)
    worst = max(check["limits"], key=lambda limit: limit["ratio"])
    print(f"{part:.1f} of it: {check['duration']:7.3f} s, {worst['name']} at {100 * worst['ratio']:.3f} % of its limit")
    if check["holds"]:
        break
motion = arcfeed.plan(path, "cr7")
print(f"the planner, which limits the jerk too, takes {motion.duration:.3f} s")

matplotlib.use("Agg")
import matplotlib.pyplot as plt

figure, axes = plt.subplots(layout="constrained")
axes.plot(1e3 * s, 1e3 * v, label="own law")
axes.plot(1e3 * motion.s, 1e3 * motion.feed, label="planner, with jerk")
axes.set(xlabel="way [mm]", ylabel="feed [mm/s]")
axes.legend()
figure.savefig("own_speed_law.png", dpi=120)

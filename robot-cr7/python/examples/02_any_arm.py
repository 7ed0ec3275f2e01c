"""The same on an arm from a URDF file, with its own limits: any_arm.png.

The file is written here from a built-in arm; take your own instead.
"""

import tempfile
from pathlib import Path

import numpy as np

import arcfeed

with tempfile.TemporaryDirectory() as folder:
    urdf = Path(folder) / "arm.urdf"
    urdf.write_text(arcfeed.Robot("ur5e").to_urdf())
    arm = arcfeed.Robot(str(urdf))

print(arm, "inverse:", arm.inverse_method)
q = np.array([0.3, -1.2, 1.4, -0.8, -1.5, 0.2])
pose = arm.forward(q)
solutions, complete = arm.inverse_all(pose)
print(f"{len(solutions)} joint values put the tool there; all of them: {complete}")

theta = np.linspace(0, 2 * np.pi, 41)
circle = arcfeed.Path.through(0.04 * np.column_stack([np.cos(theta), np.sin(theta)]), name="circle")
motion = arcfeed.plan(circle, arm, arcfeed.Job(feed={"feed_mm_s": 200}))
print(motion, motion.warnings)
motion.plot("any_arm.png")

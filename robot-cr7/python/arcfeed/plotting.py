"""Pictures of motions, by matplotlib."""

import numpy as np


def plot(motion, file=None):
    """Draw path, feed and joint velocities of a motion; save the figure where a file is named. Returns the figure."""
    try:
        from matplotlib.figure import Figure
    except ImportError as error:
        raise ImportError("pictures need matplotlib: pip install 'arcfeed[plot]'") from error
    size = {"figsize": (15, 4.5), "layout": "constrained"}
    if file is not None:
        # Not by pyplot, which would keep the figure and choose a backend.
        figure = Figure(**size)
    else:
        import matplotlib.pyplot as plt

        figure = plt.figure(**size)
    path, feed, joints = figure.subplots(1, 3)
    spread = np.argsort(np.ptp(motion.position, axis=0))[::-1]
    x, y = sorted(spread[:2])
    place = motion.position * 1e3
    points = path.scatter(place[:, x], place[:, y], c=motion.feed * 1e3, s=2, cmap="viridis")
    path.set(aspect="equal", xlabel=f"{'xyz'[x]} [mm]", ylabel=f"{'xyz'[y]} [mm]", title="path, colour by feed")
    figure.colorbar(points, ax=path, label="feed [mm/s]")

    limit = motion.limit_curve
    if len(limit) and np.all(np.diff(limit[:, 0]) >= 0):
        feed.plot(
            motion.t,
            np.interp(motion.s, limit[:, 0], limit[:, 1]) * 1e3,
            color="0.75",
            label="greatest, at constant speed",
        )
    feed.plot(motion.t, motion.feed * 1e3, label="planned")
    feed.set(
        xlabel=f"time [s], {motion.duration:.3f} s in all", ylabel="feed [mm/s]", ylim=(0, 1.15e3 * motion.feed.max())
    )
    feed.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)

    for name, velocity in zip(motion.joint_names, motion.qd.T):
        joints.plot(motion.t, np.degrees(velocity), label=name)
    joints.set(xlabel="time [s]", ylabel="joint velocity [deg/s]")
    joints.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=min(4, len(motion.joint_names)))
    if file is not None:
        figure.savefig(file, dpi=120)
    return figure

"""arcfeed: motion that a robot arm can execute.

A path and a job become a verified motion; arms have kinematics and dynamics; several axes move from state to state, through way-points, and
towards targets that change in any cycle.
Lengths are in m, angles in rad, times in s. Keys of jobs carry their units in their names.

>>> import arcfeed
>>> motion = arcfeed.plan(arcfeed.Path.butterfly(), "cr7", arcfeed.Job(feed={"feed_mm_s": 50}))
>>> motion.q.shape[1]
6
"""

from ._core import (
    ArcfeedError,
    InputError,
    Job,
    JointTrajectory,
    Motion,
    OnlineGenerator,
    OnlineStep,
    Path,
    PlanError,
    Problem,
    Robot,
    StateToState,
    TrackingGenerator,
    TrackingStep,
    WayPointMotion,
    compare,
    plan,
    problem,
    reproduce,
    robots,
    state_to_state,
    way_points,
)

__all__ = [
    "ArcfeedError",
    "InputError",
    "Job",
    "JointTrajectory",
    "Motion",
    "OnlineGenerator",
    "OnlineStep",
    "Path",
    "PlanError",
    "Problem",
    "Robot",
    "StateToState",
    "TrackingGenerator",
    "TrackingStep",
    "WayPointMotion",
    "compare",
    "plan",
    "problem",
    "reproduce",
    "robots",
    "state_to_state",
    "way_points",
]

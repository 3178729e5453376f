"""Files in, frozen Demonstrations out: readers, resampling, velocities, thinning, units."""

from subgoal.demonstrations.metric import Metric
from subgoal.demonstrations.poses import angular_velocities, continue_quaternions, pose_metric, towards_pose
from subgoal.demonstrations.prepare import demonstrate
from subgoal.demonstrations.read import read
from subgoal.demonstrations.readers import read_recording
from subgoal.demonstrations.recordings import resample, split_at_gaps, starting_in
from subgoal.demonstrations.records import Demonstrations, Recording, Source
from subgoal.demonstrations.summary import Summary, summarise
from subgoal.demonstrations.thinning import epsilon_net_indices, thin

__all__ = [
    "Demonstrations",
    "Metric",
    "Recording",
    "Source",
    "Summary",
    "angular_velocities",
    "continue_quaternions",
    "demonstrate",
    "epsilon_net_indices",
    "pose_metric",
    "read",
    "read_recording",
    "resample",
    "split_at_gaps",
    "starting_in",
    "summarise",
    "thin",
    "towards_pose",
]

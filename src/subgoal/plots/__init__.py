"""One function per figure, each giving a matplotlib Figure; ``save_figure`` writes it."""

from subgoal.plots.counts import plot_count_posterior, plot_subgoal_count
from subgoal.plots.files import save_figure
from subgoal.plots.fit import plot_residuals
from subgoal.plots.flight import plot_flight
from subgoal.plots.flight_animation import animate_flight
from subgoal.plots.portraits import plot_portraits
from subgoal.plots.recording import plot_recording
from subgoal.plots.strips import plot_segments
from subgoal.plots.sweep import plot_sweep
from subgoal.plots.trajectories import plot_trajectories

__all__ = [
    "animate_flight", "plot_count_posterior", "plot_flight", "plot_portraits", "plot_recording", "plot_residuals",
    "plot_segments", "plot_subgoal_count", "plot_sweep", "plot_trajectories", "save_figure",
]  # fmt: skip

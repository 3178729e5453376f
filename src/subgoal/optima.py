"""Deterministic companions of the samplers: convex weights, mean field, the likeliest assignment, the score test."""

from subgoal.partition.convex_weights import ConvexWeights, convex_weights
from subgoal.partition.map_partition import MapPartition, map_partition
from subgoal.partition.mean_field import MeanField, mean_field
from subgoal.partition.outcome import Outcome
from subgoal.partition.score_test import ScoreTest, score_test

__all__ = [
    "ConvexWeights",
    "MapPartition",
    "MeanField",
    "Outcome",
    "ScoreTest",
    "convex_weights",
    "map_partition",
    "mean_field",
    "score_test",
]

"""Observations that do not fit in memory or on one machine: shards in files, sampled by workers anywhere."""

from subgoal.likelihood.shards import DirectionWriter, Shards, open_shards, write_shards
from subgoal.posterior.sharded import sample_shards
from subgoal.posterior.sharded_posterior import CandidatePlace, ShardedPosterior, load, save
from subgoal.runtime.cluster import ClusterError, connect

__all__ = [
    "CandidatePlace",
    "ClusterError",
    "DirectionWriter",
    "ShardedPosterior",
    "Shards",
    "connect",
    "load",
    "open_shards",
    "sample_shards",
    "save",
    "write_shards",
]

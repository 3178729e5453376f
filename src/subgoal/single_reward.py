"""Methods that learn one reward from demonstrations, their priors, and the comparison with subgoals."""

from subgoal.irl.apprenticeship import apprenticeship
from subgoal.irl.apprenticeship_local import LocalReward, apprenticeship_in_envelope
from subgoal.irl.bayesian import anneal_reward, bayesian_irl, cooling
from subgoal.irl.cloning import behaviour_cloning
from subgoal.irl.compare import Comparison, compare
from subgoal.irl.max_entropy import max_causal_entropy, max_entropy
from subgoal.irl.max_margin import max_margin_planning
from subgoal.irl.relevance import constant, exponential, relevance, squared_exponential
from subgoal.irl.reward_posterior import RewardPosterior
from subgoal.irl.reward_priors import Beta, Gaussian, Laplace, ThreePeaks, Uniform
from subgoal.irl.rivals import Fitted
from subgoal.irl.single_reward import SingleReward

__all__ = [
    "Beta",
    "Comparison",
    "Fitted",
    "Gaussian",
    "Laplace",
    "LocalReward",
    "RewardPosterior",
    "SingleReward",
    "ThreePeaks",
    "Uniform",
    "anneal_reward",
    "apprenticeship",
    "apprenticeship_in_envelope",
    "bayesian_irl",
    "behaviour_cloning",
    "compare",
    "constant",
    "cooling",
    "exponential",
    "max_causal_entropy",
    "max_entropy",
    "max_margin_planning",
    "relevance",
    "squared_exponential",
]

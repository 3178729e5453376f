"""The world of figure 4-2: one reward, linear in six Manhattan distances, and walks that are optimal for it."""

from __future__ import annotations

from dataclasses import dataclass

from experiments.grid_worlds import state, world
from experiments.rivals import scaled_features
from subgoal.answers.scores import policy_loss
from subgoal.demonstrations.records import Demonstrations
from subgoal.mdp.grids.features import FeatureGroups, feature_groups, manhattan
from subgoal.mdp.grids.grid import GridWorld
from subgoal.mdp.planners.iteration import action_values
from subgoal.mdp.planners.policy import greedy_actions, uniform_policy
from subgoal.mdp.planners.policy_iteration import policy_iteration
from subgoal.mdp.simulation import simulate
from subgoal.runtime.checks import Floats
from subgoal.runtime.seeds import stream

START = (15, 1)
DEMONSTRATIONS, STEPS, ANCHORS = 5, 15, 6
PAIRS = DEMONSTRATIONS * STEPS


@dataclass(frozen=True, eq=False)
class Shown:
    """One run's world, reward, and optimal demonstrations: to learn from, and fresh ones.

    ``features`` (S, 6) are scaled to a range of one; ``groups`` are those of the features as they are.
    """

    grid: GridWorld
    features: Floats
    groups: FeatureGroups
    policy: Floats
    demonstrations: Demonstrations
    fresh: Demonstrations

    @property
    def floor(self) -> float:
        """0-1 loss of the demonstrator's own policy, its ties broken at random."""
        return policy_loss(self.policy[self.demonstrations.states] > 0, self.demonstrations.actions)


def shown(seed: int, *, demonstrations: int = DEMONSTRATIONS, steps: int = STEPS) -> Shown:
    """A random linear reward and optimal actions for it."""
    grid = world(seed)
    generator = stream(seed, 42)
    anchors = grid.cells[generator.choice(grid.n_states, ANCHORS, replace=False)]
    features = manhattan(grid, anchors)
    reward = features @ generator.uniform(-1, 1, size=ANCHORS)
    plan = policy_iteration(grid.mdp, reward)
    values = action_values(grid.mdp, plan.value, reward)
    policy = uniform_policy(greedy_actions(values, 1e-9 * float(abs(plan.value).max())))
    acted = {"steps": steps, "trajectories": demonstrations, "start": state(grid, START)}
    made = [simulate(grid.mdp, policy, seed=each, **acted) for each in (seed, seed + 1_000)]
    return Shown(grid, scaled_features(grid, anchors), feature_groups(features), policy, *made)

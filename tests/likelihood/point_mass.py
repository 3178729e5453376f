"""A point that is pushed about in a plane: the smallest continuous world with something to learn."""

from __future__ import annotations

import numpy as np

from subgoal.continuous import ContinuousWorld
from subgoal.demonstrations import Demonstrations

LOW, HIGH, STEP = np.array([-1.0, -1.0]), np.array([1.0, 1.0]), 0.5


def push(states, actions, duration):
    """The action is the velocity."""
    return states + duration * actions


def plane(**fields):
    """Velocities of up to one along each axis, decided on every half second, looking three ahead."""
    return ContinuousWorld(push, LOW, HIGH, step=STEP, **({"horizon": 3.0} | fields))


def there_and_back(seed=0, laps=3, noise=0.1):
    """From the origin to (3, 0), to (3, 3) and round again, a second or two at each, with a shaking hand."""
    rng = np.random.default_rng(seed)
    corners = np.array([[3.0, 0.0], [3.0, 3.0], [0.0, 0.0]])
    state, states, actions, labels = np.zeros(2), [], [], []
    for _ in range(laps):
        for k, corner in enumerate(corners):
            for _ in range(9):
                wanted = np.clip(corner - state, -1, 1)
                action = np.clip(wanted + noise * rng.normal(size=2), LOW, HIGH)
                states.append(state)
                actions.append(action)
                labels.append(k)
                state = push(state, action, STEP)
    times = STEP * np.arange(len(states))
    demos = Demonstrations(
        states=np.array(states), actions=np.array(actions), offset=[0, len(states)], times=times, final_states=[state],
    )  # fmt: skip
    return demos, np.array(labels), corners

"""Recordings of small systems whose law is known."""

from __future__ import annotations

import numpy as np

from subgoal.demonstrations.records import Demonstrations

A = np.array([[0.8, 0.5], [-0.4, 0.3]])
B = np.array([[0.1], [0.5]])
C = np.array([0.01, -0.03])
STEP = 0.1


def affine(lengths: tuple[int, ...] = (60, 50), *, noise: float = 0.0, seed: int = 0) -> Demonstrations:
    """s' = A s + B a + c, in trajectories that start far from where the one before ended."""
    generator = np.random.default_rng(seed)
    states, actions, times, ends = [], [], [], []
    for k, length in enumerate(lengths):
        state = np.array([3.0 - 6 * k, 5.0 * k])
        for i in range(length):
            action = generator.normal(size=1)
            states.append(state)
            actions.append(action)
            times.append(STEP * i)
            state = A @ state + B @ action + C + noise * generator.normal(size=2)
        ends.append(state)
    return Demonstrations(
        np.array(states), np.array(actions), np.cumsum([0, *lengths]), times=np.array(times),
        final_states=np.array(ends),
    )  # fmt: skip


def pendulum_step(states: np.ndarray, actions: np.ndarray, duration: float) -> np.ndarray:
    """A damped pendulum (angle, rate) pushed by a torque, in 50 Euler steps."""
    angle, rate = np.array(states).T
    for _ in range(50):
        angle, rate = (
            angle + duration / 50 * rate,
            rate + duration / 50 * (-2 * np.sin(angle) - 0.3 * rate + actions[:, 0]),
        )
    return np.stack([angle, rate], axis=1)


def pendulum(count: int = 400, *, lowest: float = -np.pi, noise: float = 0.0, seed: int = 1) -> Demonstrations:
    """Pushed over the top again and again; the angle lies from ``lowest`` to one turn above."""
    generator = np.random.default_rng(seed)
    states, actions = [np.array([[0.0, 3.0]])], np.repeat(generator.normal(0, 2, size=count // 5), 5)[:, None]
    for action in actions:
        after = pendulum_step(states[-1], action[None], STEP) + noise * generator.normal(size=2)
        states.append(np.clip(after, [-np.inf, -4], [np.inf, 4]))
    ran = np.concatenate(states)
    ran[:, 0] -= 2 * np.pi * np.floor((ran[:, 0] - lowest) / (2 * np.pi))
    return Demonstrations(ran[:-1], actions, np.array([0, count]), times=STEP * np.arange(count), final_states=ran[-1:])

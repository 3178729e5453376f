"""Figure 5-1: how an envelope grows for one goal (thesis 5.1.1), and what the thesis's form of it never sees.

Eight directions and stay, 0.7 as chosen, γ = 0.99. A wall stands between the first state and the goal; the demonstrator
goes round its top, and a gap near its foot would be a shorter way. The thesis's form takes the states outside its
envelope to be worth nothing, so that greedy simulations stay inside and the gap is never met; the form with two bounds
looks wherever a better way may be. Both are held against exact planning on the whole world.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from experiments.common import INK, PALETTE, Headline, Options, run, sheet
from experiments.grid_pictures import draw_map, draw_pairs
from subgoal.demonstrations.records import Demonstrations
from subgoal.mdp.grids.grid import THESIS_SLIP, GridWorld
from subgoal.mdp.planners.first_passage import plan_subgoals
from subgoal.mdp.planners.growing import Growing, Settings
from subgoal.mdp.planners.rtdp import MOST_STATES
from subgoal.mdp.planners.rtdp_literal import LiteralRun, rtdp_literal
from subgoal.options.tabular import execute, goal_option
from subgoal.runtime.checks import Floats, Ints

WIDTH, HEIGHT, DISCOUNT = 40, 28, 0.99
CONFIDENCE, NATS = 10.0, 0.01
"""The bounded form is asked for log probabilities that are wrong by no more than this."""
START, GOAL, GAP = (13, 13), (28, 11), (20, 4)
"""Cells counted from zero, as are those of the walls."""
OUTSIDE, VALUES = "#e4e4e4", "viridis"
THESIS, BOUNDED = PALETTE[1], PALETTE[0]


def world(*, gap: bool = True) -> GridWorld:
    """One long wall, open at the top, with a gap near its foot; two short ones."""
    free = np.ones((HEIGHT, WIDTH), bool)
    free[:24, GAP[0]] = False
    free[GAP[1], GAP[0]] = gap
    free[8, 3:11] = False
    free[19, 27:37] = False
    return GridWorld(free, discount=DISCOUNT, slip=THESIS_SLIP)


def shown(grid: GridWorld, seed: int) -> Demonstrations:
    """From the start to the goal by somebody who does not know of the gap."""
    closed = world(gap=False)
    goal = closed.state(*GOAL)
    leg = execute(goal_option(closed.mdp, goal), closed.mdp, start=closed.state(*START), steps=1000, seed=seed)
    states = grid.states(closed.cells[np.append(leg.states, goal)])
    actions = np.append(leg.actions, grid.action("stay"))
    return Demonstrations(states, actions, np.array([0, states.size]), coordinates=grid.mdp.coordinates)


@dataclass(frozen=True, eq=False)
class Planned:
    """Both forms and exact planning for one goal, at the U demonstrated states."""

    grid: GridWorld
    goal: int
    demonstrations: Demonstrations
    states: Ints
    exact: Floats
    """(U, A) of Q*."""
    literal: LiteralRun
    bounded: Growing

    @cached_property
    def held(self) -> float:
        """V*(g), by which values E[γ^T] become those of (4.1)."""
        return 1 / (1 - self.grid.discount)

    @property
    def literal_values(self) -> Floats:
        """(U, A)."""
        return np.asarray(self.literal.action_values * self.held)

    @property
    def bounded_values(self) -> Floats:
        """(U, A) the middle of the bounds."""
        return np.asarray(self.bounded.rows.mean(axis=0)[:, :, 0])

    @property
    def certified(self) -> float:
        """No action value is further than this from the middle of its bounds."""
        return float(self.bounded.gap.max() / 2)


def plan(seed: int) -> Planned:
    """All three."""
    grid = world()
    demos, goal = shown(grid, seed), grid.state(*GOAL)
    states = np.unique(demos.states)
    exact = plan_subgoals(grid.mdp, [goal], states=states, relative=True).action_values[:, :, 0]
    bounded = Growing(grid, [np.array([goal])], states, Settings("continuing", NATS / (2 * CONFIDENCE), MOST_STATES))
    while not bounded.step():
        bounded.grow()
    return Planned(grid, goal, demos, states, exact, rtdp_literal(grid, goal, states=states, seed=seed), bounded)


def log_policy(values: Floats) -> Floats:
    """(U, A) log of the softmax (4.2)."""
    shifted = CONFIDENCE * (values - values.max(axis=1, keepdims=True))
    return np.asarray(shifted - np.log(np.exp(shifted).sum(axis=1, keepdims=True)))


def numbers(planned: Planned, seed: int) -> Headline:
    """Sizes of the stages, errors of action values, and what these do to the likelihood of the demonstration."""
    demos, exact = planned.demonstrations, planned.exact
    row = np.searchsorted(planned.states, demos.states)
    thorough = rtdp_literal(planned.grid, planned.goal, states=planned.states, stop="all", seed=seed)
    forms = {"thesis": planned.literal_values, "bounded": planned.bounded_values}
    told = {"exact": exact, **forms}
    return {
        "states": planned.grid.n_states,
        "observations": demos.n_observations,
        "stages": [stage.states.size for stage in planned.literal.stages],
        "simulations": planned.literal.simulations,
        "states_inside": {
            "thesis": planned.literal.stages[-1].states.size, "bounded": planned.bounded.envelope.n_inside,
        },
        "largest_error": {name: float(np.abs(values - exact).max()) for name, values in forms.items()},
        "largest_error_of_a_log_probability": {
            name: float(np.abs(log_policy(values) - log_policy(exact))[row, demos.actions].max())
            for name, values in forms.items()
        },
        "certified_bound": planned.certified,
        "best_action_at_the_start": {
            name: planned.grid.action_names[int(values[row[0]].argmax())] for name, values in told.items()
        },
        "log_likelihood": {name: float(log_policy(values)[row, demos.actions].sum()) for name, values in told.items()},
        "thesis_with_a_simulation_from_every_state": {
            "states_inside": thorough.stages[-1].states.size, "simulations": thorough.simulations,
            "largest_error": float(np.abs(thorough.action_values * planned.held - exact).max()),
        },
    }  # fmt: skip


def experiment(options: Options) -> tuple[Headline, Figure]:
    """The same with ``--quick``: it takes a second."""
    planned = plan(options.seed)
    headline = numbers(planned, options.seed)
    return headline, picture(planned, headline)


def picture(planned: Planned, headline: Headline) -> Figure:
    """Three stages of the thesis's form; below, the bounded form, and what both say of the first state."""
    figure = sheet(12.6, 8.1)
    figure.suptitle("The thesis's envelope never meets the gap and calls the long way best; two bounds find the gap")
    grids = figure.add_gridspec(2, 3)
    stages = planned.literal.stages
    middle = len(stages) // 2
    scale = Normalize(min(float(stages[0].value.min()) * planned.held, 70.0), planned.held)
    for k, (name, number) in enumerate((("first", 0), ("a middle", middle), ("last", len(stages) - 1))):
        axis, stage = figure.add_subplot(grids[0, k]), stages[number]
        draw_envelope(axis, planned, stage.states, stage.value * planned.held, scale)
        axis.set_title(f"Thesis's form, {name} stage: {stage.states.size} states")
        if k == 2:
            point_out(axis, "a gap, never met", THESIS)
    axis = figure.add_subplot(grids[1, 0])
    envelope, held = planned.bounded.envelope, planned.held
    inside = envelope.inside
    value = (planned.bounded.lower + planned.bounded.upper)[inside, 0] / 2 * held
    drawn = draw_envelope(axis, planned, envelope.states[inside], value, scale)
    axis.set_title(f"Two bounds: {envelope.n_inside} of {planned.grid.n_states} states")
    point_out(axis, "the gap, found", BOUNDED)
    figure.colorbar(drawn, ax=axis, location="bottom", label="value of a state; grey: not looked at", shrink=0.85)
    draw_actions(figure.add_subplot(grids[1, 1:]), planned, headline)
    return figure


def draw_envelope(axis: Axes, planned: Planned, states: Ints, value: Floats, scale: Normalize) -> Any:
    """A grey world, values on the envelope, the demonstration, the goal."""
    grid = planned.grid
    table = np.full(grid.free.shape, np.nan)
    table[tuple(grid.cells[states].T[::-1])] = value
    drawn = axis.imshow(table, origin="lower", extent=(0.5, WIDTH + 0.5, 0.5, HEIGHT + 0.5), cmap=VALUES, norm=scale)
    axis.set_facecolor(OUTSIDE)
    draw_map(axis, grid)
    draw_pairs(axis, grid, planned.demonstrations, ["white"] * planned.demonstrations.n_observations)
    x, y = grid.cells[planned.goal] + 1
    axis.plot(x, y, "*", color="#ff3b30", ms=15, mec="white", mew=1.0, zorder=6)
    x, y = grid.cells[planned.demonstrations.states[0]] + 1
    axis.plot(x, y, "o", color=INK, ms=7, mec="white", mew=1.0, zorder=6)
    axis.set_xticks([])
    axis.set_yticks([])
    return drawn


def point_out(axis: Axes, words: str, colour: str) -> None:
    """An arrow to the gap."""
    axis.annotate(
        words, (GAP[0] + 1, GAP[1] + 1), xytext=(GAP[0] + 4, GAP[1] - 1.5), color=colour, weight="bold", va="center",
        arrowprops={"arrowstyle": "->", "color": colour, "lw": 1.8}, zorder=7,
        bbox={"facecolor": "white", "alpha": 0.85, "lw": 0, "pad": 1.5},
    )  # fmt: skip


def draw_actions(axis: Axes, planned: Planned, headline: Headline) -> None:
    """Action values at the first state by exact planning and both forms."""
    row, taken = (
        int(np.searchsorted(planned.states, planned.demonstrations.states[0])),
        planned.demonstrations.actions[0],
    )
    places = np.arange(len(planned.grid.action_names))
    literal, bounded, exact = (v[row] for v in (planned.literal_values, planned.bounded_values, planned.exact))
    axis.hlines(places, literal, exact, color=THESIS, alpha=0.35, lw=2)
    axis.plot(exact, places, "|", color=INK, ms=19, mew=2.2)
    axis.plot(bounded, places, "o", color=BOUNDED, ms=6.5)
    axis.plot(literal, places, "s", color=THESIS, ms=6.5)
    error, best = headline["largest_error"], headline["best_action_at_the_start"]
    axis.set_title("Value of each action at the first state (black dot)")
    axis.set_yticks(places, [f"{name}{' (taken)' if k == taken else ''}" for k, name in
                             enumerate(planned.grid.action_names)])  # fmt: skip
    axis.invert_yaxis()
    low, high = float(literal.min()), float(exact.max())
    axis.set_xlim(low - 0.4, high + 0.4)
    axis.set_ylim(places[-1] + 0.6, -3.4)
    for x, side, colour, words in (
        (low - 0.2, "left", THESIS, f"thesis's form: best is {best['thesis']},\nwrong by up to {error['thesis']:.1f},\n"
                                    "and nothing tells"),
        (high + 0.2, "right", BOUNDED, f"two bounds (dots): best is {best['bounded']},\nwrong by "
                                       f"{error['bounded']:.5f}, certified {headline['certified_bound']:.5f};\n"
                                       "exact values: bars"),
    ):  # fmt: skip
        axis.text(x, -3.2, words, color=colour, ha=side, va="top", weight="bold")


if __name__ == "__main__":
    run("fig_5_1", experiment)

"""Real recordings on a grid, where they are there: what must hold of them, and the actions that were recorded."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from subgoal.demonstrations import Demonstrations, Recording, read_recording, starting_in
from subgoal.irl.bnirl import bnirl
from subgoal.mdp import Occupancy, read_maps, to_cells


def data_folder(name):
    """The data set ``name`` in the folder that SUBGOAL_DATA names."""
    path = Path(os.environ.get("SUBGOAL_DATA", "nowhere")) / name
    if not path.is_dir():
        pytest.skip(f"SUBGOAL_DATA does not name a folder that holds {name}")
    return path


@pytest.mark.filterwarnings("ignore")
def test_people_in_a_forum() -> None:
    data = read_recording(data_folder("edinburgh_forum") / "tracks.01Jul.txt")
    room = Occupancy.around(data, 20, y_down=True)
    world, demos = to_cells(data, room, discount=0.95, staying="drop")
    assert demos.n_trajectories == data.n_trajectories == 1262
    ends = data.positions[data.offset[1:] - 1]
    assert np.abs(demos.final_places - ends).max() <= 10
    assert np.abs(demos.places[demos.offset[:-1]] - data.positions[data.offset[:-1]]).max() <= 10
    still = (np.diff(np.floor(data.positions / 20), axis=0) == 0).all(axis=1)
    still[data.offset[1:-1] - 1] = False
    assert demos.source.notes["pairs of standing still dropped"] == still.sum() == 73341
    filled = demos.source.notes["pairs filled in between samples"]
    assert demos.n_observations == len(data.positions) - 1262 - still.sum() + filled
    assert filled < 0.03 * demos.n_observations
    corner = starting_in(data, [480, -np.inf], [np.inf, 140])
    world, some = to_cells(corner, room, discount=0.95, staying="drop")
    assert some.n_trajectories == 157
    few = Demonstrations(
        some.states[: some.offset[20]], some.actions[: some.offset[20]], some.offset[:21],
        final_states=some.final_states[:20], coordinates=some.coordinates,
    )  # fmt: skip
    posterior = bnirl(few, world.mdp, chains=1, draws=20, warmup=20, thin=1, seed=0, workers=1)
    assert set(map(tuple, posterior.candidates.points)) <= set(map(tuple, room.position_of(world.cells)))


def test_people_in_kitchens_take_the_steps_that_were_recorded() -> None:
    """The action found is the one recorded wherever somebody moved, and "stay" wherever nobody did."""
    import pandas as pd

    folder = data_folder("overcooked_human")
    table = pd.read_csv(folder / "human_human_trials.csv.gz", nrows=40_000)
    kitchens = read_maps(folder / "layouts.txt", blocked="OPDS", origin="upper")
    seen = 0
    for layout, games in table.groupby("layout"):
        room = Occupancy.from_map(kitchens[layout], 1, (-0.5, -0.5))
        for _, game in games.groupby(["worker", "round", "player"]):
            places, recorded = game[["x", "y"]].to_numpy(float), game["action"].to_numpy()[:-1]
            data = Recording(places, game["t"].to_numpy(float), np.array([0, len(game)]), ("x", "y"))
            world, demos = to_cells(data, room, discount=0.9, moves=4)
            moved = (np.diff(places, axis=0) != 0).any(axis=1)
            found = np.array(world.action_names)[demos.actions]
            np.testing.assert_array_equal(found, np.where(moved, recorded, "stay"))
            np.testing.assert_array_equal(demos.places, places[:-1])
            seen += int(moved.sum())
    assert seen > 5_000

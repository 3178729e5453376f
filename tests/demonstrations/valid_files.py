"""Small valid files of every format, written by other libraries than the ones under test where there are any."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from tests.demonstrations.valid_bags import START, Message, odometry, pose, transforms, write_bag

CSV = "id,t,x,y,p\n" + "".join(f"{'ab'[k % 2]},{k / 10},{k * 0.5},{k * k / 7:.4f},{0.5 + k / 50}\n" for k in range(24))
SHEET = (
    "\ufeffZeit;Wer;X in m;Y in m\r\n2024-05-01T12:00:00;a;1,5;2\r\n2024-05-01T12:00:00.5;a;1,75;2,25\r\n"
    "2024-05-01T12:00:00.5;b;0;-1,5e1\r\n2024-05-01T12:00:01;a;2;\r\n2024-05-01T12:00:01;b;1;1\r\n"
)
EDINBURGH = (
    "% Total number of trajectories in file are  2 \n\nProperties.R1=[3 95 97 8.4 30.02 ];\n"
    " TRACK.R1=[[593 42 95];[588 48 96];[588 48 96];[583 56 97]];\nProperties.R2=[2 1 2 3.5 ];\n"
    " TRACK.R2=[[1 2 367];[3 4 369]];\n"
)
TUM = "# ground truth\n# timestamp tx ty tz qx qy qz qw\n" + "".join(
    f"{1305031098.25 + k / 4:.4f} {1 + k / 10:.4f} 0.5 -{k / 8:.4f} 0 0 0 1\n" for k in range(12)
)
EUROC = (
    "#timestamp [ns], p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z []\n"
    + "".join(
        f"{1403636580838555648 + 5_000_000 * k},{k / 10},{-k / 5},0.5,{np.cos(k / 20):.6f},{np.sin(k / 20):.6f},0,0\n"
        for k in range(12)
    )
)
LABYRINTH = (
    "session,bout,step,node,frame_in_bout,frame_abs,rewards\nA,0,0,0,4,10,0\nA,0,1,2,9,15,0\nA,0,2,0,11,17,1\n"
    "A,0,3,127,20,26,0\nA,1,0,0,1,90,0\nB,0,0,0,3,3,0\nB,0,1,1,5,5,0\nB,0,2,4,7,7,0\n"
)


def deeplabcut_frame(animals: tuple[str, ...] = (), count: int = 8) -> Any:
    """A pandas frame as DeepLabCut makes it: x = frame + 10 part, y = 2 x, sure except in frame 2."""
    import pandas as pd

    labels = [["net"], list(animals), ["nose", "tail"], ["x", "y", "likelihood"]]
    names = ["scorer", "individuals", "bodyparts", "coords"]
    if not animals:
        del labels[1], names[1]
    columns = pd.MultiIndex.from_product(labels, names=names)
    parts = len(columns) // 3
    x = np.arange(count)[:, None] + 10.0 * np.arange(parts)
    sure = np.where(np.arange(count) == 2, 0.1, 0.9)[:, None] * np.ones(parts)
    values = np.stack([x, 2 * x, sure], axis=2).reshape(count, -1)
    return pd.DataFrame(values, columns=columns)


def write_sleap(path: Path, *, names: bool = True) -> None:
    """Two animals, two nodes, eight frames; animal 1 is missing in frames 3 and 4, node 1 of animal 0 unsure in 5."""
    import h5py

    frames = np.arange(8.0)
    tracks = np.stack([[[frames + 10 * node + 100 * a, 2 * frames] for node in range(2)] for a in range(2)])
    tracks = np.ascontiguousarray(tracks.transpose(0, 2, 1, 3))
    tracks[1, :, :, 3:5] = np.nan
    scores = np.full((2, 2, 8), 0.9)
    scores[0, 1, 5] = 0.2
    with h5py.File(path, "w") as file:
        file["tracks"] = tracks
        file["point_scores"] = scores
        file["node_names"] = np.array([b"nose", b"tail"])
        file["track_names"] = np.array([b"mother", b"pup"] if names else [], dtype="S6")


def write_lasa(path: Path) -> None:
    """Two demonstrations of 5 and 6 samples."""
    from scipy.io import savemat

    demos = np.empty(2, dtype=object)
    for k in range(2):
        t = np.arange(5.0 + k) / 10
        demos[k] = {"pos": np.stack([10 * t, -5 * t]), "t": t[None], "vel": np.zeros((2, 5 + k)), "dt": 0.1}
    savemat(path, {"demos": demos, "dt": 0.1})


def write_bags(folder: Path) -> None:
    """A bag of ROS 1 and the files of two of ROS 2, with 12 messages each."""
    stamps = [START + 10**8 * k for k in range(12)]
    places = [(k / 10, k * k / 9, 0.5, 0, 0, np.sin(k / 8), np.cos(k / 8)) for k in range(12)]
    topics: dict[str, list[tuple[int, Message]]] = {
        "bag": [(stamp, pose(stamp, place)) for stamp, place in zip(stamps, places, strict=True)],
        "db3": [(stamp, odometry(stamp, place, range(6))) for stamp, place in zip(stamps, places, strict=True)],
        "mcap": [(stamp, transforms(stamp, {"body": place})) for stamp, place in zip(stamps, places, strict=True)],
    }
    for kind, messages in topics.items():
        with tempfile.TemporaryDirectory() as aside:
            path = write_bag(Path(aside), kind, {"/topic": messages})
            shutil.copy(path, folder / f"b.{kind}")


def write_all(folder: Path) -> dict[str, tuple[Path, dict[str, Any]]]:
    """One file of every format with the options that read it."""
    import pandas as pd

    texts = {"csv": CSV, "sheet": SHEET, "edinburgh": EDINBURGH, "tum": TUM, "euroc": EUROC, "labyrinth": LABYRINTH}
    for name, text in texts.items():
        (folder / f"{name}.{'txt' if name in ('edinburgh', 'tum') else 'csv'}").write_bytes(text.encode())
    t = np.arange(12.0)
    places = np.stack([t, t**2], axis=1)
    frame = pd.DataFrame({"id": list("aabb") * 3, "t": t, "x": t / 3, "y": -t})
    frame.to_parquet(folder / "table.parquet")
    np.savez(folder / "plain.npz", positions=places, times=t, offset=np.array([0, 5, 12]))
    np.savez_compressed(folder / "packed.npz", positions=places, commands=places[:, ::-1])
    np.savez(folder / "pairs.npz", states=np.arange(6), actions=np.arange(6) % 2, offset=np.array([0, 2, 6]))
    deeplabcut_frame().to_csv(folder / "single.csv")
    deeplabcut_frame(("mother", "pup")).to_hdf(folder / "several.h5", key="df_with_missing", format="table", mode="w")
    write_sleap(folder / "sleap.h5")
    write_lasa(folder / "lasa.mat")
    write_bags(folder)
    options: dict[str, dict[str, Any]] = {
        "euroc.csv": {"pose": True},
        "b.bag": {"plane": "xy"},
        "b.db3": {"pose": True, "twist": True},
        "csv.csv": {"trajectory": "id", "likelihood": "p"},
        "sheet.csv": {"position": ["X in m", "Y in m"], "time": "Zeit", "trajectory": "Wer"},
        "table.parquet": {"trajectory": "id", "clock": "sort"},
        "packed.npz": {"action": "commands"},
        "single.csv": {"bodypart": "tail", "rate": 10},
        "several.h5": {"bodypart": "nose"},
        "sleap.h5": {"bodypart": "tail"},
    }
    return {path.name: (path, options.get(path.name, {})) for path in sorted(folder.iterdir())}

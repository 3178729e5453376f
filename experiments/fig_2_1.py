"""Figure 2-1: a Chinese restaurant mixture finds five Gaussian clusters, and what it says as η grows.

Five clusters of 60 points in the plane, 25 sweeps at η = 1 from a random start in 20 clusters, for both exact
samplers. Beside them Algorithm 2 as the thesis prints it, and the number of clusters for η from 1 to 10,000, which
the thesis calls nearly identical.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Ellipse
from matplotlib.ticker import MultipleLocator
from scipy.optimize import linear_sum_assignment

from experiments.common import GREY, INK, PALETTE, Headline, Options, run, sheet
from subgoal.partition.crp import expected_clusters
from subgoal.partition.crp_mixture import MixtureDraws, collapsed_gibbs, neal_8
from subgoal.partition.crp_mixture_literal import literal_algorithm_2
from subgoal.partition.normal_inverse_wishart import NormalInverseWishart
from subgoal.runtime.checks import Floats, Ints
from subgoal.runtime.seeds import stream

CENTRES = np.array([[0.0, 0.2], [6.2, 1.0], [1.2, 6.0], [-5.2, 3.2], [-3.2, -5.0]])
SPREADS = np.array([[1.1, 0.5], [0.9, -0.4], [1.2, 0.2], [0.8, 0.6], [1.3, -0.7]])
EACH, SWEEPS, RANDOM_CLUSTERS = 60, 25, 20
TRUTH: Ints = np.repeat(np.arange(len(CENTRES)), EACH)
SHOWN = (0, 5, 10, 15, 20, 25)
CONCENTRATIONS = (1.0, 10.0, 100.0, 1e3, 1e4)
SAMPLERS: dict[str, Callable[..., MixtureDraws]] = {
    "collapsed": collapsed_gibbs,
    "neal_8": neal_8,
    "literal": literal_algorithm_2,
}
EXACT = ("collapsed", "neal_8")
NAMES = {"collapsed": "collapsed (exact)", "neal_8": "Neal 8 (exact)", "literal": "Algorithm 2 as printed"}
COLOURS = {"collapsed": PALETTE[0], "neal_8": PALETTE[1], "literal": GREY}
WEIGHTY = 0.02
DATA, START, FIRST, LONG, LITERAL = range(5)  # names of the random streams


@dataclass(frozen=True)
class Results:
    """Everything the picture shows: points, chains at η = 1 by sampler, and long runs by sampler and η."""

    points: Floats
    chains: dict[str, list[MixtureDraws]]
    from_one: dict[str, list[MixtureDraws]]
    literal_from_truth: dict[float, MixtureDraws]
    long: dict[str, dict[float, MixtureDraws]]
    kept: slice


def experiment(options: Options) -> tuple[Headline, Figure]:
    """Sample, measure, draw."""
    results = sample(options.seed, chains=2 if options.quick else 4, sweeps=20 if options.quick else 100)
    return headline(results), picture(results)


def five_clusters(generator: np.random.Generator) -> Floats:
    """(300, 2) points, 60 around each centre, with tilted covariances."""
    tilted = [np.array([[a, 0.5 * b], [0.5 * b, 0.7]]) for a, b in SPREADS]
    drawn = [generator.multivariate_normal(c, s, EACH) for c, s in zip(CENTRES, tilted, strict=True)]
    return np.concatenate(drawn)


def sample(seed: int, chains: int, sweeps: int) -> Results:
    """All the chains of the figure; ``sweeps`` is the length of the runs along η, whose second half is kept."""
    points = five_clusters(stream(seed, DATA))
    base = NormalInverseWishart.from_data(points)
    starts = [stream(seed, START, c).integers(RANDOM_CLUSTERS, size=len(points)) for c in range(chains)]

    def go(kind: str, start: Any, *identity: int, eta: float = 1.0, length: int = SWEEPS) -> MixtureDraws:
        generator = stream(seed, *identity, list(SAMPLERS).index(kind))
        return SAMPLERS[kind](points, base, concentration=eta, sweeps=length, generator=generator, start=start)

    return Results(
        points=points,
        chains={kind: [go(kind, start, FIRST, c) for c, start in enumerate(starts)] for kind in SAMPLERS},
        from_one={kind: [go(kind, None, FIRST, c, 1) for c in range(chains)] for kind in EXACT},
        literal_from_truth={eta: go("literal", TRUTH, LITERAL, e, eta=eta) for e, eta in enumerate(CONCENTRATIONS)},
        long={
            kind: {eta: go(kind, TRUTH, LONG, e, eta=eta, length=sweeps) for e, eta in enumerate(CONCENTRATIONS)}
            for kind in EXACT
        },
        kept=slice(sweeps // 2, None),
    )


def matched_share(label: Ints) -> float:
    """Largest share of points that agree with the truth when clusters are named one to one."""
    table = np.zeros((len(CENTRES), int(label.max()) + 1))
    np.add.at(table, (TRUTH, label), 1)
    return float(table[linear_sum_assignment(table, maximize=True)].sum() / len(label))


def sweeps_to_truth(draws: MixtureDraws) -> int | None:
    """First sweep where exactly five clusters hold more than 2 % and nine points in ten are where they belong."""
    above = draws.clusters_above(WEIGHTY)
    reached = (t for t, z in enumerate(draws.labels) if above[t] == 5 and matched_share(z) >= 0.9)
    return next(reached, None)


def sweeps_to_flat(draws: MixtureDraws, level: float) -> int | None:
    """First sweep whose log joint is as high as usual later on."""
    high = np.flatnonzero(draws.log_joint >= level)
    return int(high[0]) if high.size else None


def usual_log_joint(results: Results) -> float:
    """The 5 % quantile of the log joint in the long collapsed run at η = 1."""
    return float(np.quantile(results.long["collapsed"][1.0].log_joint[results.kept], 0.05))


def median(values: Iterable[float | None]) -> float | None:
    """Median, where None stands for later than all."""
    middle = float(np.median([np.inf if value is None else value for value in values]))
    return middle if np.isfinite(middle) else None


def headline(results: Results) -> Headline:
    """The numbers: medians over all chains of both exact samplers, then every chain by itself."""
    level = usual_log_joint(results)
    by_chain = {kind: [one_chain(draws, level) for draws in results.chains[kind]] for kind in EXACT}
    every = [chain for chains in by_chain.values() for chain in chains]
    fields = ("clusters_at_20", "clusters_at_25", "sweeps_to_truth", "sweeps_to_flat_log_joint", "matched_at_25")
    return {
        **{name: median(chain[name] for chain in every) for name in fields},
        "clusters_by_eta": {f"{eta:g}": clusters_by_eta(results, eta) for eta in CONCENTRATIONS},
        "literal": literal(results, level),
        "from_one_cluster": {
            kind: [int(draws.clusters_above(WEIGHTY)[SWEEPS]) for draws in results.from_one[kind]] for kind in EXACT
        },
        "by_chain": by_chain,
    }


def one_chain(draws: MixtureDraws, level: float) -> dict[str, Any]:
    above = draws.clusters_above(WEIGHTY)
    return {
        "clusters_at_20": int(above[20]),
        "clusters_at_25": int(above[25]),
        "all_clusters_at_25": int(draws.n_clusters[25]),
        "matched_at_25": round(matched_share(draws.labels[25]), 3),
        "sweeps_to_truth": sweeps_to_truth(draws),
        "sweeps_to_flat_log_joint": sweeps_to_flat(draws, level),
    }


def mean_clusters(results: Results, kind: str, eta: float) -> tuple[float, float]:
    """Mean number of clusters, and of those above 2 %, over the kept sweeps."""
    draws = results.long[kind][eta]
    return (
        float(draws.n_clusters[results.kept].mean()),
        float(draws.clusters_above(WEIGHTY)[results.kept].mean()),
    )


def clusters_by_eta(results: Results, eta: float) -> dict[str, float]:
    """Posterior means, how far the two exact samplers lie apart in K, and the prior's own expectation.

    The runs begin at the truth, so that a drift away from it is the posterior's doing.
    """
    means = np.array([mean_clusters(results, kind, eta) for kind in EXACT])
    return {
        "all": round(float(means[:, 0].mean()), 2),
        "above_2_percent": round(float(means[:, 1].mean()), 2),
        "prior": round(expected_clusters(len(results.points), eta), 2),
        "gap_between_samplers": round(float(np.ptp(means[:, 0])), 2),
    }


def literal(results: Results, level: float) -> dict[str, Any]:
    """What Algorithm 2 does as printed: from the same starts, and from the truth along η."""
    return {
        "by_chain": [one_chain(draws, level) for draws in results.chains["literal"]],
        "from_truth_by_eta": {f"{eta:g}": one_chain(draws, level) for eta, draws in results.literal_from_truth.items()},
    }


def picture(results: Results) -> Figure:
    """Snapshots above, traces in the middle, the log joint and the dependence on η below."""
    figure = sheet(13.0, 10.4)
    figure.suptitle(f"Figure 2-1   How many clusters are there?  Five were put in (N = {len(TRUTH)}, η = 1)")
    grid = figure.add_gridspec(2, 1, height_ratios=(1.0, 2.7))
    upper, lower = figure.add_subfigure(grid[0]), figure.add_subfigure(grid[1])
    upper.suptitle(
        "Colours: the true clusters.  Black: clusters of one collapsed chain that hold more than 2 % (2 sd)",
        fontsize=10.5,
        fontweight="normal",
    )
    base = NormalInverseWishart.from_data(results.points)
    for axes, sweep in zip(upper.subplots(1, len(SHOWN)), SHOWN, strict=True):
        snapshot(axes, results, base, sweep)
    panels = lower.subplots(2, 2)
    traces(panels[0, 0], results)
    weighty_traces(panels[0, 1], results)
    joint(panels[1, 0], results)
    along_eta(panels[1, 1], results)
    return figure


def snapshot(axes: Axes, results: Results, base: NormalInverseWishart, sweep: int) -> None:
    """The data in the colours of the truth, and the state of the first collapsed chain as black ellipses."""
    draws = results.chains["collapsed"][0]
    label = draws.labels[sweep]
    for k in range(len(CENTRES)):
        x, y = results.points[k * EACH : (k + 1) * EACH].T
        axes.scatter(x, y, s=5, color=PALETTE[k], alpha=0.7, linewidths=0)
    for k in range(int(label.max()) + 1):
        if np.mean(label == k) > WEIGHTY:
            axes.add_patch(two_sigma(base.posterior(results.points[label == k]), 0.6 if sweep == 0 else 1.4))
    above = int(draws.clusters_above(WEIGHTY)[sweep])
    axes.set_title(f"{'start' if sweep == 0 else f'sweep {sweep}'}: {above} clusters", fontsize=10)
    axes.set(aspect="equal", xticks=[], yticks=[], xlim=(-9, 10), ylim=(-9, 10))
    axes.grid(False)


def two_sigma(law: NormalInverseWishart, line: float) -> Ellipse:
    """Outline at two standard deviations of the posterior mean covariance."""
    width, axes = np.linalg.eigh(law.scale / (law.degrees - law.dimension - 1))
    angle = float(np.degrees(np.arctan2(axes[1, 1], axes[0, 1])))
    along, across = 4 * np.sqrt(width[::-1])
    return Ellipse(tuple(law.mean), along, across, angle=angle, fill=False, edgecolor="black", linewidth=line)


def traces(axes: Axes, results: Results) -> None:
    """K against sweep."""
    lines(axes, results, lambda draws: draws.n_clusters)
    axes.axhline(5, color=INK, linewidth=0.9, linestyle=":")
    axes.set(title="All clusters K, singletons included", xlabel="sweep", ylabel="clusters", ylim=(0, None))
    axes.yaxis.set_major_locator(MultipleLocator(5))
    entries = [Line2D([], [], color=COLOURS[kind], label=NAMES[kind]) for kind in NAMES]
    axes.legend(handles=[*entries, Line2D([], [], color=INK, linestyle=":", linewidth=0.9, label="truth: 5")])


def weighty_traces(axes: Axes, results: Results) -> None:
    """Clusters above 2 % against sweep."""
    lines(axes, results, lambda draws: draws.clusters_above(WEIGHTY))
    axes.axhline(5, color=INK, linewidth=0.9, linestyle=":")
    middle = median(sweeps_to_truth(draws) for kind in EXACT for draws in results.chains[kind])
    axes.set_title(f"Clusters above 2 %: exact samplers have the five at {when(middle)}")
    axes.set(xlabel="sweep", ylabel="clusters", ylim=(0, None))
    axes.yaxis.set_major_locator(MultipleLocator(5))


def joint(axes: Axes, results: Results) -> None:
    """Log joint against sweep."""
    lines(axes, results, lambda draws: draws.log_joint)
    level = usual_log_joint(results)
    middle = median(sweeps_to_flat(draws, level) for kind in EXACT for draws in results.chains[kind])
    axes.set_title(f"Log joint log p(data, partition): exact samplers level off at {when(middle)}")
    axes.set(xlabel="sweep", ylabel="nats")


def when(middle: float | None) -> str:
    """The median chain's sweep in words."""
    return "no sweep" if middle is None else f"sweep {middle:g}"


def lines(axes: Axes, results: Results, value: Callable[[MixtureDraws], Ints | Floats]) -> None:
    for kind in ("literal", *EXACT):
        for draws in results.chains[kind]:
            axes.plot(value(draws), color=COLOURS[kind], linewidth=1.3, alpha=0.8)
    axes.set_xlim(0, SWEEPS)


def along_eta(axes: Axes, results: Results) -> None:
    """Number of clusters against η: posterior, its weighty part, the prior's expectation, and the printed form."""
    found = [clusters_by_eta(results, eta) for eta in CONCENTRATIONS]
    printed = [results.literal_from_truth[eta].n_clusters[SWEEPS] for eta in CONCENTRATIONS]
    fine = np.geomspace(1, 1e4, 80)
    prior = [expected_clusters(len(results.points), eta) for eta in fine]
    axes.plot(CONCENTRATIONS, printed, "^-", color=GREY, label="Algorithm 2 as printed, all clusters")
    axes.plot(fine, prior, color=INK, linestyle="--", linewidth=1.0, label="prior mean of K")
    axes.plot(CONCENTRATIONS, [row["all"] for row in found], "o-", color=PALETTE[2], label="exact, all clusters")
    above = [row["above_2_percent"] for row in found]
    axes.plot(CONCENTRATIONS, above, "s-", color=PALETTE[3], label="exact, clusters above 2 %")
    axes.axhline(5, color=INK, linewidth=0.9, linestyle=":")
    axes.set(xscale="log", yscale="symlog", xlabel="concentration η", ylabel="clusters", ylim=(-0.15, 420))
    axes.set_yticks([0, 1, 5, 10, 50, 100, 300], ["0", "1", "5", "10", "50", "100", "300"])
    axes.set_xticks(CONCENTRATIONS, [f"{eta:,.0f}" for eta in CONCENTRATIONS])
    axes.set_title("The answer depends on η (mean number of clusters)")
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 0.08))


if __name__ == "__main__":
    run("fig_2_1", experiment)

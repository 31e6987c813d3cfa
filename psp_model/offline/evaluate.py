"""What networks cost on the road: closed-loop regret on starts that they were not trained on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..law.potential import PotentialParameters
from ..parameters import PlatoonParameters
from ..selection.feasible import project
from ..selection.network import ParameterNetwork
from ..selection.rollout import as_rows, refined, share_rollouts
from ..selection.search.engine import Engine
from .errors import OfflineError
from .parquet import Dataset
from .ranking import choose_dictionary, dictionary_triples
from .recipes import output_scaling, regrets

Array = NDArray[Any]


@dataclass(frozen=True)
class Answers:
    """What one way to choose alpha, r, p does for B starts.

    Attributes
    ----------
    name : of the way
    raw : (B, 3) triples as proposed, before projection; as used where rollouts chose them
    triples : (B, 3) as used
    J, T_max : (B,) from rollouts in float64
    rows : which starts of the data set these are
    """

    name: str
    raw: Array
    triples: Array
    J: Array
    T_max: Array
    rows: Array


@dataclass(frozen=True)
class Score:
    """The figures that go into the table.

    Attributes
    ----------
    name : of the way to choose
    starts : how many it was judged on
    mean, median, p95, worst : regret J/J* - 1
    beats_fixed : share of starts with a lower J than the best fixed triple
    projected : share of answers that had to be projected into the feasible set
    out_of_domain : share of starts outside the network's domain
    mse : mean squared error against the optima, of alpha, r, p scaled to [0, 1] by their bounds
    smallest_T_max : over all starts and sampling instants [s]
    """

    name: str
    starts: int
    mean: float
    median: float
    p95: float
    worst: float
    beats_fixed: float
    projected: float
    out_of_domain: float
    mse: tuple[float, float, float]
    smallest_T_max: float


@dataclass
class Evaluation:
    """Answers of several ways to choose on one data set, the best fixed triple first.

    Attributes
    ----------
    data : starts with their optima
    answers : in the order of the table
    out_of_domain : by name of the answers, shares of starts outside the network's domain
    """

    data: Dataset
    answers: list[Answers] = field(default_factory=list)
    out_of_domain: dict[str, float] = field(default_factory=dict)

    def regret(self, answers: Answers) -> Array:
        """J/J* - 1 of each start."""
        return np.asarray(answers.J / self.data.J[answers.rows] - 1.0)

    def score(self, answers: Answers) -> Score:
        """The figures of one way to choose."""
        regret, fixed = self.regret(answers), self.answers[0]
        _, scale = output_scaling(self.data.problem)
        error = (answers.raw - self.data.triples[answers.rows]) / scale
        mse = tuple(float(value) for value in (error**2).mean(axis=0))
        return Score(
            answers.name,
            len(regret),
            float(regret.mean()),
            float(np.median(regret)),
            float(np.percentile(regret, 95)),
            float(regret.max()),
            float((fixed.J[answers.rows] > answers.J).mean()),
            float((answers.raw.astype(np.float32) != answers.triples.astype(np.float32)).any(axis=1).mean()),
            self.out_of_domain.get(answers.name, 0.0),
            (mse[0], mse[1], mse[2]),
            float(answers.T_max.min()),
        )

    @property
    def scores(self) -> list[Score]:
        """The table."""
        return [self.score(answers) for answers in self.answers]


def best_fixed(data: Dataset) -> Array:
    """(3,) the one triple of the grid with the least mean regret over a data set (ours)."""
    regret = regrets(data, 0.5).reshape(len(data.J), -1)
    return np.asarray(dictionary_triples(data, choose_dictionary(regret, 1))[0])


def projected(raw: Array, constants: PlatoonParameters) -> Array:
    """Each triple inside the feasible set (ours, by `feasible.project`).

    Parameters
    ----------
    raw : (N, 3) array, alpha [1], r [m], p [1], finite

    Returns
    -------
    (N, 3) array
    """
    return as_rows([project(PotentialParameters(*map(float, row)), constants) for row in raw])


class Judge:
    """Rolls out answers on the starts of one data set."""

    def __init__(self, data: Dataset, threads: int | None = None):
        if not len(data.J):
            raise OfflineError("this data set holds no solved start: make a larger one")
        self.data, self.engine = data, Engine(data.problem, "double", threads)
        self.evaluation = Evaluation(data)
        self.fixed("best fixed triple", best_fixed(data))

    def add(self, name: str, raw: Array, rows: Array | None = None) -> Answers:
        """Judge triples, one for each of some starts.

        Parameters
        ----------
        name : of the way that chose them
        raw : (B, 3) array, alpha [1], r [m], p [1], as proposed
        rows : (B,) array, the starts they belong to; all by default
        """
        rows = np.arange(len(self.data.J)) if rows is None else rows
        triples = projected(raw, self.data.problem.constants)
        J, T_max = self.engine.costs(self.data.starts[rows], np.arange(len(rows)), triples)
        self.evaluation.answers.append(Answers(name, raw, triples, J, T_max, rows))
        return self.evaluation.answers[-1]

    def fixed(self, name: str, triple: Array) -> None:
        """Judge one triple for all starts.

        Parameters
        ----------
        name : of the way that chose it
        triple : (3,) array, alpha [1], r [m], p [1]
        """
        self.add(name, np.tile(triple, (len(self.data.J), 1)))

    def network(self, name: str, network: ParameterNetwork) -> None:
        """Judge a network's first answer.

        Parameters
        ----------
        name : in the table
        network : that answers
        """
        self._note_domain(name, network)
        self.add(name, as_rows([network.evaluate(s, v) for s, v in self._split()]))

    def rollout(self, name: str, network: ParameterNetwork, rollouts: int) -> None:
        """Judge the best of a network's candidates with refinement, as `parameter_source` 3 takes it.

        Parameters
        ----------
        name : in the table
        network : whose candidates are rolled out
        rollouts : how many a start may cost
        """
        self._note_domain(name, network)
        count, rounds = share_rollouts(rollouts)
        candidates = np.array([as_rows(network.candidates(s, v, count)) for s, v in self._split()])
        chosen, rows = refined(self._tried, candidates, rounds), np.arange(len(candidates))
        J, T_max = self._certified(rows, chosen)
        self.evaluation.answers.append(Answers(name, chosen, chosen, J, T_max, rows))

    def _tried(self, raw: Array) -> tuple[Array, Array]:
        """Projected triples (B, K, 3), K for each start, with their (B, K) J, infinite where not certified."""
        distinct, inverse = np.unique(raw.reshape(-1, 3), axis=0, return_inverse=True)
        triples = projected(distinct, self.data.problem.constants)[inverse.ravel()]
        J, _ = self._certified(np.repeat(np.arange(len(raw)), raw.shape[1]), triples)
        return triples.reshape(raw.shape), J.reshape(raw.shape[:2])

    def _certified(self, which: Array, triples: Array) -> tuple[Array, Array]:
        """J of rollouts, infinite where T is not certified throughout, and their smallest T_max."""
        J, T_max = self.engine.costs(self.data.starts, which, triples)
        return np.where(T_max > self.data.problem.T, J, np.inf), T_max

    def _split(self) -> list[tuple[Array, Array]]:
        spacings = self.data.problem.vehicles - 1
        return [(start[:spacings], start[spacings:]) for start in self.data.starts]

    def _note_domain(self, name: str, network: ParameterNetwork) -> None:
        network.require_vehicles(self.data.problem.vehicles)
        spacings = self.data.problem.vehicles - 1
        inside = network.domain.contains(self.data.starts.T[:spacings], self.data.starts.T[spacings:])
        self.evaluation.out_of_domain[name] = float(1.0 - inside.mean())


def as_markdown(scores: Sequence[Score]) -> str:
    """The table for model cards and README."""
    head = "| way to choose alpha, r, p | starts | mean | median | 95 % | worst | beats fixed | projected "
    lines = [head + "| MSE alpha, r, p | smallest T_max |", "|" + "---|" * 10]
    for score in scores:
        regret = " | ".join(f"{100 * value:.2f} %" for value in (score.mean, score.median, score.p95, score.worst))
        mse = ", ".join(f"{value:.4f}" for value in score.mse)
        shares = f"{100 * score.beats_fixed:.0f} % | {100 * score.projected:.0f} %"
        lines.append(f"| {score.name} | {score.starts} | {regret} | {shares} | {mse} | {score.smallest_T_max:.4f} s |")
    return "\n".join(lines)


def as_dict(evaluation: Evaluation) -> dict[str, Any]:
    """The table as data, for JSON."""
    return {"data_sha256": evaluation.data.sha256, "scores": [asdict(score) for score in evaluation.scores]}

"""The functions of the package: plan, check, verify, compare."""

from __future__ import annotations

import itertools
import json
import os
from dataclasses import dataclass, field
from typing import Any, Callable, Mapping, NamedTuple, Sequence, Union

import numpy as np

from . import _slewkit
from ._errors import OF_STATUS, Diagnostic, FileError, PlanError, SpecError, VerificationFailed
from ._plan import Plan, content, load
from ._problem import Problem, SpecLike, maneuver_of


class Progress(NamedTuple):
    """The progress of the work."""

    #: The current stage: ``"newton"``, ``"descent"``, ``"scp"``, ``"witnesses"`` and so on.
    stage: str
    #: The current start, such as ``"short"``.
    start: str
    #: Steps of the grid; for a simulation the finished steps.
    steps: int
    #: Seconds since the work began.
    elapsed: float
    #: The part of a sequence that is planned, such as ``"leg 3 of 9"``; empty for a single maneuver.
    part: str = ""


#: Called with the progress of the work, at once and then at most twenty times a second. A return
#: value of ``False``, or an exception, stops the work.
ProgressFunction = Callable[[Progress], Union[bool, None]]

#: A guess: a plan, the path of a plan file or of attitudes, or 6 (12) costates.
GuessLike = Union[Plan, str, "os.PathLike[str]", Sequence[float]]


def plan(
    spec: SpecLike,
    *,
    guess: GuessLike | None = None,
    guess_alone: bool = False,
    progress: ProgressFunction | None = None,
    overrides: Mapping[str, Any] | None = None,
    strict: bool = True,
) -> Plan:
    """Plans a maneuver and verifies the plan. The result is identical to that of ``slew plan``.

    ``spec`` is a dictionary with the keys of a spec, the path of a spec file, or a
    :class:`Problem`. ``guess`` is a plan of a neighbouring maneuver: a :class:`Plan`, a plan file,
    a file of attitudes, or costates; the search begins from it too, and returns the cheapest plan.
    With ``guess_alone`` no other start is searched if the costates of the guess lead to a plan:
    quicker, but a cheaper plan may exist. ``overrides`` sets keys of the spec:
    ``{"maneuver.duration_s": 90}``. Other threads run meanwhile; Ctrl-C raises KeyboardInterrupt,
    with the best iterate in its attribute ``plan``.

    Returns a plan that is solved and verified, and raises otherwise: :class:`SpecError`,
    :class:`FileError`, :class:`Infeasible`, :class:`NotSolved`, :class:`LimitReached`,
    :class:`VerificationFailed`, :class:`Interrupted`. The exceptions of a solve have the best
    result in ``plan``. With ``strict=False`` the function returns the plan in every case, with its
    ``status``.
    """
    maneuver = maneuver_of(spec, overrides)
    planned, raised = _slewkit.plan(maneuver, _suggestion(guess), guess_alone, _told(progress))
    found = Plan(planned)
    if raised is not None:
        raised.plan = found  # type: ignore[attr-defined]
        raise raised
    if strict and planned.exit_code != 0:
        raise _failure(found)
    return found


def _failure(found: Plan) -> PlanError:
    """Builds the exception for a plan that is not solved."""
    label = {"infeasible": "because", "verification_failed": "failed"}.get(found.status, "stopped")
    # A label stands after two spaces, and the lines that continue its text are indented further.
    _, _, text = found.summary().partition(f"\n  {label}")
    first, *rest = text.splitlines() or [found.status]
    continued = itertools.takewhile(lambda line: line.startswith("      "), rest)
    reason = " ".join(line.strip() for line in [first, *continued])
    error = OF_STATUS[found.status]("", f"{found.name}: {found.status.replace('_', ' ')}: {reason}")
    error.plan = found
    return error


def check(spec: SpecLike, *, overrides: Mapping[str, Any] | None = None) -> list[Diagnostic]:
    """Returns all errors and warnings of the spec of a maneuver or a simulation; an empty list for
    a valid spec.

    Raises :class:`FileError` if a file cannot be read.
    """
    try:
        if isinstance(spec, Problem):
            found = spec._maneuver.again(overrides).warnings()
        else:
            found = _slewkit.diagnose(spec, overrides)
    except SpecError as error:
        return error.diagnostics
    return [Diagnostic(**keys) for keys in found]


@dataclass(frozen=True)
class Verification:
    """The results of the witnesses for a plan."""

    #: ``"solved"`` or ``"verification_failed"``.
    status: str
    #: Steps of the plan; for attitudes one less than the rows.
    steps: int
    #: Errors, orders, margins and checks with the keys of a plan file. Numbers that are not finite are None.
    found: dict[str, Any]
    #: Keys in which the spec of the plan and the one it was judged by differ: ``key``, ``first``, ``second``.
    differences: list[dict[str, str]]
    #: Keys of the plan file whose record differs from the result: ``key``, ``first`` of the file, ``second`` as found.
    recorded: list[dict[str, str]] = field(default_factory=list)
    #: The items that were not judged, a sentence each.
    not_judged: list[str] = field(default_factory=list)

    @property
    def passed(self) -> bool:
        """Whether every check passes."""
        return self.status == "solved"

    @property
    def checks(self) -> list[dict[str, Any]]:
        """Every check: ``name``, ``value``, ``limit``, ``passed``."""
        return list(self.found["checks"])

    @property
    def margins(self) -> list[dict[str, Any]]:
        """Every limit and constraint with its smallest margin; empty if only attitudes were
        judged."""
        return list(self.found.get("margins", []))

    @property
    def violations(self) -> list[str]:
        """The constraints that the attitudes violate, one sentence each; a plan has ``margins`` instead."""
        return list(self.found.get("violations", []))


def verify(
    plan: Plan | str | os.PathLike[str] | Mapping[str, Any],
    spec: SpecLike | None = None,
    *,
    overrides: Mapping[str, Any] | None = None,
    progress: ProgressFunction | None = None,
    strict: bool = False,
) -> Verification:
    """Checks a plan, a plan file, or the dictionary of a plan file by independent witnesses, against
    its own spec or another, as ``slew verify`` does. They do not judge whether the plan is optimal.

    The path may also name an AEM or a table of attitudes, with the ``spec`` that the attitudes must
    meet. Ends, duration, cones and rates are then judged, and ``found`` has ``checks``,
    ``violations`` as sentences and ``peak_torque_n_m``.

    A plan that fails is returned; with ``strict`` it raises :class:`VerificationFailed`. A plan
    whose arrays do not fit the maneuver always raises it.
    """
    if isinstance(plan, (str, os.PathLike)):
        bytes, name = content(plan)
        if not _slewkit.is_plan(bytes):
            if spec is None:
                raise ValueError("a file of attitudes has no targets and limits: give the spec")
            return _judged(_slewkit.verify_attitudes(bytes, name, maneuver_of(spec, overrides)), None, strict)
    try:
        judged = plan if isinstance(plan, Plan) else load(plan)
    except FileError as error:
        if error.code != "E0103":
            raise
        raise VerificationFailed(error.code, error.reason, "give a plan whose arrays fit its spec") from error
    if spec is None and overrides:
        spec = judged.spec
    maneuver = None if spec is None else maneuver_of(spec, overrides)
    text, raised = _slewkit.verify(judged._planned, maneuver, _told(progress))
    if raised is not None:
        raise raised
    return _judged(text, judged, strict)


def _judged(text: str, judged: Plan | None, strict: bool) -> Verification:
    document = json.loads(text)
    if document["status"] == "interrupted":
        raise OF_STATUS["interrupted"]("", f"{document['name']}: interrupted")
    found = Verification(
        document["status"],
        document["steps"],
        document["verified"],
        document["differences"],
        document["recorded"],
        document["not_judged"],
    )
    if strict and not found.passed:
        failed = [check["name"] for check in found.checks if not check["passed"]] + found.violations
        disagrees = VerificationFailed("", f"{document['name']}: verification failed: {', '.join(failed)}")
        disagrees.plan = judged
        raise disagrees
    return found


@dataclass(frozen=True)
class Comparison:
    """A comparison of methods on one maneuver."""

    #: ``"solved"`` if at least one method solved and those that did agree; else a status of a plan.
    status: str
    #: Every method with its result, with the keys of ``slew compare --format json``.
    methods: list[dict[str, Any]]
    #: The agreement of the methods.
    agreement: dict[str, Any]


def compare(
    spec: SpecLike,
    *,
    overrides: Mapping[str, Any] | None = None,
    progress: ProgressFunction | None = None,
) -> Comparison:
    """Solves a maneuver by every method that applies, as ``slew compare`` does: Newton shooting,
    sequential convex programming to its own convergence, and SCP with final Newton iterations."""
    text, raised = _slewkit.compare(maneuver_of(spec, overrides), _told(progress))
    if raised is not None:
        raise raised
    document = json.loads(text)
    return Comparison(document["status"], document["methods"], document["agreement"])


@dataclass(frozen=True)
class IntegratorComparison:
    """A comparison of integrators on one motion: the work of each at equal error."""

    #: The energy to which errors are relative, J.
    energy_scale_j: float
    #: Mean energy errors at which work is compared.
    levels: list[float]
    #: A row for each integrator, step and horizon, with the keys of ``slew compare --format json``.
    runs: list[dict[str, Any]]
    #: A row for each horizon, level and integrator: work at equal error.
    equal_error: list[dict[str, Any]]
    #: The tables that ``slew compare`` prints.
    table: str

    def __str__(self) -> str:
        return self.table


def compare_integrators(
    spec: Mapping[str, Any] | str | os.PathLike[str],
    *,
    integrators: Sequence[str] = (),
    steps: Sequence[float] = (),
    horizons: Sequence[float] = (),
    errors: Sequence[float] = (),
    overrides: Mapping[str, Any] | None = None,
    progress: ProgressFunction | None = None,
) -> IntegratorComparison:
    """Compares work and precision of integrators on the motion of a simulation spec, as ``slew
    compare`` does.

    ``integrators`` are names; the others are compared with the first; ``steps`` in seconds, longest
    first; ``horizons`` in seconds, shortest first, whole numbers of every step; ``errors`` are the
    mean energy errors at which work is compared, largest first. The spec supplies values that are
    not given. Raises ValueError if the values do not make a comparison, :class:`Interrupted` if
    ``progress`` stops it."""
    floats = [[float(number) for number in given] for given in (steps, horizons, errors)]
    text, raised = _slewkit.compare_integrators(
        spec, overrides, list(integrators), floats[0], floats[1], floats[2], _told(progress)
    )
    if raised is not None:
        raise raised
    document = json.loads(text)
    if document["status"] == "interrupted":
        raise OF_STATUS["interrupted"]("", f"{document['name']}: interrupted")
    keys = ("energy_scale_j", "levels", "runs", "equal_error", "table")
    return IntegratorComparison(*(document[key] for key in keys))


def _told(progress: ProgressFunction | None) -> Callable[..., bool | None] | None:
    return None if progress is None else lambda *told: progress(Progress(*told))


def _suggestion(guess: GuessLike | None) -> Any:
    if guess is None:
        return None
    if isinstance(guess, Plan):
        return guess._planned
    if isinstance(guess, (str, os.PathLike)):
        return content(guess)
    return np.asarray(guess, dtype=float).ravel().tolist()

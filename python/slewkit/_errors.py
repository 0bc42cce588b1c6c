"""The exceptions, one class for each exit code of the program ``slew``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

if TYPE_CHECKING:
    from ._plan import Plan


@dataclass(frozen=True)
class Diagnostic:
    """One finding about a spec: the place, the reason and the remedy."""

    #: Stable code, ``"E0040"`` or ``"W0040"``; ``slew explain CODE`` explains it.
    code: str
    #: ``"error"`` or ``"warning"``.
    severity: str
    #: The reason, with the numbers.
    reason: str
    #: The remedy.
    remedy: str
    #: The name of the file; ``"dict"`` for a dictionary, whose line and column refer to the notation of
    #: ``Problem.to_toml``; ``"command line"`` for an override.
    file: str = ""
    #: Line, from 1; 0 if the finding has no place.
    line: int = 0
    #: Column in characters, from 1; 0 if the finding has no place.
    column: int = 0
    #: Key path, as in ``"maneuver.steps"``; empty if it concerns no key.
    key: str = ""
    #: The offending text.
    text: str = ""
    #: The finding as the program prints it.
    rendered: str = ""

    def __str__(self) -> str:
        return self.rendered or f"{self.severity}[{self.code}]: {self.reason}\n help: {self.remedy}"


class SlewError(Exception):
    """The base of all exceptions of this package."""

    #: Exit code of the program for the same failure.
    exit_code: ClassVar[int] = 1
    #: Stable code of the message, if it has one.
    code: str
    #: The reason.
    reason: str
    #: The remedy.
    remedy: str

    def __init__(self, code: str = "", reason: str = "", remedy: str = "") -> None:
        super().__init__(code, reason, remedy)
        self.code, self.reason, self.remedy = code, reason, remedy

    def __str__(self) -> str:
        coded = f"[{self.code}] {self.reason}" if self.code else self.reason
        return f"{coded}; {self.remedy}" if self.remedy else coded


class InternalError(SlewError):
    """A bug of the program, not a mistake of the user (exit code 1)."""


class SpecError(SlewError, ValueError):
    """A wrong spec, with all its errors (exit code 3)."""

    exit_code = 3
    #: All findings, in the order of the file.
    diagnostics: list[Diagnostic]

    def __init__(self, text: str, diagnostics: list[dict[str, Any]]) -> None:
        found = [Diagnostic(**keys) for keys in diagnostics]
        errors = [one for one in found if one.severity == "error"] or found
        first = errors[0] if errors else Diagnostic("", "error", text, "")
        super().__init__(first.code, first.reason, first.remedy)
        self.args = (text, diagnostics)
        self.diagnostics = found
        self._text = text

    def __str__(self) -> str:
        return self._text.rstrip()


class FileError(SlewError, OSError):
    """A file that cannot be read or written, or has the wrong contents (exit code 8)."""

    exit_code = 8

    def __init__(self, code: str = "", reason: str = "", remedy: str = "") -> None:
        # With three arguments OSError would take them for number, text and file name.
        OSError.__init__(self, reason)
        self.args = (code, reason, remedy)
        self.code, self.reason, self.remedy = code, reason, remedy


class PlanError(SlewError):
    """A maneuver without a solved and verified plan. ``plan`` has the best result."""

    #: The result, with the best iterate and all attempts.
    plan: Plan | None = None


class Infeasible(PlanError):
    """A proof shows that no plan exists; ``reason`` states it (exit code 4)."""

    exit_code = 4


class NotSolved(PlanError):
    """No extremal was found, which proves nothing; ``plan`` is the best iterate (exit code 5)."""

    exit_code = 5


class LimitReached(PlanError):
    """The time limit ended the search (exit code 6)."""

    exit_code = 6


class VerificationFailed(PlanError):
    """Solved, but a witness disagrees (exit code 7)."""

    exit_code = 7


class NotFinite(SlewError):
    """A simulation produced a number that is not finite; ``simulation`` has the rows before it
    (exit code 9)."""

    exit_code = 9
    #: The rows before it.
    simulation: Any = None


class Interrupted(PlanError):
    """The progress function stopped the work; ``plan`` is the best iterate (exit code 130)."""

    exit_code = 130
    #: The rows of a simulation so far.
    simulation: Any = None


class SpecWarning(UserWarning):
    """A warning about an accepted spec."""


#: The exception for each status of a plan except ``"solved"``.
OF_STATUS: dict[str, type[PlanError]] = {
    "infeasible": Infeasible,
    "not_converged": NotSolved,
    "limit_reached": LimitReached,
    "verification_failed": VerificationFailed,
    "interrupted": Interrupted,
}

"""Optimal attitude maneuvers of a rigid body, planned with Lie group variational integrators and
independently verified.

::

    import slewkit

    plan = slewkit.plan({
        "format": 1,
        "body": {"inertia_kg_m2": [120, 100, 80]},
        "start": {"attitude": {"axis": [0, 0, 1], "angle_deg": 0}},
        "end": {"attitude": {"euler_zyx_deg": [30, -40, 70]}},
        "maneuver": {"duration_s": 60, "steps": 200},
    })
    print(plan.cost, plan.torque[0], plan.rotation()[-1].as_rotvec())

Units are SI and radians; the keys of specs state them. Attitudes map body to reference components;
quaternions have the order of SciPy, ``[x, y, z, w]``, unless ``scalar_first`` is given. Angular
velocities, torques and inertias are in body axes; positions, velocities and forces in reference
axes. Results equal the results of the program ``slew``, bit by bit.
"""

from ._commands import (
    Comparison,
    IntegratorComparison,
    Progress,
    Verification,
    check,
    compare,
    compare_integrators,
    plan,
    verify,
)
from ._errors import (
    Diagnostic,
    FileError,
    Infeasible,
    InternalError,
    Interrupted,
    LimitReached,
    NotFinite,
    NotSolved,
    PlanError,
    SlewError,
    SpecError,
    SpecWarning,
    VerificationFailed,
)
from ._flown import Flights, closed_loop
from ._plan import Plan, load
from ._problem import Problem
from ._sequence import SequencePlan, plan_sequence
from ._simulation import Body, Simulation, simulate
from ._slew_table import SlewTable
from ._slewkit import __version__

__all__ = [
    "Body",
    "Comparison",
    "Diagnostic",
    "FileError",
    "Flights",
    "Infeasible",
    "IntegratorComparison",
    "InternalError",
    "Interrupted",
    "LimitReached",
    "NotFinite",
    "NotSolved",
    "Plan",
    "PlanError",
    "Problem",
    "Progress",
    "SequencePlan",
    "Simulation",
    "SlewError",
    "SlewTable",
    "SpecError",
    "SpecWarning",
    "Verification",
    "VerificationFailed",
    "__version__",
    "check",
    "closed_loop",
    "compare",
    "compare_integrators",
    "load",
    "plan",
    "plan_sequence",
    "simulate",
    "verify",
]

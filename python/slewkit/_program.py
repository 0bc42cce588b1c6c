"""The program ``slew``, which the wheel contains."""

import signal
import sys

from ._slewkit import run_program


def main() -> int:
    """Runs ``slew`` with the arguments of this process, and returns its exit code."""
    # Python would record Ctrl-C and wait for the program to return; the system must end the program
    # instead.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return run_program(["slew", *sys.argv[1:]])

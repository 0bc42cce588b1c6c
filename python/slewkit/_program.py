"""The program ``slew``, which the wheel brings along."""

import signal
import sys

from ._slewkit import run_program


def main() -> int:
    """Runs ``slew`` with the arguments of this process, and gives its exit code."""
    # Python would note Ctrl-C and wait for the program to come back: it is to end what does not listen.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return run_program(["slew", *sys.argv[1:]])

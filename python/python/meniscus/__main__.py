"""The command ``meniscus``, also as ``python -m meniscus``."""

import signal
import sys

from ._meniscus import command


def main() -> int:
    """Runs the command with the arguments of this process and returns its exit status."""
    # The command has a handler of its own, which ends a run with a checkpoint.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return command(sys.argv[1:], [sys.executable, "-m", "meniscus"])


if __name__ == "__main__":
    sys.exit(main())

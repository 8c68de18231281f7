"""Where the `lola` command begins.

In every tick Drake and its Python bindings allocate and free some 2,700 blocks of memory. Of each
size glibc keeps only seven at hand, and looks for the others; with more of them, and on huge pages,
the closed loop is 6 % faster. Both are settled when a process begins, so the command begins twice.
"""

import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager

_TUNABLES = "GLIBC_TUNABLES"
_MALLOC = "glibc.malloc.tcache_count=127:glibc.malloc.hugetlb=1"

INTERRUPTED = 130
"""Exit code after Ctrl-C, as shells give it."""


def main() -> None:
    """Run the `lola` command; a user's own GLIBC_TUNABLES are left alone."""
    if sys.platform == "linux" and _TUNABLES not in os.environ:
        os.environ[_TUNABLES] = _MALLOC
        os.execv(sys.executable, [sys.executable, *sys.orig_argv[1:]])
    with _quiet_end():
        from lola_drake.cli.app import app

        app(prog_name="lola")


@contextmanager
def _quiet_end() -> Iterator[None]:
    """End after Ctrl-C or SIGTERM with one line, whatever they turn into on their way.

    In the middle of the import of a library of C++ they become errors of quite another kind.
    """
    stopped = []

    def stop(*_) -> None:
        stopped.append(True)
        raise KeyboardInterrupt

    for number in (signal.SIGINT, signal.SIGTERM):
        if signal.getsignal(number) != signal.SIG_IGN:
            signal.signal(number, stop)
    try:
        yield
    except BaseException as error:
        told = isinstance(error, SystemExit)
        if told or not (stopped or isinstance(error, KeyboardInterrupt)):
            raise
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, signal.SIG_IGN)
        print("lola: stopped", file=sys.stderr)
        sys.exit(INTERRUPTED)


if __name__ == "__main__":
    main()

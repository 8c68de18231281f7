"""Where the `lola` command begins.

In every tick Drake and its Python bindings allocate and free some 2,700 blocks of memory. Of each
size glibc keeps only seven at hand, and looks for the others; with more of them, and on huge pages,
the closed loop is 6 % faster. Both are settled when a process begins, so the command begins twice.
"""

import os
import sys

_TUNABLES = "GLIBC_TUNABLES"
_MALLOC = "glibc.malloc.tcache_count=127:glibc.malloc.hugetlb=1"


def main() -> None:
    """Run the `lola` command; a user's own GLIBC_TUNABLES are left alone."""
    if sys.platform == "linux" and _TUNABLES not in os.environ:
        os.environ[_TUNABLES] = _MALLOC
        os.execv(sys.executable, [sys.executable, *sys.orig_argv[1:]])

    from lola_drake.cli.app import app

    app(prog_name="lola")


if __name__ == "__main__":
    main()

"""What the workers of a study are given to do in tests, and a look at them; quick to import."""

import os
import signal
import time
from pathlib import Path

from lola_drake.errors import LolaError
from lola_drake.interruption import interruption


def squared(x):
    return x * x


def killed_at_two(x):
    if x == 2:
        os.kill(os.getpid(), signal.SIGKILL)
    return x


def killed_at_first(x):
    """End this process, but for a file that says that it has happened before."""
    if not Path(x).exists():
        Path(x).touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return x


def asked_at_first(x):
    """Ask this process to end, but for a file that says that it has happened before."""
    if not Path(x).exists():
        Path(x).touch()
        os.kill(os.getpid(), signal.SIGTERM)
    return x


def slowly(x):
    time.sleep(0.05)
    return x


def refused(x):
    raise LolaError("no such thing")


def until_asked(x):
    """Go on until somebody asks for the end, as a run does; a file says that it has begun."""
    with interruption() as interrupted:
        Path(x).touch()
        while not interrupted.is_set():
            time.sleep(0.01)
    return x


def process_of(x):
    return os.getpid()


def wait_for_end(pid):
    """Wait until a process is gone, or nothing but an entry in a table."""
    for _ in range(1000):
        try:
            os.kill(pid, 0)
            with open(f"/proc/{pid}/stat") as stat:
                if stat.read().split()[2] == "Z":
                    return
        except (ProcessLookupError, FileNotFoundError):
            return
        time.sleep(0.01)
    raise AssertionError("the process goes on")

"""Kills at random moments, and what they leave: python tests/kills.py [COUNT] [SEED].

Each starts a command in an empty folder, sends it Ctrl-C, SIGTERM or SIGKILL, and looks at what it
says, at what lies there then, and whether a process goes on.
"""

import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from lola_drake.errors import LolaError
from lola_drake.results import UNFINISHED, load_result
from lola_drake.studies.study import Study

COMMANDS = {
    "simulate": ("simulate", "stand", "--set", "duration=2.5", "--no-pictures"),
    "pictures": ("simulate", "stand", "--set", "duration=1.2", "--quiet"),
    "force": ("simulate", "stand", "--set", "duration=1.5", "--no-pictures", "--force"),
    "compare": ("compare", "stand", "--set", "duration=2.0"),
    "reproduce": ("reproduce", "-o", "runs/r"),
    "sweep": (
        *("sweep", "stand", "--vary", "control.com_dynamics.gain=0.2,1.0", "--worlds", "2"),
        *("--set", "duration=1.0", "-o", "runs/s"),
    ),
}
LONGEST = {"reproduce": 30.0, "sweep": 14.0, "compare": 14.0}
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGKILL)
PATIENCE = 300.0


def kill(name: str, number: int, after: float, folder: Path) -> list[str]:
    """Start a command, and end it by a signal after some seconds; return what is wrong then."""
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    if name == "force":
        before = subprocess.run(
            [sys.executable, "-m", "lola_drake", *COMMANDS[name], "--set", "duration=0.1"],
            cwd=folder,
            env=environment,
            capture_output=True,
        )
        assert before.returncode == 0, before.stderr
    process = subprocess.Popen(
        [sys.executable, "-m", "lola_drake", *COMMANDS[name]],
        cwd=folder,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        start_new_session=True,
    )
    try:
        process.wait(after)
    except subprocess.TimeoutExpired:
        # A terminal sends Ctrl-C to all of its processes.
        os.killpg(process.pid, number) if number == signal.SIGINT else process.send_signal(number)
    try:
        said = process.communicate(timeout=PATIENCE)[1].decode()
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        return [f"still there after {PATIENCE:.0f} s"]
    return [*_said(process.returncode, number, said), *_going_on(process.pid), *_left(folder)]


def _said(code: int, number: int, text: str) -> list[str]:
    wrong = [] if "Traceback" not in text else [f"a traceback: {text[-600:]}"]
    # Python ends itself by SIGINT where a stop came in the middle of an import of Drake; a signal
    # before the program begins, or behind its end, is none of its own.
    stopped = {-signal.SIGKILL} if number == signal.SIGKILL else {130, -signal.SIGINT, -number}
    allowed = {0, *stopped}
    if text.count("lola: ") > 1:
        wrong.append(f"more than one line: {text[-300:]}")
    return wrong if code in allowed else [*wrong, f"exit code {code}: {text[-300:]}"]


def _going_on(session: int) -> list[str]:
    """Return the processes of a session that are still there after a moment."""
    for _ in range(50):
        left = [number for number in map(int, filter(str.isdigit, os.listdir("/proc")))]
        left = [number for number in left if _session(number) == session]
        if not left:
            return []
        time.sleep(0.1)
    os.killpg(session, signal.SIGKILL)
    return [f"processes go on: {left}"]


def _session(process: int) -> int | None:
    try:
        fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return None
    return int(fields[3]) if fields[0] != "Z" else None


def _left(folder: Path) -> list[str]:
    """Return what is wrong with what lies in a folder."""
    wrong = []
    for path in folder.rglob("summary.json"):
        name = path.parent.relative_to(folder)
        try:
            result = load_result(path.parent)
            sizes = {len(values) for values in result.signals.values()}
            finite = all(np.isfinite(values).all() for values in result.signals.values())
        except LolaError as error:
            wrong.append(f"{name}: {error}")
            continue
        if sizes != {len(result.times)} or not finite:
            wrong.append(f"{name}: {sizes} samples at {len(result.times)} times")
        whole = not any(part.endswith(".part") for part in name.parts)
        if whole and result.error == UNFINISHED:
            wrong.append(f"{name}: looks whole, and is not")
    for path in folder.rglob("*.sqlite"):
        try:
            Study(path)
        except LolaError as error:
            wrong.append(f"{path.name}: {error}")
    return wrong


def main(count: int = 12, seed: int = 0) -> None:
    """Kill so many commands; print what is wrong with what they leave."""
    random = np.random.default_rng(seed)
    failed = 0
    for i in range(count):
        name = str(random.choice(list(COMMANDS)))
        number = SIGNALS[random.integers(len(SIGNALS))]
        after = float(random.uniform(0.0, LONGEST.get(name, 8.0)))
        with tempfile.TemporaryDirectory() as folder:
            wrong = kill(name, number, after, Path(folder))
            left = sorted(p.name for p in Path(folder).glob("runs/*"))
        failed += bool(wrong)
        print(i, name, signal.Signals(number).name, f"{after:.1f} s", left, *wrong, flush=True)
    print(f"{count} kills, {failed} of them leave what they must not")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))

"""Many runs in processes of their own: one that is killed does not take the others along.

The processes end with the one that started them, however it ends. A pool of joblib or of
`concurrent.futures` is broken as a whole when one of its processes is killed; here another one
takes its place, and its run begins again.
"""

import os
import pickle
import queue
import socket
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from lola_drake.errors import LolaError
from lola_drake.interruption import HEARD

PATIENCE = 60.0
"""How long runs that are asked to end may take for it (s)."""

RUNS = 25
"""Runs of a process, until another one takes its place: Drake never frees a diagram in which there
are systems of Python's, and each of them has meshes and a log."""

TRIES = 3
"""How often a run is begun whose process is killed again and again."""


class WorkerLost(LolaError):
    """A process that was ended from outside, while it worked."""


@dataclass(frozen=True)
class Done:
    """What came of one item.

    Attributes:
        index: its place among all.
        answer: of the function; a `WorkerLost` where all tries were in vain.
        worker: where it was done: process@machine.
        tries: how often it was begun.
    """

    index: int
    answer: Any
    worker: str
    tries: int = 1


Workers = Callable[[Callable, Sequence], Iterator[Done]]
"""Who calls a function with each of some items: gives what is done as it comes.

The function is one of a module, since other processes must find it. An error of it is raised. After
Ctrl-C what is under way is asked to end, and given as it is, before the interruption goes on.
"""


def worker_name(process: int | None = None) -> str:
    """Return how a process of this machine, or this one, is called."""
    return f"{process or os.getpid()}@{socket.gethostname()}"


def inline(function: Callable, items: Sequence) -> Iterator[Done]:
    """Do all in this process; it grows with every run, see `RUNS`."""
    HEARD.clear()
    for i, item in enumerate(items):
        yield Done(i, function(item), worker_name())
        if HEARD.is_set():
            raise KeyboardInterrupt


@dataclass(frozen=True)
class Processes:
    """Workers on this machine.

    Attributes:
        jobs: how many processes.
        patience: how long what is under way may take to its end after Ctrl-C (s).
    """

    jobs: int = 2
    patience: float = PATIENCE

    def __call__(self, function: Callable, items: Sequence) -> Iterator[Done]:
        """Give what is done as it comes, see `Workers`."""
        pool = _Pool(function, items, min(self.jobs, len(items)))
        try:
            yield from pool.answers(len(items))
        except KeyboardInterrupt:
            yield from pool.stopped(self.patience)
            raise
        finally:
            pool.end()


def in_order(
    jobs: int,
    function: Callable[[Any], Any],
    items: Sequence,
    done: Callable[[int, int], None] | None = None,
) -> list:
    """Return a function's answers in the order of its items, for computations that keep no record.

    Args:
        jobs: number of processes; one alone does it in this process.
        function: one of a module, or a partial of one.
        items: what it is called with.
        done: called with the number of finished items, and of all.

    Raises:
        WorkerLost: if the process of an item was ended from outside again and again.
    """
    workers = Processes(jobs, patience=0.0) if jobs > 1 else inline
    answers: list[Any] = [None] * len(items)
    for count, one in enumerate(workers(function, items), 1):
        if isinstance(one.answer, WorkerLost):
            raise one.answer
        answers[one.index] = one.answer
        if done:
            done(count, len(items))
    return answers


class _Worker:
    """A process, and the pipes to it."""

    def __init__(self):
        command = [sys.executable, "-m", "lola_drake.worker"]
        # It finds what this process finds, wherever that has been looked for.
        environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
        pipe = subprocess.PIPE
        # In a group of its own: a terminal's Ctrl-C is for the one that started it.
        self._process = subprocess.Popen(
            command, env=environment, stdin=pipe, stdout=pipe, process_group=0
        )

    @property
    def name(self) -> str:
        """Return how it is called in the record."""
        return worker_name(self._process.pid)

    def __call__(self, function: Callable, item: object) -> tuple[object, bool]:
        """Return the function's answer, and whether its end was asked for; or raise its error."""
        try:
            pickle.dump((function, item), self._process.stdin)
            self._process.stdin.flush()
            fine, answer, asked = pickle.load(self._process.stdout)
        except (OSError, EOFError, pickle.UnpicklingError):
            raise WorkerLost("its process was ended from outside") from None
        if not fine:
            raise answer
        return answer, asked

    def stop_run(self) -> None:
        """Ask for the end of what it does, with what is there."""
        self._process.terminate()

    def end(self) -> None:
        """End the process."""
        self._process.kill()
        self._process.wait()


class _Pool:
    """A thread for each process hands it one item after the other."""

    def __init__(self, function: Callable, items: Sequence, jobs: int):
        self._function, self._stopped = function, False
        self._done: queue.SimpleQueue = queue.SimpleQueue()
        self._items, self._lock = enumerate(items), threading.Lock()
        self._workers = [_Worker() for _ in range(jobs)]
        self._threads = [
            threading.Thread(target=self._serve, args=(k,), daemon=True) for k in range(jobs)
        ]
        for thread in self._threads:
            thread.start()

    def _serve(self, k: int) -> None:
        count = 0
        while (order := self._next()) is not None:
            if count and count % RUNS == 0:
                self._replace(k)
            count += 1
            try:
                self._done.put(self._answer(k, *order))
            except Exception as error:
                self._done.put(error)

    def _answer(self, k: int, i: int, item: object) -> Done:
        """Return what came of an item; whose process is lost is begun again in another one."""
        for tries in range(1, TRIES + 1):
            name = self._workers[k].name
            try:
                answer, asked = self._workers[k](self._function, item)
                if self._stopped or not asked:
                    return Done(i, answer, name, tries)
                lost = WorkerLost("its process was asked to end from outside")
            except WorkerLost as error:
                lost = error
            if self._stopped:
                break
            self._replace(k)
        return Done(i, WorkerLost(f"{lost}, {tries} times"), name, tries)

    def _replace(self, k: int) -> None:
        self._workers[k].end()
        with self._lock:
            if not self._stopped:
                self._workers[k] = _Worker()

    def _next(self) -> tuple[int, object] | None:
        with self._lock:
            return None if self._stopped else next(self._items, None)

    def answers(self, count: int) -> Iterator[Done]:
        """Give so many answers; raise the first error."""
        for _ in range(count):
            done = self._done.get()
            if isinstance(done, Exception):
                raise done
            yield done

    def stopped(self, patience: float) -> Iterator[Done]:
        """Take no more items, and give what is under way, as far as it has come."""
        self._stop()
        for worker in self._workers:
            worker.stop_run()
        for thread in self._threads:
            thread.join(patience)
        while not self._done.empty():
            done = self._done.get()
            if isinstance(done, Done) and not isinstance(done.answer, WorkerLost):
                yield done

    def _stop(self) -> None:
        with self._lock:
            self._stopped = True

    def end(self) -> None:
        """End all processes."""
        self._stop()
        for worker in self._workers:
            worker.end()

"""Many runs in processes of their own: one that is killed does not take the others along.

The processes end with the one that started them, however it ends.
"""

import os
import pickle
import queue
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

from lola_drake.errors import LolaError

Item, Answer = TypeVar("Item"), TypeVar("Answer")

PATIENCE = 60.0
"""How long runs that are asked to end may take for it (s)."""


RUNS = 25
"""Runs of a process, until another one takes its place: Drake never frees a diagram in which there
are systems of Python's, and each of them has meshes and a log."""


class WorkerLost(LolaError):
    """A process that was ended from outside, while it worked."""


class _Worker:
    """A process, and the pipes to it."""

    def __init__(self):
        command = [sys.executable, "-m", "lola_drake.studies.worker"]
        # It finds what this process finds, wherever that has been looked for.
        environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
        self._process = subprocess.Popen(command, env=environment, **pipes)

    def __call__(self, function: Callable[[Item], Answer], item: Item) -> Answer:
        """Return the function's answer, or raise its error."""
        try:
            pickle.dump((function, item), self._process.stdin)
            self._process.stdin.flush()
            fine, answer = pickle.load(self._process.stdout)
        except (OSError, EOFError, pickle.UnpicklingError):
            raise WorkerLost("a process was ended from outside") from None
        if not fine:
            raise answer
        return answer

    def stop_run(self) -> None:
        """Ask for the end of what it does, with what is there."""
        self._process.terminate()

    def end(self) -> None:
        """End the process."""
        self._process.kill()
        self._process.wait()


def each_done(
    function: Callable[[Item], Answer], items: Sequence[Item], jobs: int
) -> Iterator[tuple[int, Answer | LolaError]]:
    """Give the place of each item and the function's answer, as they come.

    An answer is a `WorkerLost` where a process was killed; the others go on. After Ctrl-C what is
    under way is asked to end, and given as it is, before the interruption goes on.

    Args:
        function: Of a module, since other processes must find it.
        items: What to call it with.
        jobs: How many processes; one item or job is done in this one.
    """
    jobs = min(jobs, len(items))
    if jobs <= 1:
        yield from ((i, function(item)) for i, item in enumerate(items))
        return
    pool = _Pool(function, items, jobs)
    try:
        yield from pool.answers(len(items))
    except KeyboardInterrupt:
        yield from pool.stopped()
        raise
    finally:
        pool.end()


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
        done = 0
        while (order := self._next()) is not None:
            i, item = order
            if done and done % RUNS == 0:
                self._workers[k].end()
                self._workers[k] = _Worker()
            done += 1
            try:
                self._done.put((i, self._workers[k](self._function, item), None))
            except WorkerLost as lost:
                if not self._stopped:
                    self._workers[k] = _Worker()
                self._done.put((i, lost, None))
            except Exception as error:
                self._done.put((i, None, error))

    def _next(self) -> tuple[int, object] | None:
        with self._lock:
            return None if self._stopped else next(self._items, None)

    def answers(self, count: int) -> Iterator[tuple[int, object]]:
        """Give so many answers; raise the first error."""
        for _ in range(count):
            i, answer, error = self._done.get()
            if error is not None:
                raise error
            yield i, answer

    def stopped(self) -> Iterator[tuple[int, object]]:
        """Take no more items, and give what is under way, as far as it has come."""
        self._stopped = True
        for worker in self._workers:
            worker.stop_run()
        for thread in self._threads:
            thread.join(PATIENCE)
        while True:
            try:
                i, answer, error = self._done.get_nowait()
            except queue.Empty:
                return
            if error is None and not isinstance(answer, WorkerLost):
                yield i, answer

    def end(self) -> None:
        """End all processes."""
        self._stopped = True
        for worker in self._workers:
            worker.end()

"""Many runs on a cluster of Dask's: the same call as on this machine, the package sent along.

The cluster's workers need Drake and what else this package is built upon, but not the package. A
law of one's own is looked for where the scenario names it, so its file must be on every machine.
"""

import logging
import pickle
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from itertools import islice
from typing import TYPE_CHECKING, Any

from lola_drake.atomic_file import reason
from lola_drake.errors import LolaError, short
from lola_drake.workers import TRIES, Done, WorkerLost

if TYPE_CHECKING:
    from distributed import Client

LOCAL = "local"

PATIENCE = 10
"""How long to look for a cluster and its first worker (s)."""

AHEAD = 3
"""Items on their way for each thread of the cluster, so that none waits for its next one."""


QUIET = {"silence_logs": logging.CRITICAL}
"""A worker that dies is replaced; what happens to its run is told by the study."""


class ClusterError(LolaError):
    """A cluster that cannot be used."""


@dataclass(frozen=True)
class Cluster:
    """Workers of a Dask cluster.

    Attributes:
        address: of its scheduler, such as tcp://host:8786; "local" for one on this machine, which
            ends with what it was made for.
        jobs: how many processes a local one has.
    """

    address: str = LOCAL
    jobs: int = 2

    def __call__(self, function: Callable, items: Sequence) -> Iterator[Done]:
        """Give what is done as it comes, see `Workers`; ClusterError if there is no cluster."""
        try:
            import distributed  # noqa: F401
        except ImportError:
            need = "a cluster needs a package: pip install 'lola_drake[cluster]'"
            raise ClusterError(need) from None
        with _client(self.address, self.jobs) as client:
            yield from _answers(client, function, items)


@contextmanager
def _client(address: str, jobs: int) -> "Iterator[Client]":
    """Give a cluster whose workers have this package."""
    import dask
    from distributed import Client, LocalCluster

    from lola_drake.studies.sent_package import SentPackage

    with dask.config.set({"distributed.scheduler.allowed-failures": TRIES - 1}):
        try:
            if address == LOCAL:
                # One thread each: Python runs one of them at a time.
                cluster = LocalCluster(jobs, threads_per_worker=1, dashboard_address=None, **QUIET)
                client = Client(cluster)
            else:
                cluster, client = None, Client(address, timeout=PATIENCE)
                client.wait_for_workers(1, timeout=PATIENCE)
                client.register_plugin(SentPackage.of_this_one())
        except (OSError, ValueError, TimeoutError) as error:
            told = reason(error)
            raise ClusterError(f"cluster {short(address, 60)}: {told}") from None
        try:
            yield client
        finally:
            with suppress(OSError, TimeoutError):
                client.close()
            if cluster is not None:
                cluster.close()


def _answers(client: "Client", function: Callable, items: Sequence) -> Iterator[Done]:
    """Give what is done as it comes; what crosses the cluster is bytes, so only workers read it."""
    from distributed import as_completed
    from distributed.scheduler import KilledWorker

    from lola_drake.studies.sent_package import call

    waiting = iter(enumerate(items))
    places: dict[Any, int] = {}

    def sent(count: int) -> Iterator[Any]:
        for i, item in islice(waiting, count):
            future = client.submit(call, pickle.dumps((function, item)), pure=False)
            places[future.key] = i
            yield future

    threads = sum(client.nthreads().values())
    under_way = as_completed(list(sent(AHEAD * threads)))
    for future in under_way:
        i = places.pop(future.key)
        try:
            fine, answer, worker = pickle.loads(future.result())
        except KilledWorker as error:
            lost = WorkerLost(f"its process was ended from outside, {TRIES} times")
            yield Done(i, lost, str(error.last_worker.address), TRIES)
        else:
            if not fine:
                raise answer
            yield Done(i, answer, worker)
        future.release()
        for following in sent(1):
            under_way.add(following)

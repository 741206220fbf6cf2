"""The points of a sweep on Dask: on a cluster of this machine's processors, or on one that runs elsewhere."""

import itertools
import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import cloudpickle
import dask
from distributed import Client, LocalCluster, as_completed

from . import sweep_point
from .errors import EndedError, UserError
from .sweep_point import FAILED, Job

CONNECT_S = 10
# Points handed out beyond those that run: enough that no worker waits, few enough to be taken back at once.
AHEAD = 4


def _quiet() -> None:
    """What goes wrong is told in this program's own words. Some loggers have levels of their own: of long garbage
    collections, as on a machine that stands still, and of callbacks that fail, as when a scheduler dies."""
    for name in ("asyncio", *logging.root.manager.loggerDict):
        if name.partition(".")[0] in ("asyncio", "distributed", "tornado"):
            logging.getLogger(name).setLevel(logging.CRITICAL)


@contextmanager
def local_client(workers: int) -> Iterator[Client]:
    """One thread for each point at a time: the work is done by sextant-mil, a process of its own."""
    _quiet()
    with (
        dask.config.set({"distributed.worker.memory.terminate": False, "distributed.worker.memory.pause": False}),
        LocalCluster(
            n_workers=1, threads_per_worker=workers, processes=False, dashboard_address="127.0.0.1:0", memory_limit=0
        ) as cluster,
        Client(cluster) as client,
    ):
        yield client


@contextmanager
def remote_client(address: str) -> Iterator[Client]:
    _quiet()
    # The module goes along with what it is asked to do: workers need Dask and the file system, nothing of this tree.
    cloudpickle.register_pickle_by_value(sweep_point)
    try:
        client = Client(address, timeout=CONNECT_S)
    except (OSError, ValueError, TimeoutError) as error:
        raise UserError(f"--scheduler: no Dask scheduler answers at {address} ({type(error).__name__}).") from None
    with client:
        try:
            client.wait_for_workers(1, timeout=CONNECT_S)
        except TimeoutError:
            raise UserError(f"--scheduler: the scheduler at {address} has no workers.") from None
        yield client


def slots(client: Client) -> int:
    """How many points run at a time."""
    return sum(client.nthreads().values())


def _task(job: Job) -> Callable[[], dict]:
    """A closure, which is always carried by value; a function of a module would be looked up by its name."""
    run_point = sweep_point.run_point
    return lambda: run_point(job)


def _end_programs(sweep: str) -> Callable:
    end = sweep_point.end_programs
    return lambda dask_worker: end(sweep, dask_worker)


def run_jobs(client: Client, jobs: list[Job]) -> Iterator[dict]:
    """The record of each job, as they end. Left early, it ends what still runs."""
    waiting = iter(jobs)
    running = {}

    def submit(job: Job):
        future = client.submit(_task(job), key=f"sextant-{job.sweep}-{job.point}", pure=False)
        running[future.key] = job
        return future

    finished = as_completed([], with_results=False)
    try:
        for job in itertools.islice(waiting, AHEAD * max(1, slots(client))):
            finished.add(submit(job))
        while running:
            future = next(finished)
            job = running.pop(future.key)
            record = _record(future, job)
            if (following := next(waiting, None)) is not None:
                finished.add(submit(following))
            yield record
    finally:
        _take_back(client, finished, jobs)


def _record(future, job: Job) -> dict:
    """A point whose worker did not live to answer is a failed point; a scheduler that is gone ends the sweep."""
    if future.status == "finished":
        return future.result()
    if future.client.status not in ("running", "newly-created") or future.status in ("cancelled", "lost"):
        raise EndedError("the Dask scheduler is gone; the finished points are kept and the same command resumes.")
    problem = future.exception()
    reason = sweep_point.clean_reason(f"the worker could not run it: {type(problem).__name__}: {problem}")
    return {"point": job.point, "status": FAILED, "reason": reason, "metrics": {}, "elapsed_s": None}


def _take_back(client: Client, finished: as_completed, jobs: list[Job]) -> None:
    futures = list(finished.futures)
    if not futures or client.status != "running":
        return
    client.cancel(futures, force=True)
    try:
        client.run(_end_programs(jobs[0].sweep), on_error="ignore")
    except (OSError, TimeoutError):
        return  # the workers are gone, and their programs with them

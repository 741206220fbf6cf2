"""Work by several threads, which wait for the programs that they run."""

import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor, as_completed
from typing import TypeVar

Item, Result = TypeVar("Item"), TypeVar("Result")


def as_finished(function: Callable[[Item], Result], items: Iterable[Item], jobs: int) -> Iterator[tuple[int, Result]]:
    """The number of each item with its result, so many at a time. What has not begun when this ends never does."""
    pool = ThreadPoolExecutor(jobs)
    try:
        begun = {pool.submit(function, item): number for number, item in enumerate(items)}
        for one in as_completed(begun):
            yield begun[one], one.result()
    finally:
        pool.shutdown(cancel_futures=True)


def in_order(
    function: Callable[[Item], Result], items: Iterable[Item], jobs: int, step: Callable[[], None] = lambda: None
) -> list[Result]:
    """The results in the order of the items; a step follows each that ends."""
    found = {}
    for number, result in as_finished(function, items, jobs):
        found[number] = result
        step()
    return [found[number] for number in sorted(found)]


def progress_of(total: int, name: str, program: str) -> Callable[[], None]:
    """Reports on stderr how far the runs are, every ten seconds."""
    from rich.console import Console

    console, began, said, done = Console(stderr=True), time.monotonic(), [time.monotonic()], [0]

    def step() -> None:
        done[0] += 1
        now = time.monotonic()
        if now - said[0] >= 10 or done[0] == total:
            said[0] = now
            left = (now - began) / done[0] * (total - done[0])
            console.print(f"{program}: {name}: {done[0]} of {total} points, {left:.0f} s left", highlight=False)

    return step

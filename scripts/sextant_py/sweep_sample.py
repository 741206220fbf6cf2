"""How a sweep draws its points: shares of the ranges, from 0 to below 1, one row a point."""

import random
from collections.abc import Callable, Iterable

KINDS = {"random": "random sample", "sobol": "Sobol' sample", "latin_hypercube": "Latin hypercube sample"}


def _random(samples: int, dimensions: int, seed: int) -> Iterable[list[float]]:
    """Point by point, so that more samples of one seed begin with the same points."""
    # random() is the one generator of Python whose sequence is promised to stay.
    generator = random.Random(seed)
    return ([generator.random() for _ in range(dimensions)] for _ in range(samples))


def _sobol(samples: int, dimensions: int, seed: int) -> Iterable[list[float]]:
    """The scrambled Sobol' sequence; more samples of one seed begin with the same points."""
    from scipy.stats import qmc

    return qmc.Sobol(dimensions, scramble=True, rng=seed).random_base2(samples.bit_length() - 1).tolist()


def _latin_hypercube(samples: int, dimensions: int, seed: int) -> Iterable[list[float]]:
    """Each range in as many equal shares as there are points, one point in each share."""
    from scipy.stats import qmc

    return qmc.LatinHypercube(dimensions, rng=seed).random(samples).tolist()


_DRAWS: dict[str, Callable[[int, int, int], Iterable[list[float]]]] = {
    "random": _random,
    "sobol": _sobol,
    "latin_hypercube": _latin_hypercube,
}


def refusal(method: str, samples: int) -> str | None:
    """Why this number of points does not fit the method; None where it does."""
    if method == "sobol" and samples & (samples - 1):
        below = 1 << samples.bit_length() - 1
        return f"a Sobol' sample needs a power of two, such as {below} or {2 * below}, got {samples}."
    return None


def shares(method: str, samples: int, dimensions: int, seed: int) -> Iterable[list[float]]:
    return _DRAWS[method](samples, dimensions, seed)

"""Numbers of users' files and messages."""

import math


def is_finite(number: float) -> bool:
    """False also of a whole number beyond the range of double precision."""
    try:
        return math.isfinite(number)
    except OverflowError:
        return False

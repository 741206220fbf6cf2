"""What a test may fail with that is not a wrong answer; verdict.py judges by it."""


class NotSeenError(AssertionError):
    """What a test waited for did not come."""


class SpoiltByHostError(AssertionError):
    """Every attempt at a measurement was spoilt by the host, which has been seen to stand still during each of them."""

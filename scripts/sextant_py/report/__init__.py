"""A report for people: one page of HTML about runs, sweeps and recordings."""


def main(arguments: list[str]) -> int:
    from .program import main as perform

    return perform(arguments)

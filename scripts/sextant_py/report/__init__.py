"""A report for people: one page of HTML about runs, sweeps and recordings."""

from .program import main

__all__ = ["main"]

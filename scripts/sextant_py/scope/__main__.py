"""python -m sextant_py.scope"""

from ..errors import run
from .program import main

if __name__ == "__main__":
    run("scope", main)

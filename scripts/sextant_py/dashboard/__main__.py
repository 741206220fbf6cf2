"""python -m sextant_py.dashboard"""

from ..errors import run
from .program import main

if __name__ == "__main__":
    run("dashboard", main)

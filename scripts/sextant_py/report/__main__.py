"""python -m sextant_py.report"""

from ..errors import run
from .program import main

if __name__ == "__main__":
    run("report", main)

"""Stage: instructions of a step, which do not depend on how busy the machine is."""

from sextant_py.instructions import measure

from .figure import Figure
from .lab import Lab, Stage


def instructions(lab: Lab) -> list[Figure]:
    counts = measure(lab.programs / "sextant_instruction_probe")
    return [
        Figure(f"instructions of one {name.replace('_', ' ')}", value, command="scripts/check_instructions")
        for name, value in counts.items()
    ]


INSTRUCTIONS = Stage("instructions", "instructions of a step, by callgrind", 8, instructions)

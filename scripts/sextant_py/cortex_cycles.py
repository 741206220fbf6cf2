"""Clock cycles of a Cortex-M4, estimated from a trace of the instructions that an emulator executed.

Each instruction is taken at what Arm's table says for memory without wait states, always at the dear end: a taken
branch refills the pipeline in 3 cycles, a division takes 12, no load overlaps the one before it.
Source: Arm, Cortex-M4 Technical Reference Manual (DDI 0439), tables 3-1 and 7-1.
"""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from .firmware_image import output_of

REFILL = 3  # most cycles of a pipeline refill
_LINE = re.compile(r"^\s+([0-9a-f]+):\t([\w.]+)(?:\t(.*))?$")
_TRACED = re.compile(rb"^Trace \d+: 0x[0-9a-f]+ \[[0-9a-f]+/([0-9a-f]+)/")


@dataclass(frozen=True)
class Instruction:
    cycles: int
    size: int  # [B]


def _registers(operands: str) -> int:
    """How many registers a list names: {r4-r7, lr} are 5."""
    count = 0
    for part in re.search(r"\{(.*)\}", operands).group(1).split(","):
        ends = [int(n) for n in re.findall(r"\d+", part)]
        names_range = "-" in part and len(ends) == 2
        words = 2 if part.strip().startswith("d") else 1
        count += words * (ends[1] - ends[0] + 1 if names_range else 1)
    return count


def cycles(mnemonic: str, operands: str) -> int:
    """Of one instruction, without the refill of a branch that is taken."""
    name = mnemonic.removesuffix(".n").removesuffix(".w")
    if re.match(r"(push|pop|ldm|stm|vpush|vpop|vldm|vstm)", name):
        return 1 + _registers(operands)
    if re.match(r"(ldrd|strd)", name):
        return 3
    if re.match(r"(vdiv|vsqrt)", name):
        return 14
    if re.match(r"(vfma|vfms|vfnma|vfnms|vmla|vmls|vnmla|vnmls)", name):
        return 3
    if re.match(r"(vldr|vstr)", name):
        return 3 if operands.startswith("d") else 2
    if name.startswith("vmov") and operands.count(",") >= 2:
        return 2
    if re.match(r"(sdiv|udiv)", name):
        return 12
    if re.match(r"(ldr|str)", name):
        return 2
    if re.match(r"(tbb|tbh)", name):
        return 2
    return 1


def disassembly(image: Path) -> tuple[dict[int, Instruction], dict[str, int]]:
    """Instructions by address, and the addresses of the functions by mangled name."""
    listing: list[tuple[int, str, str]] = []
    functions: dict[str, int] = {}
    for line in output_of("arm-none-eabi-objdump", "-d", "--no-show-raw-insn", image).splitlines():
        if heading := re.match(r"^([0-9a-f]+) <(.+)>:$", line):
            functions[heading.group(2)] = int(heading.group(1), 16)
        elif found := _LINE.match(line):
            listing.append((int(found.group(1), 16), found.group(2), found.group(3) or ""))
    found = {}
    for (address, mnemonic, operands), after in zip(listing, [*listing[1:], (0, "", "")], strict=True):
        size = after[0] - address if after[0] - address in (2, 4) else 4
        found[address] = Instruction(0 if mnemonic.startswith(".") else cycles(mnemonic, operands), size)
    return found, functions


def cycles_of_calls(trace: Iterable[bytes], program: dict[int, Instruction], entry: int) -> list[tuple[int, int]]:
    """Instructions and cycles of each call of the function at `entry`, from its first instruction to its return."""
    calls: list[tuple[int, int]] = []
    before = -1  # address of the instruction executed last
    back = -1  # where the present call returns to
    count = total = 0
    for line in trace:
        found = _TRACED.match(line)
        if not found:
            continue
        address = int(found.group(1), 16)
        if back >= 0:
            here = program[before]
            count += 1
            total += here.cycles + (REFILL if address != before + here.size else 0)
            if address == back:
                calls.append((count, total))
                back = -1
        elif address == entry:
            back = before + program[before].size
            count = total = 0
        before = address
    return calls

"""What a firmware image is made of: bytes of flash and RAM, the largest symbols, and what must not be in it."""

import re
from dataclasses import dataclass
from pathlib import Path

from sextant_py.errors import output_of

IN_FLASH = (".text", ".rodata", ".init_array", ".ARM.exidx", ".data")
IN_RAM = (".data", ".bss")

# Mangled names: the heap, exceptions, an orderly end, and double arithmetic by library.
FORBIDDEN = re.compile(
    r"^(_?(malloc|free|calloc|realloc|sbrk)(_r)?"
    r"|_Zn[wa]j.*"  # operator new
    r"|__cxa_(throw|allocate_exception|begin_catch|guard_acquire)|__gxx_personality_v0|_Unwind_\w+|_ZSt\d+__throw_\w+"
    r"|abort|exit|_exit"
    r"|__aeabi_(d(add|sub|rsub|mul|div|neg|cmp\w+|2\w+)|cd\w+|[fiul]+2d)|__\w+df[23]|__\w+sfdf2)$"
)


@dataclass(frozen=True)
class Symbol:
    name: str
    size: int  # [B]
    kind: str  # as nm says


def sections(image: Path) -> dict[str, int]:
    """Size of each section that is loaded [B]."""
    lines = output_of("arm-none-eabi-size", "-A", image).splitlines()
    found = dict(re.match(r"(\.[\w.]+)\s+(\d+)", line).groups() for line in lines if re.match(r"\.[\w.]+\s+\d+", line))
    return {name: int(size) for name, size in found.items() if name in {*IN_FLASH, *IN_RAM} and int(size)}


def flash(of: dict[str, int]) -> int:
    return sum(of.get(name, 0) for name in IN_FLASH)


def ram(of: dict[str, int]) -> int:
    return sum(of.get(name, 0) for name in IN_RAM)


def symbols(image: Path, *, demangle: bool) -> list[Symbol]:
    """By size, the largest first."""
    flags = "-CS" if demangle else "-S"
    found = []
    for line in output_of("arm-none-eabi-nm", flags, "--size-sort", "--reverse-sort", image).splitlines():
        _, size, kind, name = line.split(maxsplit=3)
        found.append(Symbol(name, int(size, 16), kind))
    return found


def forbidden(image: Path) -> list[str]:
    names = (line.split()[-1] for line in output_of("arm-none-eabi-nm", image).splitlines())
    return sorted({name for name in names if FORBIDDEN.match(name)})

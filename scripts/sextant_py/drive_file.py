"""The drive of a configuration file, of sextant-ecu or of sextant-mil, by its dotted keys."""

from pathlib import Path

from .errors import UserError
from .sweep_file import Settings
from .sweep_reader import flat
from .toml_file import parsed

OF_A_RUN = (  # sections and keys that its runs set, or that belong to the run of a scenario or to a live drive
    "name", "description", "duration_s", "mode", "profile", "load", "cycle", "vehicle", "driver", "trace", "metrics",
    "expect", "event_exact",
)  # fmt: skip
SECTIONS_WITH_FILE = ("machine", "drive.inverter", "control.machine_estimate")


def own_keys(file: Path) -> Settings:
    """Dotted keys of a file alone."""
    return flat(parsed(file))


def _layers(file: Path, seen: tuple[Path, ...] = ()) -> Settings:
    """Dotted keys of a file above those of the one that it is based on; SECTION.file is the path of a section's."""
    if file.resolve() in seen:
        raise UserError(f"{file} is based on itself.")
    tree = parsed(file)
    base = tree.pop("base", None)
    found = _layers(file.parent / base, (*seen, file.resolve())) if base else {}
    own = flat(tree)
    for section in SECTIONS_WITH_FILE:
        named = own.pop(section) if isinstance(own.get(section), str) else own.get(f"{section}.file")
        if isinstance(named, str):
            own[f"{section}.file"] = str(file.parent / named)
    return found | own


def read(file: Path) -> Settings:
    """Dotted keys of a file and of those that it is based on. The file of a section, the last one named, stands below
    every key that is written out."""
    found = _layers(file)
    for section in SECTIONS_WITH_FILE:
        if named := found.pop(f"{section}.file", None):
            found = {f"{section}.{key}": value for key, value in flat(parsed(Path(named))).items()} | found
    return found


def of_the_drive(found: Settings, known: set[str], file: Path) -> tuple[Settings, list[str]]:
    """The keys of the file that a point begins with, and the sections of a live drive, which no scenario has."""
    settings, left_out, sections = {}, [], {key.split(".")[0] for key in known}
    for key, value in found.items():
        section = key.split(".")[0]
        if section in (*OF_A_RUN, "machine") or key.startswith("plant.faults."):
            continue
        if key in known:
            settings[key] = value
        elif section in sections:
            raise UserError(f"{file}: {key} is unknown; sextant-mil FILE --print-config shows every key.")
        elif section not in left_out:
            left_out.append(section)
    return settings, left_out


def machine_of(found: Settings, file: Path) -> Settings:
    """The machine of the file, by keys without their section."""
    machine = {key.removeprefix("machine."): value for key, value in found.items() if key.startswith("machine.")}
    if not machine:
        raise UserError(f'{file} names no machine: [machine] with file = "…" or with its values is needed.')
    return machine

"""The table of docs/architecture.md is what is built: folders, what they include, what they link."""

import re
from collections import Counter
from pathlib import Path

import pytest
from sextant_py.paths import ROOT

PUBLIC = ROOT / "include" / "sextant"
ROW = re.compile(r"^\| `(\w+)` \| .* \| (.*) \|$", re.MULTILINE)
INCLUDE = re.compile(r'^#include "sextant/(\w+)/', re.MULTILINE)
CONSTANT = re.compile(r"^(?:inline )?constexpr [^()={\n]*?(\w+)\s*(?:=|\{)", re.MULTILINE)
LINKED = re.compile(r"\bPUBLIC\b((?:\s+[\w:]+)+?)\s*(?:PRIVATE|\))")
# SUNDIALS, Cyclone DDS, the kernel's CAN, sockets, HDF5, toml++.
THIRD_PARTY = re.compile(
    r"^#include <((?:arkode|cvode|nvector|sun\w+|dds|linux|toml\+\+)/.*|(?:hdf5|toml)\.\w+|sys/socket\.h)>",
    re.MULTILINE,
)


def folders() -> dict[str, set[str]]:
    """Of each folder, those that the table lets it depend on."""
    page = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    section = page.split("\n## Folders\n")[1].split("\n## ")[0]
    rows = {folder: set(re.findall(r"`(\w+)`", cell)) for folder, cell in ROW.findall(section)}
    rows.pop("apps")  # everything
    return rows


def text_of(*files: Path) -> str:
    return "\n".join(file.read_text(encoding="utf-8") for file in files)


def included_by(folder: str) -> set[str]:
    files = [*(PUBLIC / folder).rglob("*.hpp"), *(ROOT / "src" / folder).rglob("*.?pp")]
    return set(INCLUDE.findall(text_of(*files))) - {folder}


def linked_by(folder: str) -> set[str]:
    text = (ROOT / "src" / folder / "CMakeLists.txt").read_text(encoding="utf-8")
    library = text[text.index(f"sextant_add_library({folder}") :]
    found = LINKED.search(library)
    return set(re.findall(r"sextant::(\w+)", found[1])) if found else set()


def reached_from(folder: str, rows: dict[str, set[str]]) -> set[str]:
    """Every folder that it depends on, over others too."""
    reached: set[str] = set()
    left = set(rows[folder])
    while left:
        reached |= left
        left = set().union(*(rows[found] for found in left)) - reached
    return reached


FOLDERS = folders()
ECU = ROOT / "apps" / "ecu"


def ecu_folders() -> dict[str, set[str]]:
    """Of each folder of the live program, those that the table lets it include."""
    page = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    section = page.split("\n| folder of `apps/ecu` |")[1].split("\n## ")[0]
    return {folder: set(re.findall(r"`(\w+)`", cell)) for folder, cell in ROW.findall(section)}


ECU_FOLDERS = ecu_folders()


def test_every_folder_of_the_live_program_has_its_row() -> None:
    assert set(ECU_FOLDERS) == {path.name for path in ECU.iterdir() if path.is_dir()}


@pytest.mark.parametrize("folder", ECU_FOLDERS)
def test_a_folder_of_the_live_program_includes_what_its_row_says(folder: str) -> None:
    """None includes a file of the program itself, which lies above them."""
    found = re.findall(r'^#include "ecu/([^"]+)"', text_of(*(ECU / folder).glob("*.?pp")), re.MULTILINE)
    assert {path.split("/")[0] for path in found} - {folder} == ECU_FOLDERS[folder]
    assert folder not in reached_from(folder, ECU_FOLDERS)


def test_every_folder_has_its_row() -> None:
    assert set(FOLDERS) == {path.name for path in PUBLIC.iterdir()}
    assert set(FOLDERS) == {path.name for path in (ROOT / "src").iterdir()}


@pytest.mark.parametrize("folder", FOLDERS)
def test_a_folder_includes_what_its_row_says(folder: str) -> None:
    assert included_by(folder) == FOLDERS[folder]


@pytest.mark.parametrize("folder", FOLDERS)
def test_a_folder_links_what_its_row_says(folder: str) -> None:
    assert linked_by(folder) == FOLDERS[folder]


@pytest.mark.parametrize("folder", FOLDERS)
def test_there_are_no_cycles(folder: str) -> None:
    assert folder not in reached_from(folder, FOLDERS)


def test_plant_and_drive_never_include_each_other() -> None:
    assert "plant" not in reached_from("drive", FOLDERS)
    assert not reached_from("plant", FOLDERS) & {"control", "safety", "drive"}


def test_only_src_includes_third_party_interfaces() -> None:
    files = [*PUBLIC.rglob("*.hpp"), *(ROOT / "apps").rglob("*.?pp")]
    assert THIRD_PARTY.findall(text_of(*files)) == []
    assert len(THIRD_PARTY.findall(text_of(*(ROOT / "src").rglob("*.?pp")))) >= 10, (
        "the pattern finds what it looks for"
    )


@pytest.mark.parametrize("folder", FOLDERS)
def test_a_constant_of_a_source_has_a_name_of_its_own_in_its_folder(folder: str) -> None:
    """The presets with sanitizers compile several sources of a folder as one."""
    sources, headers = ((ROOT / "src" / folder).glob(pattern) for pattern in ("*.cpp", "*.hpp"))
    names = [name for file in sources for name in set(CONSTANT.findall(text_of(file)))]
    names += {name for file in headers for name in CONSTANT.findall(text_of(file))}
    assert sorted(name for name, count in Counter(names).items() if count > 1) == []

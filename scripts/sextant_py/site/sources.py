"""Files and directories of the tree as pages."""

import os.path
from pathlib import Path

from ..paths import ROOT
from . import links

LANGUAGES = {
    **{".hpp": "cpp", ".cpp": "cpp", ".py": "python", ".toml": "toml", ".json": "json", ".xml": "xml"},
    **{".cmake": "cmake", ".idl": "idl", ".md": "markdown"},
}
FENCE = "``````"  # longer than one within a file
HIDDEN = "---\nsearch:\n  exclude: true\n---\n"


def language_of(file: Path) -> str:
    if file.suffix in LANGUAGES:
        return LANGUAGES[file.suffix]
    if file.name == "CMakeLists.txt":
        return "cmake"
    return "bash" if file.read_bytes().startswith(b"#!/bin/bash") else "text"


def page_of(source: Path, known: set[Path]) -> str:
    """A file as code; a directory as the list of what it holds, with links to what is known."""
    name = source.relative_to(ROOT).as_posix()
    if source.is_file():
        code = source.read_text(encoding="utf-8").rstrip()
        return f"{HIDDEN}# {name}\n\n{FENCE}{language_of(source)}\n{code}\n{FENCE}\n"
    place = links.place_of(source)
    lines = [f"{HIDDEN}# {name}/", ""]
    for entry in sorted(source.iterdir()):
        if entry.name.startswith((".", "__pycache__")):
            continue
        there = os.path.relpath(links.place_of(entry), Path(place).parent)
        lines.append(f"- [{entry.name}]({there})" if entry in known else f"- {entry.name}{'/' * entry.is_dir()}")
    return "\n".join(lines) + "\n"

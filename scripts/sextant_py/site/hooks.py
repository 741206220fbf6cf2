"""What MkDocs calls while it builds the site: generated pages, and the links of all pages."""

import re
from pathlib import Path
from typing import Any

from mkdocs.structure.files import File, Files

from sextant_py.site import links, reference, sources

SYMBOL = re.compile(r"\$([A-Za-z])_([a-z])\$")  # a quantity with its index, as pages write it: $R_s$
ASSETS = [Path(__file__).parent / name for name in ("assets", "vendor")]


def pages_of(nav: list | dict | str) -> set[str]:
    """The pages that a navigation names."""
    if isinstance(nav, str):
        return {nav}
    parts = nav.values() if isinstance(nav, dict) else nav
    return {page for part in parts for page in pages_of(part)}


def on_config(config: Any) -> Any:
    """A page of docs/ that the navigation does not name stands at the end of "How to", by its heading."""
    named = pages_of(config.nav)
    how_to = next(part["How to"] for part in config.nav if "How to" in part)
    how_to += sorted(page.name for page in links.DOCS.glob("*.md") if page.name not in named)
    return config


def on_files(files: Files, config: Any) -> Files:
    """Adds the pages that are generated, and those of the sources that pages link to."""
    pages = {file.src_uri: Path(file.abs_src_path) for file in files if file.is_documentation_page()}
    for origin, place in links.PLACES.items():
        pages[place] = origin
        files.append(File.generated(config, place, content=origin.read_text(encoding="utf-8")))
    for place, page in reference.PAGES.items():
        files.append(File.generated(config, place, content=page()))
    for asset in (asset for folder in ASSETS for asset in folder.iterdir()):
        files.append(File.generated(config, f"assets/{asset.name}", content=asset.read_text(encoding="utf-8")))
    known = links.linked_sources(pages)
    for source in known:
        files.append(File.generated(config, links.place_of(source), content=sources.page_of(source, known)))
    return files


def on_page_markdown(markdown: str, page: Any, config: Any, files: Files) -> str:
    """Links as they are in the site. A generated page has them so already."""
    place = page.file.src_uri
    origins = {place: origin for origin, place in links.PLACES.items()}
    origin = origins.get(place, links.DOCS / place)
    return links.rewritten(markdown, origin, place) if origin.is_file() else markdown


def on_page_content(html: str, page: Any, config: Any, files: Files) -> str:
    """A picture leads to itself in its own size: on a narrow page its texts are small. Symbols need no script."""
    html = SYMBOL.sub(r"<i>\1</i><sub>\2</sub>", html)
    return re.sub(r'<img [^>]*src="([^"]+)"[^>]*>', r'<a href="\1">\g<0></a>', html)

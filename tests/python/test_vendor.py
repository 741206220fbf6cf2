"""JavaScript of others: fetched by scripts/setup through npm, checked by hash, and without it pages are refused."""

import base64
import hashlib
import io
import json
import os
import re
import shutil
import subprocess
import tarfile
from collections.abc import Callable
from pathlib import Path

import pytest
from sextant_py.dashboard.server import PAGE
from sextant_py.paths import ROOT

WEB = ROOT / "scripts" / "web"
PACKAGES = {
    "uplot": ("LICENSE", "dist/uPlot.esm.js", "dist/uPlot.min.css"),
    "iframe-worker": ("LICENSE", "shim/index.js"),
}
Setup = Callable[..., subprocess.CompletedProcess]


def test_what_the_page_loads_is_there() -> None:
    """Of the HTML and of every module, the fetched ones too."""
    loaded = 0
    for file in [*PAGE.rglob("*.js"), PAGE / "index.html"]:
        named = re.findall(r'(?:^import .*?from|\bhref=|\bsrc=)\s*"([^"#]+)"', file.read_text("utf-8"), re.MULTILINE)
        for name in named:
            assert (file.parent / name).is_file(), f"{file} loads {name}"
        loaded += len(named)
    assert loaded > 20


def test_every_version_is_pinned_with_its_hash() -> None:
    wanted = json.loads((WEB / "package.json").read_text("utf-8"))["dependencies"]
    locked = json.loads((WEB / "package-lock.json").read_text("utf-8"))["packages"]
    assert set(wanted) == set(PACKAGES)
    packages = {place.removeprefix("node_modules/"): package for place, package in locked.items() if place}
    assert {name: package["version"] for name, package in packages.items()} == wanted
    assert all(package["integrity"].startswith("sha512-") for package in packages.values())
    assert not any("resolved" in package for package in packages.values()), "the registry is npm's to choose"


def test_git_has_none_of_it() -> None:
    found = subprocess.run(["git", "ls-files", "--", "**/vendor/**"], cwd=ROOT, capture_output=True, text=True)
    if found.returncode:
        pytest.skip("this tree is no checkout")
    assert found.stdout == ""


def package(name: str, files: tuple[str, ...], to: Path) -> str:
    """An npm package with these files; its hash as package-lock.json has it."""
    packed = io.BytesIO()
    with tarfile.open(fileobj=packed, mode="w:gz") as archive:
        contents = {file: f"{name} {file}\n" for file in files}
        contents["package.json"] = json.dumps({"name": name, "version": "1.2.3"})
        for file, content in contents.items():
            entry = tarfile.TarInfo(f"package/{file}")
            entry.size = len(content)
            archive.addfile(entry, io.BytesIO(content.encode()))
    to.write_bytes(packed.getvalue())
    return "sha512-" + base64.b64encode(hashlib.sha512(packed.getvalue()).digest()).decode()


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    """The scripts in a tree that lacks nothing but the npm packages, which come from files in place of the registry."""
    if not shutil.which("npm"):
        pytest.skip("NOT TESTED: this machine has no npm of its own")
    ignored = shutil.ignore_patterns("__pycache__", "vendor")
    shutil.copytree(ROOT / "scripts", tmp_path / "scripts", ignore=ignored)
    for name in ("packages.txt", "requirements.txt"):
        (tmp_path / "scripts" / name).write_text("bash\n" if name == "packages.txt" else "# none\n")
    (tmp_path / ".venv").symlink_to(ROOT / ".venv")
    boot = Path("/proc/sys/kernel/random/boot_id").read_text("ascii").strip()
    findings = tmp_path / ".cache" / "with_vcan" / boot
    findings.mkdir(parents=True)
    (findings / "vcan_works").write_text("yes\n")
    lock(tmp_path)
    return tmp_path


def lock(tree: Path, wrong: str = "", version: str = "1.2.3") -> None:
    """package.json and package-lock.json for packages in files; that of `wrong` has another hash."""
    root = {"dependencies": {name: f"file:{tree}/{name}.tgz" for name in PACKAGES}}
    packages: dict[str, dict] = {"": root}
    for name, files in PACKAGES.items():
        integrity = package(name, files, tree / f"{name}.tgz")
        if name == wrong:
            integrity = package(name, (*files, "more"), tree / "other.tgz")
        packages[f"node_modules/{name}"] = {
            "version": version,
            "resolved": root["dependencies"][name],
            "integrity": integrity,
        }
    (tree / "scripts" / "web" / "package.json").write_text(json.dumps(root))
    content = {"name": "web", "lockfileVersion": 3, "requires": True, "packages": packages}
    (tree / "scripts" / "web" / "package-lock.json").write_text(json.dumps(content, indent=2))


@pytest.fixture
def setup(tree: Path) -> Setup:
    def run(**environment: str) -> subprocess.CompletedProcess:
        return subprocess.run(
            [tree / "scripts" / "setup"],
            env={**os.environ, "npm_config_cache": str(tree / "npm cache"), **environment},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=600,
        )

    return run


def fetched(tree: Path) -> dict[str, str]:
    folders = [tree / "scripts/sextant_py/dashboard/page/vendor", tree / "scripts/sextant_py/site/vendor"]
    return {
        file.relative_to(folder).as_posix(): file.read_text("utf-8")
        for folder in folders
        for file in folder.rglob("*")
        if file.is_file() and file.name != "package-lock.json"
    }


def test_setup_fetches_what_pages_load(tree: Path, setup: Setup) -> None:
    done = setup()
    assert (done.returncode, done.stdout, done.stderr) == (0, "setup: fetching 2 npm packages that pages load\n", "")
    real = ROOT / "scripts" / "sextant_py"
    folders = [real / "dashboard" / "page" / "vendor", real / "site" / "vendor"]
    names = {file.relative_to(folder).as_posix() for folder in folders for file in folder.rglob("*") if file.is_file()}
    found = fetched(tree)
    assert set(found) == names - {"package-lock.json"}
    assert found["uplot/uPlot.esm.js"] == "uplot dist/uPlot.esm.js\n"
    assert found["iframe-worker.js"] == "iframe-worker shim/index.js\n"
    again = setup()
    assert (again.returncode, again.stdout, again.stderr) == (0, "", "")


def test_setup_fetches_again_what_has_another_version(tree: Path, setup: Setup) -> None:
    assert setup().returncode == 0
    (tree / "scripts/sextant_py/site/vendor/iframe-worker.js").write_text("of the version before")
    content = tree / "scripts" / "web" / "package-lock.json"
    content.write_text(content.read_text() + "\n")
    assert setup().stdout == "setup: fetching 2 npm packages that pages load\n"
    assert fetched(tree)["iframe-worker.js"] == "iframe-worker shim/index.js\n"


@pytest.mark.parametrize("wrong", PACKAGES)
def test_setup_refuses_another_package_under_the_name(tree: Path, setup: Setup, wrong: str) -> None:
    lock(tree, wrong=wrong)
    done = setup()
    assert done.returncode == 1
    assert done.stderr.startswith(
        "setup: npm found a package whose hash is not that of scripts/web/package-lock.json ("
    )
    assert fetched(tree) == {}


def test_setup_says_where_npm_cannot_fetch(tree: Path, setup: Setup) -> None:
    (tree / "uplot.tgz").unlink()
    done = setup()
    assert done.returncode == 1
    assert done.stderr.startswith("setup: npm could not fetch the packages of scripts/web; check the network or")
    assert done.stderr.count("\n") == 1
    assert fetched(tree) == {}


@pytest.mark.parametrize(("name", "page"), [("dashboard", "the dashboard's page"), ("docs", "the site")])
def test_a_page_without_them_is_refused(tree: Path, name: str, page: str) -> None:
    for part in ("configs", "docs", "mkdocs.yml"):
        (tree / part).symlink_to(ROOT / part)
    found = subprocess.run([tree / "scripts" / name], capture_output=True, text=True, timeout=120)
    assert found.returncode == 2
    assert found.stderr.startswith(f"{name}: {page} lacks JavaScript that it loads, in {tree}/scripts/")
    assert found.stderr.endswith("; scripts/setup fetches it, and has to run before pip installs the package.\n")

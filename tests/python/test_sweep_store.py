"""Finished points on disk: kept, refused when another sweep's, and whole after an interruption."""

import json
import resource
from pathlib import Path

import pytest
from sextant_py import sweep_file
from sextant_py.errors import UserError
from sextant_py.sweep_store import SweepStore

FILE = """scenario = "scenario.toml"
[set]
duration_s = 0.5
[random]
samples = 5
seed = 7
[random.ranges]
machine.r_s_ohm = { from = 0.2, to = 0.6 }
"""


def sweep_of(directory: Path, text: str = FILE) -> sweep_file.Sweep:
    (directory / "scenario.toml").touch()
    (directory / "sweep.toml").write_text(text, encoding="utf-8")
    return sweep_file.load(directory / "sweep.toml")


def record(point: int, status: str = "ok") -> dict:
    return {"point": point, "status": status, "reason": "", "metrics": {"flux_mean_wb": 1.1}}


def opened(directory: Path, text: str = FILE, configuration: str = "a", program: str = "b", **how: bool) -> SweepStore:
    store = SweepStore(directory / "out", sweep_of(directory, text), configuration, program)
    try:
        store.open(**how)
    except UserError:
        store.close()
        raise
    return store


@pytest.fixture
def begun(tmp_path: Path) -> Path:
    """A directory in which points 3 and 1 are finished, 1 not well."""
    store = opened(tmp_path)
    store.add(record(3))
    store.add(record(1, "failed"))
    store.close()
    return tmp_path


def test_finished_points_are_kept(begun: Path) -> None:
    store = opened(begun)
    assert store.missing() == [0, 2, 4]
    assert [kept["point"] for kept in store.in_order()] == [1, 3]
    store.close()


def test_failed_points_run_once_more_when_asked(begun: Path) -> None:
    store = opened(begun, retry_failed=True)
    assert store.missing() == [0, 1, 2, 4]
    store.close()
    store = opened(begun)
    assert store.missing() == [0, 1, 2, 4]
    store.close()


def test_a_line_that_was_cut_off_is_dropped(begun: Path) -> None:
    file = begun / "out" / "points.jsonl"
    whole = file.read_bytes()
    file.write_bytes(whole + b'{"point": 2, "status": "o')
    store = opened(begun)
    assert store.missing() == [0, 2, 4]
    store.add(record(2))
    store.close()
    assert file.read_bytes() == whole + json.dumps(record(2)).encode() + b"\n"


@pytest.mark.parametrize("line", ["{", "[]", '{"point": 9}', json.dumps(record(5)), json.dumps(record(0, "fine"))])
def test_a_spoilt_line_is_named(begun: Path, line: str) -> None:
    file = begun / "out" / "points.jsonl"
    file.write_text(line + "\n" + file.read_text())
    with pytest.raises(UserError, match=r"points\.jsonl:1: not the record of a point; --restart"):
        opened(begun)


CHANGES = [
    ({"text": FILE.replace("seed = 7", "seed = 8")}, "the sweep file changed"),
    ({"text": FILE.replace("to = 0.6", "to = 0.7")}, "the sweep file changed"),
    ({"text": FILE.replace("duration_s = 0.5", "duration_s = 0.6")}, "the sweep file changed"),
    ({"text": FILE.replace("samples = 5", "samples = 4")}, "the sweep file changed"),
    ({"configuration": "other"}, "the scenario or a file that it names changed"),
    ({"program": "other"}, "the program sextant-mil changed"),
]


@pytest.mark.parametrize(("change", "words"), CHANGES)
def test_another_sweep_is_refused_or_begun_anew(begun: Path, change: dict[str, str], words: str) -> None:
    kept = (begun / "out" / "points.jsonl").read_bytes()
    with pytest.raises(UserError) as refusal:
        opened(begun, **change)
    assert words in str(refusal.value)
    assert "--restart discards" in str(refusal.value)
    assert (begun / "out" / "points.jsonl").read_bytes() == kept
    store = opened(begun, **change, restart=True)
    assert not store.records
    store.close()


def test_more_samples_of_the_same_seed_go_on(begun: Path) -> None:
    store = opened(begun, text=FILE.replace("samples = 5", "samples = 7"))
    assert store.missing() == [0, 2, 4, 5, 6]
    store.close()
    with pytest.raises(UserError, match="the sweep file changed"):
        opened(begun)


LISTED = 'scenario = "scenario.toml"\npoints = "points.csv"\n'


def test_more_rows_at_the_end_of_a_list_go_on(tmp_path: Path) -> None:
    file = tmp_path / "points.csv"
    file.write_text("a.b,a.c\n1,2\n3,4\n")
    store = opened(tmp_path, LISTED)
    store.add(record(1))
    store.close()
    file.write_text("a.b,a.c\n1,2 # the first\n3,4\n5,6\n")
    store = opened(tmp_path, LISTED)
    assert store.missing() == [0, 2]
    store.close()
    for other in ("a.b,a.c\n1,2\n3,5\n5,6\n", "a.c,a.b\n1,2\n3,4\n5,6\n"):
        file.write_text(other)
        with pytest.raises(UserError, match="the sweep file changed"):
            opened(tmp_path, LISTED)


def test_more_values_of_coupled_keys_go_on(tmp_path: Path) -> None:
    coupled = 'scenario = "scenario.toml"\n[[coupled]]\na.b = [1, 2]\na.c = [3, 4]\n'
    store = opened(tmp_path, coupled)
    store.add(record(1))
    store.close()
    store = opened(tmp_path, coupled.replace("2]", "2, 9]").replace("4]", "4, 9]"))
    assert store.missing() == [0, 2]
    store.close()
    with pytest.raises(UserError, match="the sweep file changed"):
        opened(tmp_path, coupled.replace("4]", "5]"))


def test_plots_and_time_limit_may_change(begun: Path) -> None:
    store = opened(begun, text='time_limit_s = 9\nname = "other"\n' + FILE + '[plot]\nmetrics = ["flux_mean_wb"]\n')
    assert store.missing() == [0, 2, 4]
    store.close()


def test_one_sweep_at_a_time(begun: Path) -> None:
    store = opened(begun)
    with pytest.raises(UserError, match="another sweep runs in"):
        opened(begun)
    store.close()
    opened(begun).close()


def test_directories_that_are_none(begun: Path, tmp_path: Path) -> None:
    (begun / "out" / "sweep.json").write_text("{}")
    with pytest.raises(UserError, match="is no state of a sweep"):
        opened(begun)
    (begun / "out" / "sweep.json").unlink()
    with pytest.raises(UserError, match="is there without"):
        opened(begun)
    (tmp_path / "file").touch()
    with pytest.raises(UserError, match="cannot be written: File exists"):
        SweepStore(tmp_path / "file", sweep_of(tmp_path), "", "")


def test_a_full_disk_is_a_sentence_and_keeps_every_finished_point(begun: Path) -> None:
    store = opened(begun)
    finished = store.missing()[0]
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    size = (begun / "out" / "points.jsonl").stat().st_size
    resource.setrlimit(resource.RLIMIT_FSIZE, (size + 10, limits[1]))
    try:
        with pytest.raises(UserError, match=r"points\.jsonl cannot be written: File too large"):
            store.add(record(finished))
        store.close()
        with pytest.raises(UserError, match="cannot be written: File too large"):
            opened(begun)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert (begun / "out" / "points.jsonl").stat().st_size == size
    store = opened(begun)
    assert finished in store.missing()
    store.close()

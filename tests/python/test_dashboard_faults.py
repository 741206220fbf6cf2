"""Faults for the plant from the dashboard: only from the page that commands, and those that the program lists."""

import json
import secrets
import socket
import threading
import tomllib
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest
from fake_drive import FakeDrive
from page_client import TOKEN, DashboardProcess, PageClient, wait_for
from programs import ProgramProcess, overrides, program
from sextant_py import inject
from sextant_py.dashboard import program as dashboard_program
from sextant_py.errors import UserError
from sextant_py.paths import ROOT

KEYS = [
    {"key": "kind", "unit": "", "meaning": "what breaks", "choices": ["none", "open_phase", "a_new_kind"]},
    {"key": "until_s", "unit": "s", "meaning": "end", "least": 0, "most": 1e6},
]


class Plant:
    """The socket of a program that takes faults: lists those keys, and refuses a_new_kind."""

    def __init__(self, path: Path) -> None:
        self.given: list[dict] = []
        self.is_slow = threading.Event()
        self.may_reply = threading.Event()
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._socket.bind(str(path))
        self._socket.listen()
        threading.Thread(target=self._serve, daemon=True).start()

    def _serve(self) -> None:
        while True:
            try:
                client, _ = self._socket.accept()
            except OSError:
                return
            with client:
                request = client.recv(4096).decode()
                if self.is_slow.is_set():
                    self.may_reply.wait(4)
                client.send(self._reply(request).encode())

    def _reply(self, request: str) -> str:
        if request == "describe":
            return json.dumps(KEYS)
        self.given.append(tomllib.loads(request))
        return "it is not possible" if self.given[-1]["kind"] == "a_new_kind" else "ok"

    def close(self) -> None:
        self._socket.close()


@pytest.fixture
def plant(tmp_path: Path) -> Iterator[Plant]:
    plant = Plant(tmp_path / "faults")
    yield plant
    plant.close()


@pytest.fixture
def dashboard(plant: Plant, domain: int, bus_address: str, tmp_path: Path) -> Iterator[DashboardProcess]:
    words = ("--allow-command", "--can", bus_address, "--token", TOKEN, "--demand-timeout", "20")
    with (
        FakeDrive(bus_address),
        DashboardProcess(domain, tmp_path, *words, "--fault-socket", tmp_path / "faults") as it,
    ):
        yield it


def in_control(dashboard: DashboardProcess, stack: ExitStack) -> PageClient:
    page = stack.enter_context(PageClient(dashboard.own_socket))
    page.send({"type": "take", "token": TOKEN})
    standing = page.until(lambda m: m["type"] == "command" and m["is_mine"])
    assert standing["takes_faults"]
    return page


def test_the_page_that_commands_is_shown_the_program_s_faults_and_gives_them(
    dashboard: DashboardProcess, plant: Plant
) -> None:
    with ExitStack() as stack:
        page = in_control(dashboard, stack)
        page.send({"type": "fault_keys"})
        assert page.message("faults")["keys"] == KEYS
        page.send({"type": "fault", "values": {"kind": "open_phase", "until_s": 0.5}})
        assert page.message("fault_reply") == {"type": "fault_reply", "problem": None, "kind": "open_phase"}
        assert plant.given == [{"kind": "open_phase", "until_s": 0.5}]
        page.send({"type": "fault", "values": {"kind": "a_new_kind"}})
        assert page.message("fault_reply")["problem"] == "the fault is refused: it is not possible"


def test_no_other_page_reaches_the_plant(dashboard: DashboardProcess, plant: Plant) -> None:
    with ExitStack() as stack:
        in_control(dashboard, stack)
        for address in (dashboard.socket, dashboard.own_socket):
            page = stack.enter_context(PageClient(address))
            for message in ({"type": "fault_keys"}, {"type": "fault", "values": {"kind": "open_phase"}}):
                page.send(message)
                assert page.message("refused")["text"] == "this page does not command; take control first."
    assert plant.given == []


@pytest.mark.parametrize("values", [None, [], {"kind": True}, {"kind": None}, {"kind": {}}, {"phase\nkind": "b"}])
def test_what_is_no_fault_is_refused(dashboard: DashboardProcess, plant: Plant, values: object) -> None:
    with ExitStack() as stack:
        page = in_control(dashboard, stack)
        page.send({"type": "fault", "values": values})
        assert page.message("refused")["text"].startswith("values must be")
    assert plant.given == []


def test_a_plant_that_is_slow_does_not_delay_the_commands(dashboard: DashboardProcess, plant: Plant) -> None:
    """While it is asked, demands of the page are taken, and a second request is refused."""
    with ExitStack() as stack:
        page = in_control(dashboard, stack)
        plant.is_slow.set()
        page.send({"type": "fault", "values": {"kind": "open_phase"}})
        page.send({"type": "demand", "torque_nm": 0.0, "enable": False, "fault_reset": False})
        page.send({"type": "fault", "values": {"kind": "none"}})
        assert "has not replied" in page.message("refused")["text"]
        page.send({"type": "demand", "torque_nm": "x", "enable": False, "fault_reset": False})
        assert "torque_nm" in page.message("refused")["text"], "demands are taken while the plant is asked"
        plant.may_reply.set()
        assert page.message("fault_reply")["kind"] == "open_phase"


def test_a_program_that_is_gone_is_a_sentence(dashboard: DashboardProcess, plant: Plant, tmp_path: Path) -> None:
    plant.close()
    (tmp_path / "faults").unlink()
    with ExitStack() as stack:
        page = in_control(dashboard, stack)
        page.send({"type": "fault_keys"})
        assert "no program takes faults on" in page.message("fault_reply")["problem"]


def test_a_program_lists_the_kinds_that_it_takes_and_refuses_without_words_of_an_option(tmp_path: Path) -> None:
    """sextant-plant waits for its drive meanwhile."""
    path, link = tmp_path / "own", f"sextant_test_{secrets.token_hex(4)}"
    command = [program("sextant-plant"), ROOT / "configs" / "plant.toml", "--fault-socket", path]
    words = overrides(("hil.pacing=lockstep", f"hil.link={link}"))
    with ProgramProcess([*command, *words], tmp_path / "plant.txt") as plant:
        wait_for(path.exists, "the socket", plant.text)
        keys = {key["key"]: key for key in inject.keys(path)}
        kinds = keys["kind"]["choices"]
        assert {"none", "open_phase", "link_sag"} < set(kinds)
        assert keys["phase"]["choices"] == ["a", "b", "c"]
        assert (keys["drift_a_s"]["unit"], keys["drift_a_s"]["least"]) == ("A/s", -1e6)
        assert "in a request" in keys["at_s"]["meaning"]
        assert not any("cables_swapped" in key["meaning"] for key in keys.values())
        for kind in kinds:  # cables_swapped, which no request makes, is not among them
            inject.inject(path, kind)
        with pytest.raises(UserError) as refused:
            inject.inject(path, "open_phase", phase="d", seed=3)
        assert "--set" not in str(refused.value) and "plant.faults.phase" in str(refused.value)
        with pytest.raises(UserError, match=r'"phases_swapped" or "open_phase".*, got "open_fase"') as refused:
            inject.inject(path, "open_fase")
        assert "cables_swapped" not in str(refused.value)
        with pytest.raises(UserError) as refused:
            inject.inject(path, "speed_jump", at_s=1, until_s=0.5)
        assert str(refused.value) == "the fault is refused: plant.faults: the fault must end after it began"


def test_a_fault_socket_needs_commands() -> None:
    with pytest.raises(UserError, match="--fault-socket has a meaning only with --allow-command"):
        dashboard_program.main(["--fault-socket", "x"])

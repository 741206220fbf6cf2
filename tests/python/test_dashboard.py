"""The dashboard's server: its protocol, who may command, and the end of the commands when the page is gone."""

import asyncio
import json
import os
import re
import resource
import signal
import socket
import subprocess
import time
from collections.abc import Iterator
from contextlib import ExitStack, suppress
from pathlib import Path

import psutil
import pytest
from cyclonedds.pub import DataWriter
from cyclonedds.topic import Topic
from fake_drive import FakeDrive
from page_client import PATIENCE_S, TOKEN, DashboardProcess, PageClient, wait_for
from sextant_py import dds, telemetry_contract, telemetry_types
from sextant_py.dashboard import frames, layout, program, server
from sextant_py.dashboard.access import Access
from sextant_py.dashboard.command_desk import CommandDesk
from sextant_py.dashboard.events import KEPT, Events
from sextant_py.errors import UserError
from sextant_py.paths import ROOT
from topic_writer import Writer
from tornado import httpclient, httpserver, netutil

SAMPLE = {"drive_id": 7, "t_ns": 12_345_678_901, "torque_mean_nm": 14.5, "i_a_a": -3.25, "sector": 4}
WITHOUT_COMMAND_S = 0.5


def test_every_panel_is_of_the_contract_and_of_one_unit() -> None:
    units = {signal.name: signal.unit for signal in telemetry_contract.signals(layout.STRUCT)}
    for panel in layout.panels():
        assert len({units[name] for name in panel.names}) == 1, panel.key
    described = {panel["key"]: panel for panel in layout.described()}
    assert described["torque"]["unit"] == "N·m"
    assert described["torque"]["lines"][0]["text"] == "requested torque, as received"
    assert described["flux"]["band"]["low"] == "flux_min_wb"


def test_a_temperature_of_a_later_contract_gets_a_panel(monkeypatch: pytest.MonkeyPatch) -> None:
    signals = telemetry_contract.signals(layout.STRUCT)
    warm = telemetry_contract.Signal("winding_temperature_c", "float", "°C", "temperature of the winding", False)
    monkeypatch.setattr(layout, "signals", lambda _: (*signals, warm))
    assert layout.described()[-1]["lines"][0]["signal"] == "winding_temperature_c"
    assert layout.described()[-1]["unit"] == "°C"
    monkeypatch.setattr(layout, "signals", lambda _: signals[3:8])
    with pytest.raises(UserError, match="has no DriveTelemetry"):
        layout.panels()


@pytest.mark.parametrize(
    ("origin", "host", "is_own"),
    [
        ("http://127.0.0.1:8150", "127.0.0.1:8150", True),
        ("http://localhost:8150", "localhost:8150", True),
        ("http://[::1]:8150", "[::1]:8150", True),
        ("http://192.0.2.7:8150", "192.0.2.7:8150", True),
        ("http://127.0.0.1:8151", "127.0.0.1:8150", False),
        ("https://evil.example", "127.0.0.1:8150", False),
        ("http://evil.example:8150", "evil.example:8150", False),  # a name that resolves to this machine
        ("http://127.0.0.1.evil.example:8150", "127.0.0.1.evil.example:8150", False),
        ("null", "127.0.0.1:8150", False),
        ("http://[", "127.0.0.1:8150", False),
        ("file://", "", False),
    ],
)
def test_origins(origin: str, host: str, is_own: bool) -> None:
    assert Access("127.0.0.1", TOKEN).is_own_origin(origin, host) == is_own


def test_tokens() -> None:
    access = Access("127.0.0.1", TOKEN)
    assert access.may_command(TOKEN)
    for wrong in ("", TOKEN[:-1], TOKEN + "x", None, 1, ["x"], "ä", "\ud800"):
        assert not access.may_command(wrong)
    assert not Access("127.0.0.1", None).may_command("")


def telemetry_writer(domain: int, **values: object) -> Writer:
    kind = telemetry_types.struct("DriveTelemetry")
    state = telemetry_types.DriveStateKind.TORQUE
    return Writer(domain, dds.TELEMETRY, kind, dds.streaming_qos(1), **{**SAMPLE, "state": state, **values})


def state_writer(domain: int) -> Writer:
    kind = telemetry_types.struct("DriveState")
    values = {"drive_id": 7, "faults_active": 1 << 8, "faults_latched": 1 << 8 | 1 << 0, "reason": "too much current"}
    return Writer(domain, dds.STATE, kind, dds.latched_qos(), state=telemetry_types.DriveStateKind.FAULT, **values)


@pytest.fixture
def dashboard(domain: int, tmp_path: Path) -> Iterator[DashboardProcess]:
    with DashboardProcess(domain, tmp_path) as process:
        yield process


def test_a_page_gets_contract_telemetry_and_state(dashboard: DashboardProcess, domain: int) -> None:
    with telemetry_writer(domain), state_writer(domain), PageClient(dashboard.socket) as page:
        hello = page.message("hello")
        assert hello["domain"] == domain
        assert hello["columns"] == [*dds.contract_fields("DriveTelemetry")[1:]]
        assert hello["states"][4] == "TORQUE"
        assert "current" in hello["faults"]["OVER_CURRENT"]
        assert hello["rejections"]["rejected_wrong_crc"] == "CRC"
        found = page.until(lambda m: m["type"] == "status" and m["drives"] and m["drives"][0]["state"])["drives"][0]
        assert found["drive_id"] == 7
        assert found["state"]["active"] == ["OVER_CURRENT"]
        assert found["state"]["latched"] == ["COMMAND_LOST", "OVER_CURRENT"]
        assert found["state"]["reason"] == "too much current"
        page.send({"type": "watch", "drive": 7})
        sequences: list[float] = []
        while len(sequences) < 30:
            drive, columns = page.frame()
            values = {name: columns[index] for index, name in enumerate(hello["columns"])}
            assert drive == 7
            for name, value in {**SAMPLE, "state": 4}.items():
                assert name == "drive_id" or set(values[name]) == {value}, name
            sequences += values["sequence"]
        assert sequences == sorted(set(sequences))


OVER_CURRENT, OPEN_PHASE = 1 << 8, 1 << 15


def change(t_ns: int, state: str, latched: int = 0, active: int = 0, reason: str = "") -> object:
    kind = telemetry_types.DriveStateKind[state]
    return telemetry_types.sample(
        telemetry_types.struct("DriveState"),
        t_ns=t_ns, state=kind, faults_latched=latched, faults_active=active, reason=reason,
    )  # fmt: skip


def test_events_are_changes_with_their_times() -> None:
    events = Events()
    events.take(change(1_000_000_000, "TORQUE"), 3_000_000_000, 100.0)
    events.take(change(1_000_000_000, "TORQUE"), 3_500_000_000, 100.5)  # a repetition
    events.take(change(4_000_000_000, "FAULT", OPEN_PHASE, OPEN_PHASE, "open phase"), 4_000_000_000, 101.0)
    events.take(change(4_000_100_000, "FAULT", OPEN_PHASE | OVER_CURRENT, OVER_CURRENT), None, 101.0)
    events.take(change(5_000_000_000, "STANDBY"), 5_000_000_000, 102.0)
    found = events.described()
    assert [(event["from"], event["state"]) for event in found] == [
        (None, "TORQUE"), ("TORQUE", "FAULT"), (None, "FAULT"), ("FAULT", "STANDBY"),
    ]  # fmt: skip
    assert [event["latched"] for event in found] == [[], ["OPEN_PHASE"], ["OVER_CURRENT"], []]
    assert [event["gone"] for event in found] == [[], [], ["OPEN_PHASE"], ["OVER_CURRENT"]]
    assert [event["reset"] for event in found] == [False, False, False, True]
    assert [event["time_s"] for event in found] == pytest.approx([98.0, 101.0, 101.0, 102.0])
    for k in range(3 * KEPT):
        events.take(change(k, "READY" if k % 2 else "TORQUE"), None)
    assert len(events.described()) == KEPT
    assert events.described()[-1]["t_ns"] == 3 * KEPT - 1


def test_a_page_gets_every_change_of_the_state(dashboard: DashboardProcess, domain: int) -> None:
    """Also those that follow each other sooner than the dashboard polls."""
    node = dds.Node(domain)
    kind = telemetry_types.struct("DriveState")
    writer = DataWriter(node.participant, Topic(node.participant, dds.STATE, kind), dds.latched_qos(16))
    sequence = iter(range(1000))

    def write(t_ns: int, state: str, latched: int = 0) -> None:
        writer.write(
            telemetry_types.sample(
                kind, drive_id=7, sequence=next(sequence), t_ns=t_ns, state=telemetry_types.DriveStateKind[state],
                faults_latched=latched,
            )
        )  # fmt: skip

    def described(message: dict) -> list[tuple[str, int]]:
        drives = message["drives"] if message["type"] == "status" else []
        return [(event["state"], event["t_ns"]) for event in drives[0]["events"]] if drives else []

    with PageClient(dashboard.socket) as page:
        page.until(described, lambda: write(1, "READY"))
        write(2, "MAGNETISING")
        write(3, "TORQUE")
        write(4, "FAULT", OPEN_PHASE)
        found = page.until(lambda m: len(described(m)) == 4)
    assert described(found) == [("READY", 1), ("MAGNETISING", 2), ("TORQUE", 3), ("FAULT", 4)]
    assert found["drives"][0]["events"][-1]["latched"] == ["OPEN_PHASE"]


def test_a_frame_is_what_its_description_says() -> None:
    kind = telemetry_types.struct("DriveTelemetry")
    samples = [telemetry_types.sample(kind, sequence=2**40 + k, speed_rad_s=k + 0.5) for k in range(3)]
    data = frames.TelemetryFrames().encode(9, samples)
    columns = frames.columns()
    begin = 16 + 8 * 3 * columns.index("speed_rad_s")
    assert data[:16] == bytes([1, 0, 0, 0, 9, 0, 0, 0, len(columns), 0, 0, 0, 3, 0, 0, 0])
    assert data[begin : begin + 24] == bytes.fromhex("000000000000e03f 000000000000f83f 0000000000000440")


def test_a_drive_stops_sending_and_returns(dashboard: DashboardProcess, domain: int) -> None:
    def is_timed_out(message: dict) -> bool:
        return message["type"] == "status" and bool(message["drives"]) and bool(message["drives"][0]["timed_out"])

    with PageClient(dashboard.socket) as page:
        with telemetry_writer(domain):
            page.until(lambda m: m["type"] == "status" and m["drives"])
        timed_out = page.until(is_timed_out)["drives"][0]["timed_out"]
        assert timed_out["age_s"] >= 1
        assert "domain" in timed_out["reason"] or "no sample arrives" in timed_out["reason"]
        with telemetry_writer(domain):
            page.until(lambda m: m["type"] == "status" and not is_timed_out(m))
            wait_for(lambda: dashboard.text().count("drive 7: telemetry arrives") == 2, "the return", dashboard.text)
    assert "drive 7: no telemetry; " in dashboard.text()


def test_no_drive_is_explained_on_the_page_and_in_the_terminal(dashboard: DashboardProcess, domain: int) -> None:
    with PageClient(dashboard.socket) as page:
        problems = page.until(lambda m: m["type"] == "status" and m["problems"])["problems"]
    assert len(problems) == 1
    assert f"no other DDS participant was discovered (domain {domain}, " in problems[0]
    wait_for(lambda: f"dashboard: {problems[0]}\n" in dashboard.text(), "the sentence", dashboard.text)


WRONG = ["nonsense", "[1]", "{}", '{"type": "dance"}', '{"type": "watch", "drive": "1"}', '{"type": "demand"}', "\0"]
HUGE = "1" + "0" * 400
WRONG += ["[" * 60_000, f'{{"type": "watch", "drive": {HUGE}}}', f'{{"type": {"9" * 5000}}}', '{"type": "\\ud800"}']


def test_a_wrong_message_is_refused_and_nothing_else(dashboard: DashboardProcess) -> None:
    with PageClient(dashboard.socket) as page:
        for text in WRONG:
            page.send(text)
            assert page.message("refused")["text"].endswith("."), text
        page.message("status")


UPGRADE = (
    "GET /socket HTTP/1.1\r\nHost: 127.0.0.1\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n"
)


def test_a_page_that_does_not_reply_is_disconnected(domain: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(server, "PING_S", 0.2)

    async def connect() -> None:
        access = Access("127.0.0.1", None)
        hub = server.Hub(domain, access, CommandDesk(access, None))
        sockets = netutil.bind_sockets(0, "127.0.0.1")
        httpserver.HTTPServer(server.application(hub)).add_sockets(sockets)
        reader, writer = await asyncio.open_connection(*sockets[0].getsockname())
        writer.write(UPGRADE.encode())
        received = await asyncio.wait_for(reader.read(), PATIENCE_S)
        assert b'"type": "hello"' in received
        assert hub.pages == set()

    loop = asyncio.new_event_loop()
    loop.run_until_complete(connect())
    loop.close()


def test_another_site_is_refused(dashboard: DashboardProcess) -> None:
    for origin in ("https://evil.example", "null", "http://127.0.0.1:1"):
        with pytest.raises(httpclient.HTTPClientError, match="403"), PageClient(dashboard.socket, origin):
            pass
    own = dashboard.address.partition("#")[0].rstrip("/")
    with PageClient(dashboard.socket, own) as page:
        page.message("hello")


@pytest.mark.parametrize("origin", [None, "http://evil.example:8150"])
def test_a_name_that_only_resolves_to_this_machine_is_refused(dashboard: DashboardProcess, origin: str | None) -> None:
    with (
        pytest.raises(httpclient.HTTPClientError, match="403: This name is not one of this dashboard"),
        PageClient(dashboard.socket, origin, host="evil.example:8150"),
    ):
        pass


def get(address: str, **headers: str) -> httpclient.HTTPResponse:
    client = httpclient.HTTPClient()
    try:
        return client.fetch(address, headers=headers, raise_error=False)
    finally:
        client.close()


def test_files_of_the_page(dashboard: DashboardProcess) -> None:
    page = get(dashboard.address)
    assert page.code == 200
    assert "frame-ancestors 'none'" in page.headers["Content-Security-Policy"]
    assert get(dashboard.address + "js/main.js").headers["Content-Type"].startswith("text/javascript")
    assert get(dashboard.address + "../server.py").code in (403, 404)
    assert get(dashboard.address + "%2e%2e/server.py").code in (403, 404)
    for file in ("", "captures/1.h5"):
        refused = get(dashboard.address + file, Host="evil.example")
        assert (refused.code, refused.reason) == (403, "This name is not one of this dashboard")


def test_the_page_names_no_other_server() -> None:
    pages = ROOT / "scripts" / "sextant_py" / "dashboard" / "page"
    files = [file for kind in ("*.js", "*.css", "*.html") for file in pages.rglob(kind) if "vendor" not in file.parts]
    assert len(files) > 10
    for file in files:
        assert "://" not in file.read_text(encoding="utf-8").replace("`${scheme}://${location.host}/socket`", ""), file


def test_a_port_that_is_taken() -> None:
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        command = [ROOT / "scripts" / "dashboard", "--port", str(port)]
        found = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert found.returncode == 2
    assert found.stderr == (
        f"dashboard: port {port} of 127.0.0.1 is taken; --port names another, and --port 0 takes any free one.\n"
    )


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--port", "65536"), "--port 65536 is not a port"),
        (("--domain", "231"), "--domain 231 is not a DDS domain"),
        (("--token", TOKEN), "--token has a meaning only with --allow-command"),
        (("--can", "socketcan:can0"), "--can has a meaning only with --allow-command"),
        (("--demand-timeout", "1"), "--demand-timeout has a meaning only with --allow-command"),
        (("--allow-command", "--demand-timeout", "0"), "--demand-timeout must be 0.2 to 30 s"),
        (("--allow-command", "--token", "short"), "--token must have at least 8 characters"),
        (("--allow-command", "--can", "bus"), '"bus" is not the address of a CAN bus'),
        (("--host", "no.such.host.invalid"), "--host no.such.host.invalid is no address"),
        (("--host", "192.0.2.200", "--port", "0"), "192.0.2.200:0 cannot be listened at"),
    ],
)
def test_wrong_arguments(arguments: tuple[str, ...], said: str) -> None:
    with pytest.raises(UserError) as failure:
        program.main(list(arguments))
    assert str(failure.value).startswith(said)


class Commanding:
    """A dashboard that may command a drive, its pages, and the drive."""

    def __init__(self, process: DashboardProcess, drive: FakeDrive, stack: ExitStack) -> None:
        self.process, self.drive, self._stack = process, drive, stack

    def page(self, has_token: bool = True) -> PageClient:
        address = self.process.own_socket if has_token else self.process.socket
        page = self._stack.enter_context(PageClient(address))
        page.message("command")
        return page

    def in_control(self) -> PageClient:
        page = self.page()
        page.send({"type": "take", "token": TOKEN})
        page.until(lambda m: m["type"] == "command" and m["is_mine"])
        return page

    def at_torque(self, torque_nm: float = 10.0) -> PageClient:
        page = self.in_control()
        page.until(lambda m: m["type"] == "command" and m.get("ready"), lambda: demand(page, 0.0, False))
        page.until(lambda m: m["type"] == "command" and m["drive_state"] == "TORQUE", lambda: demand(page, torque_nm))
        return page

    def torque(self) -> float:
        return self.drive.accepted[-1][1]["TorqueRequest"]

    def check_no_command(self) -> None:
        wait_for(lambda: time.monotonic() - self.drive.accepted[-1][0] > WITHOUT_COMMAND_S, "the end of the commands")


DISABLE = {"type": "demand", "torque_nm": 0.0, "enable": False, "fault_reset": False}


def demand(page: PageClient, torque_nm: float, enable: bool = True, reset: bool = False) -> None:
    page.send({"type": "demand", "torque_nm": torque_nm, "enable": enable, "fault_reset": reset})


@pytest.fixture
def commanding(domain: int, bus_address: str, tmp_path: Path) -> Iterator[Commanding]:
    timeout = ("--demand-timeout", "2")  # beyond the 200 ms for which a machine may stand still
    arguments = ("--allow-command", "--can", bus_address, "--token", TOKEN, "--torque-limit", "50", *timeout)
    with ExitStack() as stack:
        drive = stack.enter_context(FakeDrive(bus_address))
        process = stack.enter_context(DashboardProcess(domain, tmp_path, *arguments))
        yield Commanding(process, drive, stack)


def test_a_page_with_the_token_commands_torque_and_releases(commanding: Commanding) -> None:
    page = commanding.at_torque(10.0)
    assert commanding.torque() == pytest.approx(10.0)
    assert commanding.drive.accepted[-1][1]["TorqueLimit"] == pytest.approx(50.0)
    page.send({"type": "release"})
    released = page.until(lambda m: m["type"] == "command" and m["holder"] is None)
    assert not released["is_mine"]
    commanding.check_no_command()
    assert str(commanding.drive.accepted[-1][1]["Enable"]) == "DISABLE"


def test_without_the_token_no_command_reaches_the_bus(commanding: Commanding) -> None:
    for page in (commanding.page(has_token=False), commanding.page()):
        for token in (None, "", "wrong", TOKEN + " ", 5, "\ud800"):
            page.send({"type": "take", "token": token})
            assert "token" in page.message("refused")["text"]
            demand(page, 10.0)
            assert "does not command" in page.message("refused")["text"]
        page.send({"type": "spoil", "kind": "crc", "frames": 1})
        assert "does not command" in page.message("refused")["text"]
    time.sleep(0.3)
    assert commanding.drive.accepted == []


def test_without_permission_there_is_no_command(dashboard: DashboardProcess) -> None:
    with PageClient(dashboard.socket) as page:
        assert page.message("command") == {"type": "command", "allowed": False}
        page.send({"type": "take", "token": TOKEN})
        assert "--allow-command" in page.message("refused")["text"]


def test_a_page_that_closes_ends_the_commands(commanding: Commanding) -> None:
    page = commanding.at_torque()
    page.close()
    commanding.check_no_command()
    assert str(commanding.drive.accepted[-1][1]["Enable"]) == "ENABLE"  # no disable: the drive's own timeout acts
    other = commanding.page()
    assert "gone" in other.until(lambda m: m["type"] == "command" and m.get("not_sending"))["not_sending"]
    commanding.at_torque(-5.0)
    assert commanding.torque() == pytest.approx(-5.0)


def test_a_page_that_stops_renewing_ends_the_commands(commanding: Commanding) -> None:
    page = commanding.at_torque()
    commanding.check_no_command()
    lost = page.until(lambda m: m["type"] == "command" and m["holder"] is None)
    assert "sent no demand for" in lost["not_sending"]
    demand(page, 10.0)
    assert "does not command" in page.message("refused")["text"]


def test_a_dashboard_that_crashes_ends_the_commands(commanding: Commanding) -> None:
    commanding.at_torque()
    os.kill(commanding.process.pid, signal.SIGKILL)
    commanding.check_no_command()


def test_a_dashboard_that_ends_disables_the_drive(commanding: Commanding) -> None:
    commanding.at_torque()
    commanding.process.send_signal(signal.SIGTERM)
    assert commanding.process.wait(30.0) == 0
    assert str(commanding.drive.accepted[-1][1]["Enable"]) == "DISABLE"


PAGES, WATCHES, SOCKETS = 250, 20, 1500
MOST_GROWTH = 300 << 20  # bytes


def unread_page(address: tuple[str, int]) -> socket.socket:
    """A page without the token that asks for telemetry again and again and reads nothing."""
    one = socket.create_connection(address, PATIENCE_S)
    one.setblocking(False)
    messages = (json.dumps({"type": "watch", "drive": 7 + number % 2}).encode() for number in range(WATCHES))
    frames = (bytes([0x81, 0x80 | len(text), 0, 0, 0, 0]) + text for text in messages)  # masked by zeros
    with suppress(BlockingIOError, ConnectionError):
        one.send(UPGRADE.encode() + b"".join(frames))
    return one


def test_a_page_keeps_its_drive_whatever_pages_without_the_token_do(commanding: Commanding, domain: int) -> None:
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (hard, hard))
    port = int(re.search(r":(\d+)/", commanding.process.address)[1])
    with ExitStack() as stack:
        stack.callback(resource.setrlimit, resource.RLIMIT_NOFILE, (soft, hard))
        stack.enter_context(telemetry_writer(domain))
        page = commanding.at_torque(10.0)
        for _ in range(50):  # some seconds, of which the server keeps the telemetry
            page.until(lambda m: m["type"] == "command", lambda: demand(page, 10.0))
        server_process = psutil.Process(commanding.process.pid)
        before = most = server_process.memory_info().rss
        attacked = 0
        for number in range(PAGES + SOCKETS):
            if number < PAGES:
                stack.callback(unread_page(("127.0.0.1", port)).close)
            else:
                idle = stack.enter_context(socket.socket())
                idle.setblocking(False)
                idle.connect_ex(("127.0.0.1", port))
            if number % 25 == 0 or number == PAGES + SOCKETS - 1:
                said = page.until(lambda m: m["type"] == "command", lambda: demand(page, 10.0))
                assert said["is_mine"], said
                attacked += 1
                most = max(most, server_process.memory_info().rss)
        accepted = len(commanding.drive.accepted)
        for _ in range(50):
            said = page.until(lambda m: m["type"] == "command", lambda: demand(page, 10.0))
            assert said["is_mine"], said
            most = max(most, server_process.memory_info().rss)
        print(f"{(most - before) / 2**20:.0f} MiB more with {PAGES} unread pages and {SOCKETS} idle sockets")
        # Also where the test itself stood still for longer than a demand holds.
        page.until(lambda m: m["type"] == "command" and m["drive_state"] == "TORQUE", lambda: demand(page, 10.0))
        assert len(commanding.drive.accepted) > accepted, "commands go on"
        assert most - before < MOST_GROWTH
        other = commanding.page()
        assert not other.message("command")["is_mine"], "another page with the token still finds room"


def test_one_page_commands_at_a_time(commanding: Commanding) -> None:
    first, second = commanding.in_control(), commanding.page()
    second.send({"type": "take", "token": TOKEN})
    assert "page 1 (127.0.0.1) commands" in second.message("refused")["text"]
    demand(second, 20.0)
    assert "does not command" in second.message("refused")["text"]
    first.close()
    second.send({"type": "take", "token": TOKEN})
    second.until(lambda m: m["type"] == "command" and m["is_mine"])


def test_a_torque_that_is_none_or_too_large_is_refused(commanding: Commanding) -> None:
    page = commanding.in_control()
    for torque in ('"10"', "null", "true", "1e300", "NaN", "Infinity", "50.01", "-51", HUGE, f"-{HUGE}"):
        page.send(f'{{"type": "demand", "torque_nm": {torque}, "enable": true, "fault_reset": false}}')
        assert "torque" in page.message("refused")["text"], torque
    assert {entry[1]["TorqueRequest"] for entry in commanding.drive.accepted} <= {0.0}


def test_wrong_frames_of_a_page_are_refused_by_the_drive_one_by_one(commanding: Commanding) -> None:
    page, drive = commanding.at_torque(), commanding.drive
    refused = drive.refused
    page.send({"type": "spoil", "kind": "crc", "frames": 2})
    wait_for(lambda: demand(page, 10.0) or drive.refused == refused + 2, "two refused frames")
    accepted = len(drive.accepted)
    wait_for(lambda: demand(page, 10.0) or len(drive.accepted) > accepted + 2, "right frames again")
    assert drive.refused == refused + 2


@pytest.mark.parametrize(
    ("kind", "frames"),
    [("nonsense", 3), (None, 3), (["crc"], 3), ("crc", 0), ("crc", 101), ("crc", True), ("crc", 1.5)],
)
def test_what_is_no_wrong_frame_is_refused(commanding: Commanding, kind: object, frames: object) -> None:
    page = commanding.in_control()
    page.send({"type": "spoil", "kind": kind, "frames": frames})
    assert "must be" in page.message("refused")["text"]


@pytest.mark.parametrize("end", [{"type": "release"}, DISABLE])
def test_the_frames_that_disable_are_right_ones(commanding: Commanding, end: dict[str, object]) -> None:
    page, drive = commanding.at_torque(), commanding.drive
    page.send({"type": "spoil", "kind": "lost", "frames": 100})
    page.send(end)
    wait_for(lambda: str(drive.accepted[-1][1]["Enable"]) == "DISABLE", "a frame that disables", within_s=2.0)


def test_a_page_that_does_not_command_sends_no_wrong_frames(commanding: Commanding) -> None:
    page = commanding.page()
    page.send({"type": "spoil", "kind": "crc", "frames": 3})
    assert "does not command" in page.message("refused")["text"]


def test_no_torque_beyond_that_of_the_running_drive_is_sent(domain: int, bus_address: str, tmp_path: Path) -> None:
    arguments = ("--allow-command", "--can", bus_address, "--token", TOKEN, "--demand-timeout", "30")
    with (
        ExitStack() as stack,
        FakeDrive(bus_address) as drive,
        DashboardProcess(domain, tmp_path, *arguments) as process,
    ):
        drive.available_nm = 40.0
        commanding = Commanding(process, drive, stack)
        page = commanding.at_torque(10.0)
        page.until(lambda m: m["type"] == "command" and m["torque_limit_nm"] == 40.0, lambda: demand(page, 100.0))
        page.until(lambda _: commanding.torque() == 40.0, lambda: demand(page, 100.0))
        page.until(lambda _: commanding.torque() == -40.0, lambda: demand(page, -100.0))
        drive.available_nm = 25.0  # it derates
        page.until(lambda _: commanding.torque() == -25.0, lambda: demand(page, -100.0))
        standing = page.until(lambda m: m["type"] == "command" and m["torque_limit_nm"] == 25.0)
        assert standing["temperatures"] == {
            "StatorTemperature": 71.5, "RotorTemperature": 90.0, "InverterTemperature": None
        }  # fmt: skip
        assert max(abs(entry[1]["TorqueRequest"]) for entry in drive.accepted) <= 40.0


def test_a_drive_that_trips_is_not_enabled_again_by_itself(domain: int, bus_address: str, tmp_path: Path) -> None:
    arguments = ("--allow-command", "--can", bus_address, "--token", TOKEN, "--demand-timeout", "30")
    with (
        ExitStack() as stack,
        FakeDrive(bus_address, fault_after=20) as drive,
        DashboardProcess(domain, tmp_path, *arguments) as process,
    ):
        page = Commanding(process, drive, stack).at_torque()
        tripped = page.until(lambda m: m["type"] == "command" and m["tripped"], lambda: demand(page, 10.0))
        assert not tripped["enable"]
        # The frames before that, which a drive that is late has still to read.
        wait_for(lambda: str(drive.accepted[-1][1]["Enable"]) == "DISABLE", "the end of enable")
        count = len(drive.accepted)
        for _ in range(20):
            demand(page, 10.0)
            time.sleep(0.05)
        wait_for(lambda: len(drive.accepted) > count, "a frame after the demands")
        assert {str(entry[1]["Enable"]) for entry in drive.accepted[count:]} == {"DISABLE"}
        demand(page, 0.0, enable=False, reset=True)
        wait_for(lambda: drive.accepted[-1][1]["FaultReset"], "the reset")

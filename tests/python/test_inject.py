"""What scripts/inject asks of a program, and what it says of a refusal."""

import socket
import threading
import tomllib
from pathlib import Path

import pytest
from sextant_py import inject
from sextant_py.errors import UserError


class Program:
    """Takes one request on a socket of its own, with this reply."""

    def __init__(self, path: Path, reply: str) -> None:
        self.request = ""
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._socket.bind(str(path))
        self._socket.listen()
        self._thread = threading.Thread(target=self._serve, args=(reply,), daemon=True)
        self._thread.start()

    def _serve(self, reply: str) -> None:
        client, _ = self._socket.accept()
        with client:
            self.request = client.recv(4096).decode()
            client.send(reply.encode())

    def end(self) -> None:
        self._thread.join(10)
        self._socket.close()


@pytest.mark.parametrize("kind", ["open_phase", "open_phase phase=b", "open_phase\nphase=b"])
def test_a_kind_is_one_value_whatever_it_is(tmp_path: Path, kind: str) -> None:
    program = Program(tmp_path / "faults", "ok")
    assert inject.main([str(tmp_path / "faults"), kind, "until_s=0.1"]) == 0
    program.end()
    assert tomllib.loads(program.request) == {"kind": kind, "until_s": 0.1}


def test_a_refusal_is_one_sentence_of_the_program(tmp_path: Path) -> None:
    program = Program(
        tmp_path / "faults", "plant.faults.phase: must be one of a, b, c\nplant.faults.seed: unknown key\n"
    )
    with pytest.raises(UserError) as refused:
        inject.inject(tmp_path / "faults", "open_phase", phase="d")
    program.end()
    text = "plant.faults.phase: must be one of a, b, c; plant.faults.seed: unknown key"
    assert str(refused.value) == f"the fault is refused: {text}"


def test_a_request_without_a_key_is_not_sent(tmp_path: Path) -> None:
    """A program takes an empty request for one that is none, and gives no reply."""
    with pytest.raises(UserError, match=r"no key of \[plant.faults\] is given"):
        inject.give(tmp_path / "faults", {})

"""Where the project's files are: in the checkout, or below the interpreter's prefix where pip has installed them."""

import sys
from pathlib import Path

_CHECKOUT = Path(__file__).resolve().parents[2]
IS_CHECKOUT = (_CHECKOUT / "configs").is_dir()
ROOT = _CHECKOUT if IS_CHECKOUT else Path(sys.prefix) / "share" / "sextant"
OUT = ROOT / "out" if IS_CHECKOUT else Path("out")
DBC = ROOT / "configs" / "interfaces" / "sextant.dbc"
IDL = ROOT / "configs" / "interfaces" / "telemetry.idl"
TELEMETRY = ROOT / "configs" / "interfaces" / "telemetry.json"
LOOPBACK = ROOT / "configs" / "cyclonedds_loopback.xml"
ECU = ROOT / "configs" / "ecu.toml"

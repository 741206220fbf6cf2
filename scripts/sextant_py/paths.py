"""Where the project's files are."""

from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
DBC = ROOT / "configs" / "interfaces" / "sextant.dbc"
IDL = ROOT / "configs" / "interfaces" / "telemetry.idl"
LOOPBACK = ROOT / "configs" / "cyclonedds_loopback.xml"
ECU = ROOT / "configs" / "ecu.toml"

"""The live dashboard: DDS telemetry of the drives on a page, by WebSocket, and commands over CAN where allowed."""

from .program import main

__all__ = ["main"]

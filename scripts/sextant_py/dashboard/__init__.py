"""The live dashboard: DDS telemetry of the drives on a page, by WebSocket, and commands over CAN where allowed."""


def main(arguments: list[str]) -> int:
    from .program import main as perform

    return perform(arguments)

"""The drive on a microcontroller: docs/embedded.md."""

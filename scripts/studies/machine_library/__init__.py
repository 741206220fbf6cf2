"""The drive on every published machine of configs/machines: docs/machine_library.md."""

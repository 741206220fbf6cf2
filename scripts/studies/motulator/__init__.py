"""Sextant beside motulator: docs/motulator.md."""

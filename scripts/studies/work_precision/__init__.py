"""Error and time of the plant's integrators: docs/performance_plant.md."""

"""The benchmarks beside their targets: stages that return figures, one report, one table of docs/performance.md."""

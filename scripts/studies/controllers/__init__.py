"""The control methods of the drive compared: docs/controllers.md."""

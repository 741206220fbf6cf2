"""The torque over speed and wrong parameters: docs/torque_map."""

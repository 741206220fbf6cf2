"""The control methods of a drive, as the key control.controller names them."""

METHODS = ("dtc", "duty_ratio", "predictive", "pwm_dtc", "feedback_linearisation", "foc", "deadbeat")

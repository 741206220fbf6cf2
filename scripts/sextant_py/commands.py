"""The commands of the Python package, each a module of its name with a main."""

COMMANDS = {
    "vcu": "plays a torque profile to a drive over CAN",
    "monitor": "shows the telemetry of the drives on the network",
    "dashboard": "serves a page with the live telemetry of the drives",
    "record": "records the telemetry of one drive",
    "convert": "converts recordings between file formats",
    "playback": "plays a recording over DDS and CAN",
    "scope": "captures the waveform around a trigger",
    "plot": "draws a trace or a recording",
    "compare": "compares two runs metric by metric",
    "report": "makes a page for people from runs and recordings",
    "expect": "evaluates a recording by the limits of a scenario",
    "sweep": "runs a scenario at many points of its configuration",
    "nameplate": "makes machine, limits and configurations of a drive from a name plate",
    "identify": "measures inverter and stator at standstill, for the drive",
    "inject": "gives a running simulated plant a fault",
    "set": "sets parameters of a running drive",
    "get": "shows parameters of a running drive",
    "completion": "prints what a shell needs to complete these commands",
    "rt_check": "says what keeps this machine from hard real time",
}

"""The stages of scripts/bench, in the order of the table. A stage of your own is one more `Stage` in this list: a
function that takes a `Lab` and returns `Figure`s. What runs elsewhere hands its figures in with --add FILE.json."""

from .counts import INSTRUCTIONS
from .live import LIVE
from .peers import PEERS_STAGE
from .precision import PRECISION
from .speed import CONTROL, LOOP, PLANT, SCENARIOS
from .telemetry import GROWTH, TELEMETRY

STAGES = (CONTROL, PLANT, PRECISION, LOOP, PEERS_STAGE, TELEMETRY, GROWTH, LIVE, INSTRUCTIONS, SCENARIOS)

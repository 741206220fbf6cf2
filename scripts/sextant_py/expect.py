"""Evaluates a trace or a recording by the [expect] of a scenario, with verdict and JUnit as of sextant-mil."""

import argparse
import math
from pathlib import Path

import junitparser
from rich.console import Console
from rich.table import Table
from rich.text import Text

from . import expect_scenario, junit, mil_program
from .errors import UserError, run
from .expect_bounds import Bounds
from .expect_evaluation import Evaluation, LimitResult, evaluate
from .program_arguments import finite_seconds, parser_of

PLAIN_WIDTH = 110  # where there is no terminal
WORDS = {True: "pass", False: "FAIL", None: "OPEN"}
STYLES = {True: "", False: "bold red", None: "yellow"}

EXAMPLES = """examples:
  scripts/expect configs/scenarios/constant_torque.toml live.mcap --align 'rise torque_reference_nm 10'
  scripts/expect configs/scenarios/reversal.toml run.h5 --align 'fall torque_reference_nm 0' --junit out/live.xml
  scripts/expect step.toml virtual.csv --set metrics.window_from_s=1.5

RECORDING is a trace or a recording in any format, of a live drive, hardware in the loop or virtual time, or a result
directory of sextant-mil. sextant-mil reads the scenario. A recording has mean, minimum and maximum of each
millisecond, so a metric is known to bounds; a limit holds or does not where all of them say so, and is left open where
they do not. What is left open does not pass. Metrics that sextant-mil alone has, such as switching frequency,
harmonics and energies, are not in a recording, nor are those whose signals it lacks; they are open, and the result
says which. Time zero of the scenario is that of the recording, or --align says at which trigger of scripts/scope it was
at --at. Exit status: as of sextant-mil, 0 when everything that is expected holds, 1 when a limit does not hold or is
open, 3 when a fault latched that was not expected, 9 when nothing is expected and --require-expectations asks for it, 2
when an argument or a file is wrong."""


def parse_arguments(arguments: list[str]) -> argparse.Namespace:
    parser = parser_of("expect", __doc__, EXAMPLES)
    parser.add_argument("scenario", type=Path, metavar="SCENARIO.toml", help="with [expect]")
    parser.add_argument("recording", type=Path, metavar="RECORDING", help="that is evaluated")
    parser.add_argument("--junit", type=Path, metavar="FILE", help="write a JUnit file")
    parser.add_argument("--align", metavar="TRIGGER", help="trigger at which the scenario is at --at")
    parser.add_argument(
        "--at", type=finite_seconds, metavar="S", help="(default: metrics.step_s of the scenario, else 0)"
    )
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="overrides the scenario")
    parser.add_argument("--require-expectations", action="store_true", help="a scenario that expects nothing fails")
    parser.add_argument("--mil", type=Path, metavar="FILE", help="sextant-mil that reads the scenario")
    return parser.parse_args(arguments)


def bounds_text(bounds: Bounds) -> str:
    if math.isnan(bounds.low):
        return "no value"
    if math.isinf(bounds.low) and math.isinf(bounds.high):
        return "not known from the rows"
    if bounds.low == bounds.high:
        return f"{bounds.low:.5g}"
    if math.isinf(bounds.high):
        return f"≥ {bounds.low:.5g}"
    return f"≤ {bounds.high:.5g}" if math.isinf(bounds.low) else f"{bounds.low:.5g} … {bounds.high:.5g}"


def value_text(result: LimitResult) -> str:
    return result.absence if result.absence and result.holds is None else bounds_text(result.bounds)


def fault_name(evaluation: Evaluation) -> str:
    return f"fault {evaluation.scenario.fault}, {evaluation.scenario.fault_window}"


def fault_text(evaluation: Evaluation) -> str:
    if not evaluation.faults:
        return "no fault came"
    name, t_s = evaluation.faults[0]
    return f"{name} came first, at {t_s:.6f} s"


def print_table(evaluation: Evaluation) -> None:
    console = Console(highlight=False)
    if not console.is_terminal:
        console.width = PLAIN_WIDTH
    table = Table(box=None, pad_edge=False)
    for heading in ("limit of", "recording", "expected", "result"):
        table.add_column(heading, justify="left")
    if evaluation.scenario.fault:
        holds = evaluation.fault_holds
        table.add_row(fault_name(evaluation), fault_text(evaluation), "", WORDS[holds], style=STYLES[holds])
    for result in evaluation.limits:
        limit = result.limit
        where = f"{limit.metric}, {limit.window}" if limit.is_own else limit.metric
        cells = (where, value_text(result), limit.text, WORDS[result.holds])
        table.add_row(*map(Text, cells), style=STYLES[result.holds])
    console.print(Text(f"{evaluation.scenario.name}: {evaluation.verdict.replace('_', ' ')}"))
    for name, t_s in evaluation.faults:
        console.print(Text(f"fault {name} at {t_s:.6f} s"))
    if table.row_count:
        console.print(table)


def _outcome(holds: bool | None, kind: str, said: str) -> list[junitparser.Failure]:
    if holds:
        return []
    return [junitparser.Failure(f"{said}, which leaves it open" if holds is None else said, kind)]


def _limit_case(suite: str, result: LimitResult) -> junitparser.TestCase:
    case = junitparser.TestCase(result.limit.name, suite, 0)
    said = f"{result.limit.metric} is {value_text(result)}, expected {result.limit.text}"
    case.result = _outcome(result.holds, "limit", said)
    return case


def write_junit(evaluation: Evaluation, file: Path) -> None:
    """Suite and test cases have the names that sextant-mil gives them."""
    name, verdict = evaluation.scenario.name, evaluation.verdict
    suite = junitparser.TestSuite(name)
    case = junitparser.TestCase("verdict", name, 0)
    if verdict == "tripped":
        case.result = [junitparser.Error(fault_text(evaluation), verdict)]
    elif verdict == "fail":
        case.result = [junitparser.Failure("a limit does not hold or is open", verdict)]
    elif verdict == "nothing_expected":
        case.result = [junitparser.Skipped("it ran, and nothing was expected of it")]
    suite.add_testcase(case)
    if evaluation.scenario.fault:
        case = junitparser.TestCase(fault_name(evaluation), name, 0)
        case.result = _outcome(evaluation.fault_holds, "fault", fault_text(evaluation))
        suite.add_testcase(case)
    for result in evaluation.limits:
        suite.add_testcase(_limit_case(name, result))
    xml = junitparser.JUnitXml("expect")
    xml.add_testsuite(suite)
    junit.write(xml, file)


def main(arguments: list[str]) -> int:
    options = parse_arguments(arguments)
    if options.at is not None and options.align is None:
        raise UserError("--at is the instant of --align, which names the trigger.")
    scenario = expect_scenario.read(mil_program.find(options.mil), options.scenario, options.set)
    evaluation = evaluate(scenario, options.recording, options.align, options.at)
    print_table(evaluation)
    if options.junit:
        write_junit(evaluation, options.junit)
    return evaluation.status(options.require_expectations)


if __name__ == "__main__":
    run("expect", main)

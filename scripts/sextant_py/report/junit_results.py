"""A JUnit file, of sextant-mil, scripts/compare or another program: a run for each test suite."""

from pathlib import Path

import junitparser

from ..errors import UserError
from .model import BAD, GOOD, NEUTRAL, Check, Run


def _check(case: junitparser.TestCase) -> Check:
    for outcome in case.result:
        if isinstance(outcome, junitparser.Skipped):
            return Check(case.name, "", "", NEUTRAL, outcome.message or "")
        if isinstance(outcome, junitparser.Failure | junitparser.Error):
            return Check(case.name, "", "", BAD, " ".join((outcome.message or outcome.text or "").split()))
    return Check(case.name, "", "", GOOD)


def read(path: Path) -> list[Run]:
    try:
        found = junitparser.JUnitXml.fromfile(str(path))
        suites = [found] if isinstance(found, junitparser.TestSuite) else list(found)
        runs = []
        for suite in suites:
            checks = [_check(case) for case in suite if isinstance(case, junitparser.TestCase)]
            bad = any(check.result == BAD for check in checks)
            good = any(check.result == GOOD for check in checks)
            result = BAD if bad else GOOD if good else NEUTRAL
            word = {BAD: "fail", GOOD: "pass", NEUTRAL: "nothing evaluated"}[result]
            run = Run(suite.name or path.stem, "JUnit file", path, word, result, checks=checks)
            run.versions = [(entry.name, entry.value or "") for entry in suite.properties()]
            runs.append(run)
    except OSError as error:
        raise UserError(f"{path} cannot be read: {error.strerror}.") from None
    except Exception as error:
        raise UserError(
            f"{path} is no JUnit file: {(' '.join(str(error).split()) or type(error).__name__).rstrip('.')}."
        ) from None
    if not runs:
        raise UserError(f"{path} holds no test suite.")
    return runs

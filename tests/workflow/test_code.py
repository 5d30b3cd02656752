"""The code declared as a step's input is the code the step runs."""

import re
from pathlib import Path

from small_campaign import ROOT

from freerock.workflow import code

SCRIPTS = {path.name for path in (ROOT / "workflow/scripts").glob("*.py") if "study" not in path.name}


def test_every_module_a_step_imports_is_among_its_inputs(finished):
    """Against sys.modules at the end of each script of a real run."""
    seen = set()
    for trace in (finished / "trace").iterdir():
        script = re.match(r".*\.py", trace.name)[0]
        seen.add(script)
        declared = {Path(path).relative_to(ROOT) for path in code(ROOT / "workflow/scripts" / script)}
        imported = {Path(path).relative_to(finished.folder) for path in trace.read_text().split("\n")}
        assert imported <= declared, script
    assert seen == SCRIPTS


def test_imports_for_type_checkers_do_not_count(tmp_path):
    script = tmp_path / "script.py"
    script.write_text("from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from freerock import twin\n")
    assert code(script) == [str(script)]

"""Scripts beside the scenarios and the package that read reports."""

import subprocess
import sys
from pathlib import Path

import pytest

import falsify_av

REPOSITORY = Path(__file__).resolve().parents[2]


def script(place, *words, code=0):
    found = subprocess.run([sys.executable, *map(str, words)], cwd=place, capture_output=True, text=True)
    assert found.returncode == code, found.stderr
    return found.stderr if code else found.stdout


@pytest.fixture
def report(program, tmp_path):
    """A report of the campaign that pages of stacks have, with drivers of ours."""
    (tmp_path / "a.scn").write_text(
        f'edition 1\nimport "{REPOSITORY.as_posix()}/scenarios/external/stack_search.scn"\n'
        "campaign a { vehicle: model3 body: pursuer spawn: ahead_of_a_moving_car episode: until_passed\n"
        "evaluate { towns: [harbour] drivers: [idm, blind] pedestrians: [natural, intercept] episodes: 40 }\n"
        "search { towns: [harbour] drivers: [idm, blind] methods: [faults] budget: 2_000 runs: 1 episodes: 0 } }\n"
    )
    return falsify_av.run(tmp_path / "a.scn", out=tmp_path / "1")["a"].folder


def test_tables_of_stacks_are_made_from_a_report(report, tmp_path):
    table = script(tmp_path, REPOSITORY / "scenarios/external/stack_table.py", report).splitlines()
    cells = {row.split("|")[1].strip(): [cell.strip() for cell in row.split("|")[2:]] for row in table[2:]}
    assert set(cells) == {"`idm`", "`blind`"}
    faults, hits, close_faults, close_hits, needless = cells["`blind`"][:5]
    assert faults.endswith(" of 40") and close_faults.endswith(" of 40") and needless.startswith("0 of ")
    assert int(faults.split()[0]) <= int(hits) and int(close_faults.split()[0]) <= int(close_hits) and 0 < int(close_hits) <= 40
    study = script(tmp_path, REPOSITORY / "scenarios/studies/stacks_table.py", "numbers.csv", report)
    assert f"{close_hits} of 40" in study and len((tmp_path / "numbers.csv").read_text().splitlines()) == 7


def test_what_another_learner_needs_is_named_before_it_trains(tmp_path):
    code = (
        "import runpy, sys, types\n"
        "for name in ('torch', 'stable_baselines3', 'falsify_av.sb3'): sys.modules[name] = types.ModuleType(name)\n"
        "sys.modules['torch'].set_num_threads = lambda count: None\n"
        "sys.modules['stable_baselines3'].PPO = sys.modules['stable_baselines3'].SAC = None\n"
        "import falsify_av\n"
        "falsify_av.sb3 = sys.modules['falsify_av.sb3']\n"
        "sys.modules['scipy'] = sys.modules['pyarrow'] = None\n"
        "sys.argv = ['own_learner.py', '--ours']\n"
        f"runpy.run_path({str(REPOSITORY / 'python/examples/own_learner.py')!r}, run_name='__main__')\n"
    )
    (tmp_path / "asked.py").write_text(code)
    assert "--ours needs pyarrow and scipy: pip install pyarrow scipy" in script(tmp_path, "asked.py", code=2)

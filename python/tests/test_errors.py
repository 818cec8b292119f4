"""Bad input is a Python exception that states what is wrong; no order of calls ends the interpreter."""

import random

import numpy as np
import pytest
from gymnasium.vector import AutoresetMode

import falsify_av

CHOICE = {"campaign": "short", "town": "harbour", "driver": "blind", "task": "train"}


def test_a_wrong_scenario_is_an_exception_with_the_text_and_the_place(tmp_path):
    wrong = tmp_path / "wrong.scn"
    wrong.write_text('edition 1\nimport "std/paper.scn"\n\ncampaign c {\n  vehicel: model3\n}\n')
    with pytest.raises(falsify_av.ScenarioError, match="vehicel") as raised:
        falsify_av.make(wrong)
    first = next(each for each in raised.value.diagnostics if "vehicel" in each.message)
    assert (first.severity, first.line, first.column) == ("error", 5, 3)
    assert str(wrong) in str(raised.value)
    assert [each.code for each in falsify_av.check(wrong)] == [each.code for each in raised.value.diagnostics]


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"campaign": "nothing"}, "there is no campaign `nothing` here; there is short, steady"),
        ({"campaign": "short", "town": "atlantis"}, "there is no town `atlantis` here; there is harbour, village"),
        ({"campaign": "short", "town": "harbour", "reward": "r2"}, "choose with driver= one of behavior, blind"),
        ({**CHOICE, "seed": -1}, "the seed is -1"),
        ({**CHOICE, "render_mode": "human"}, "there is no render mode 'human'; there is 'rgb_array', which gymnasium.wrappers.HumanRendering shows"),
        ({**CHOICE, "maps": {"nowhere": "a.xodr"}}, "`nowhere`, which nothing uses"),
    ],
)
def test_wrong_names_are_errors_that_list_the_right_ones(scenario, options, text):
    with pytest.raises(ValueError, match=".*") as raised:
        falsify_av.make(scenario, **options)
    assert text in str(raised.value)


def test_unreadable_files_and_unknown_options(scenario, tmp_path):
    with pytest.raises(FileNotFoundError, match="cannot read .*missing.scn"):
        falsify_av.make(tmp_path / "missing.scn")
    with pytest.raises(OSError, match="cannot read"):
        falsify_av.make(tmp_path)
    with pytest.raises(TypeError, match="there is no option twon; did you mean `town`?"):
        falsify_av.make(scenario, twon="harbour")
    with pytest.raises(TypeError, match="the scenario is 42; give a file"):
        falsify_av.make(42)
    with pytest.raises(TypeError, match="the scenario is 8; give a file or a list of files; the number of worlds is num_envs=8"):
        falsify_av.make_vec(8)
    with pytest.raises(TypeError, match="list of texts"):
        falsify_av.make(scenario, settings="a=1")
    with pytest.raises(falsify_av.ScenarioError, match="nothing_of_this_name"):
        falsify_av.make(scenario, settings=["nothing_of_this_name=1"])


@pytest.mark.parametrize(
    ("action", "error", "text"),
    [
        (np.zeros(3), ValueError, r"shape \(3,\)"),
        (np.zeros((1, 2)), ValueError, r"shape \(1, 2\)"),
        (np.array([np.nan, 0.0]), ValueError, "number 0 .* is not finite"),
        (np.array([0.0, np.inf], np.float32), ValueError, "number 1 .* is not finite"),
        (np.array(["a", "b"]), TypeError, "elements of type"),
        (np.array([1j, 0]), TypeError, "elements of type complex128"),
        (None, TypeError, "elements of type object"),
        ([[1.0], [1.0, 2.0]], ValueError, "no array of numbers"),
    ],
)
def test_wrong_actions(scenario, action, error, text):
    env = falsify_av.make(scenario, **CHOICE)
    env.reset(seed=0)
    with pytest.raises(error, match=text):
        env.step(action)
    env.step(np.array([0, 1]))


def test_calls_at_the_wrong_time(scenario):
    env = falsify_av.make(scenario, **CHOICE, render_mode="rgb_array")
    for call in (lambda: env.step(np.zeros(2)), env.render, env.trace, lambda: env.suggested("homing")):
        with pytest.raises(RuntimeError, match="call reset"):
            call()
    env.reset(seed=0)
    while not any(env.step(np.zeros(2))[2:4]):
        pass
    with pytest.raises(RuntimeError, match="is over; call reset"):
        env.step(np.zeros(2))
    env.close()
    env.close()
    for call in (env.reset, env.render, env.trace, lambda: env.step(np.zeros(2))):
        with pytest.raises(RuntimeError, match="closed"):
            call()
    with pytest.raises(ValueError, match="counts? from 0"):
        falsify_av.make(scenario, **CHOICE).reset(options={"episode": -3})
    with pytest.raises(ValueError, match="no option speed"):
        falsify_av.make(scenario, **CHOICE).reset(options={"speed": 3})


def test_worlds_are_counted(scenario):
    for count in (0, 2**30):
        with pytest.raises(ValueError, match="the number of worlds"):
            falsify_av.make_vec(scenario, count, **CHOICE)
    env = falsify_av.make_vec(scenario, 2, **CHOICE)
    with pytest.raises(ValueError, match="3 seeds for 2 worlds"):
        env.reset(seed=[1, 2, 3])
    with pytest.raises(ValueError, match="no world"):
        env.reset(options={"reset_mask": np.zeros(2, bool)})


def test_ten_thousand_random_sequences_of_calls_raise_or_return(scenario):
    """Any order of calls with any values: only `ValueError`, `TypeError`, `RuntimeError` and `OverflowError` may be raised."""
    generator = random.Random(5)
    numbers = [0.0, 1.0, -1.0, 3.5, 1e308, -1e308, float("nan"), float("inf"), 5e-324]
    single = [falsify_av.make(scenario, **CHOICE) for _ in range(4)]
    modes = [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP, AutoresetMode.DISABLED]
    vectors = [falsify_av.make_vec(scenario, count, autoreset_mode=mode, **CHOICE) for count in (1, 3) for mode in modes]
    fine, wrong = 0, 0

    def action(count):
        shape = generator.choice([(2,), (count, 2), (count, 2), (2,), (3,), (count, 3), (), (0,), (2, 2, 2)])
        kind = generator.choice([np.float32, np.float64, np.float64, np.int8, np.float16, object, bool])
        values = [generator.choice(numbers) if generator.random() < 0.1 else generator.uniform(-4, 4) for _ in range(64)]
        with np.errstate(all="ignore"):
            return np.resize(np.array(values, np.float64), shape).astype(kind)

    def seed():
        return generator.choice([None, None, 0, 7, 2**62, -1, 2**64, "x", 1.5, [1, 2], [1, None, 3]])

    def options():
        return generator.choice([None, None, {}, {"episode": 3}, {"episode": -1}, {"episode": 2**53 + 1}, {"episode": "x"},
                                 {"reset_mask": np.array([True])}, {"reset_mask": np.array([True, False, True])}, {"odd": 1}])

    for _ in range(10_000):
        env = generator.choice(single + vectors)
        count = getattr(env, "num_envs", 1)
        for _ in range(generator.randint(1, 4)):
            call = generator.choice(["reset", "step", "step", "step", "step", "trace", "picture", "suggested", "end", "close"])
            try:
                if call == "reset":
                    env.reset(seed=seed(), options=options())
                elif call == "step":
                    env.step(action(count))
                elif call == "trace":
                    env.core.trace(generator.randint(0, 3))
                elif call == "picture":
                    env.core.picture(generator.randint(0, 3), generator.choice([0, 16, 1 << 40]))
                elif call == "suggested":
                    env.core.suggested(generator.randint(0, 3), generator.choice(["homing", "intercept", "other"]))
                elif call == "end":
                    env.core.end(generator.choice([0, 1, 99]))
                elif generator.random() < 0.002:
                    env.close()
                fine += 1
            except (ValueError, TypeError, RuntimeError, OverflowError) as error:
                assert str(error), call
                wrong += 1
    assert fine > 1000 and wrong > 1000, (fine, wrong)


@pytest.mark.parametrize("number", [1.5, "3", True, np.True_, None, [1]])
def test_seeds_and_episodes_are_whole_numbers(scenario, number):
    choice = {"town": "harbour", "driver": "blind", "task": "train"}
    env, vector = falsify_av.make(scenario, "short", **choice), falsify_av.make_vec(scenario, 2, "short", **choice)
    if number is not None:
        for each, seed in [(env, number), (vector, [1, number])]:
            with pytest.raises(TypeError, match="the seed is .*, which is no whole number"):
                each.reset(seed=seed)
        if not isinstance(number, list):
            with pytest.raises(TypeError, match="the seed is .*, which is no whole number"):
                vector.reset(seed=number)
    with pytest.raises(TypeError, match="the number of the episode is .*, which is no whole number"):
        env.reset(options={"episode": number})
    env.reset(seed=np.int64(3), options={"episode": np.int32(1)})


def test_names_and_places_are_alike_everywhere(scenario):
    assert falsify_av.ProgramError is falsify_av.program.ProgramError
    choice = {"town": "harbour", "driver": "blind", "task": "train"}
    one, many = falsify_av.make(scenario, "short", **choice), falsify_av.make_vec(scenario, 2, "short", **choice)
    assert np.array_equal(one.reset(seed=1)[0], many.reset(seed=1)[0][0])


def test_a_program_that_may_not_be_started_names_the_argument_of_python(tmp_path):
    (tmp_path / "a.scn").write_text('edition 1\ndriver mine = external(command: "python3 mine.py")\n')
    [found] = falsify_av.check(tmp_path / "a.scn")
    assert found.code == "external-not-allowed" and "allow_external=True" in str(found)

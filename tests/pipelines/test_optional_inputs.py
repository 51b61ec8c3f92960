"""Inputs that a case may bring or leave out, in the toy project."""

import json

import pytest

from tests.toy import Toy


@pytest.fixture
def toy_with_option(toy: Toy) -> Toy:
    """The toy project; its second stage multiplies by what an optional file says, else by 1."""
    seed = "seed_file: {about: where to start, format: record, place: input, option: --seed}"
    more = "factors: {about: factors, format: record, place: input, option: --factors, optional: "
    toy.edit("catalog/catalog.yml", seed, f"{seed}\n{more}true}}")
    toy.edit("pipelines/toy.py", '["numbers"], ["doubled"]', '["numbers", "factors"], ["doubled"]')
    node = "nodes/toy/double_numbers.py"
    toy.edit(node, "numbers: dict, p", "numbers: dict, factors: dict, p")
    toy.edit(node, "parameters.factor)", "factors.get('factor', 1))")
    return toy


def test_an_optional_input_may_come_and_go(toy_with_option: Toy) -> None:
    toy = toy_with_option
    toy.run()
    without = toy.total()
    toy.write("data/raw/more/record.json", json.dumps({"factor": 5}))
    case, seed = "catalog/cases/one.yml", "seed_file: seed/record.json"
    toy.edit(case, seed, f"{seed}, factors: more")
    assert "input factors changed" in toy.call("status", "--case", "one")
    toy.run()
    assert toy.total() == 5 * without
    assert toy.computed()[0] == "double_numbers"
    toy.edit(case, ", factors: more", "")
    toy.run()
    assert toy.total() == without
    assert toy.computed() == []  # the first result is still in the store


def test_an_optional_input_that_is_named_must_exist(toy_with_option: Toy) -> None:
    lone = "{seed_file: seed/record.json}"
    both = "{seed_file: seed/record.json, factors: nowhere.json}"
    toy_with_option.edit("catalog/cases/one.yml", lone, both)
    assert "input factors: nothing at" in toy_with_option.run(code=3)


def test_a_notebook_loads_what_is_absent_as_nothing(toy_with_option: Toy) -> None:
    loaded = toy_with_option.python("""
        from pipelines import open_case
        print(open_case("one").load("factors"))
    """)
    assert loaded.strip() == "{}"


def test_a_new_case_tells_of_optional_inputs_and_other_pipelines(toy_with_option: Toy) -> None:
    toy = toy_with_option
    toy.edit("pipelines/registry.py", '{"toy": toy}', '{"toy": toy, "again": toy}')
    toy.call("new-case", "two", "--seed", "data/raw/seed")
    text = (toy.root / "catalog/cases/two.yml").read_text()
    assert "# Pipelines that take these inputs, too: again" in text
    assert "#  factors: <file or folder>   # factors" in text
    toy.call("run", "--no-prefect", "--case", "two")

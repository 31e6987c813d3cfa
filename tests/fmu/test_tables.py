"""The tables of variables, and the model's structs that their names and units belong to."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import fields

import pytest

from fmu_src.interface.controller import controller_table
from fmu_src.interface.leader import leader_table
from fmu_src.interface.meaning import constants_of, variable_names, weights_of
from fmu_src.interface.plant import plant_table
from fmu_src.interface.platoon import platoon_table
from fmu_src.interface.variables import Variable
from fmu_src.native.tables import model_header
from psp_model import ObjectiveWeights, PlatoonParameters
from psp_model.quantities import quantity_of

TABLES = {
    "platoon": platoon_table(4),
    "controller": controller_table(4),
    "plant": plant_table(4),
    "wave": leader_table(),
    "profile": leader_table(True),
}


@pytest.mark.parametrize("table", TABLES.values(), ids=TABLES)
def test_names_are_unique_and_units_are_those_of_the_quantities(table: tuple[Variable, ...]) -> None:
    assert len({row.name for row in table}) == len(table)
    for row in table:
        with suppress(KeyError):  # what only FMUs have, such as `changes`
            assert row.unit == quantity_of(row.name).unit, row.name


@pytest.mark.parametrize("kind", [PlatoonParameters, ObjectiveWeights])
def test_every_field_of_a_struct_is_a_variable_with_its_default(kind: type) -> None:
    rows = {row.name: row for row in TABLES["platoon"]}
    names = variable_names(kind)
    assert list(names) == [field.name for field in fields(kind)]
    assert {field: rows[name].start for field, name in names.items()} == vars(kind())


def test_each_variable_goes_into_the_field_of_its_name() -> None:
    values = {row.name: row.start for row in TABLES["platoon"] if row.start is not None}
    for kind, make in ((PlatoonParameters, constants_of), (ObjectiveWeights, weights_of)):
        for field, name in variable_names(kind).items():
            changed = values | {name: values[name] * 1.01}
            expected = vars(kind()) | {field: values[name] * 1.01}
            assert vars(make(changed.__getitem__)) == expected


def test_the_header_of_the_native_fmu_lists_the_same_fields_and_units() -> None:
    header = model_header(TABLES["platoon"], 4, "{guid}", {}, "platoon_model.h")
    for kind, macro in ((PlatoonParameters, "CONSTANTS"), (ObjectiveWeights, "WEIGHTS")):
        listed = (
            header.split(f"#define PSP_{macro}_FIELDS(X) \\\n")[1].split("\n\n")[0].split("\n")[: len(fields(kind))]
        )
        expected = [f'X({field}, {name}, "{quantity_of(name).unit}")' for field, name in variable_names(kind).items()]
        assert [line.strip(" \\") for line in listed] == expected

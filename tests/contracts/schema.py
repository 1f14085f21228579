"""Holds docs/model.schema.json against the models and the failing models.

Every model that the engine reads obeys the schema; what the schema can see of the faults in tests/errors it sees.
Needs python3-jsonschema (4.0 or later, for draft 2020-12); without it the test counts as skipped (exit code 77).
"""

import json
import pathlib
import re
import sys

try:
    from jsonschema import Draft202012Validator
except ImportError:
    print("python3-jsonschema is not installed")
    sys.exit(77)

ROOT = pathlib.Path(sys.argv[1])
# Faults of form. The others are faults of meaning: unknown names, circles, numbers, files.
FORM = ("BG110", "BG111", "BG112", "BG113", "BG114", "BG115")
# What a schema cannot see though the code is one of form.
UNSEEN = {
    "BG114_kind_like_no_other.json": "kinds may be names of submodels",
    "BG114_unknown_kind.json": "kinds may be names of submodels",
    "BG113_condition_with_a_unit.json": "a text may be a condition",
}


def main():
    schema = json.loads((ROOT / "docs/model.schema.json").read_text())
    Draft202012Validator.check_schema(schema)
    validator = Draft202012Validator(schema)
    failures = []

    def sound(where, model):
        failures.extend(f"{where}: {error.json_path}: {error.message[:200]}" for error in validator.iter_errors(model))

    models = sorted(ROOT.glob("models/*.json"))
    for path in models:
        sound(path.name, json.loads(path.read_text()))
    examples = re.findall(r"```json[^\n]*\n(.*?)```", (ROOT / "docs/model-format.md").read_text(), re.S)
    for i, example in enumerate(examples):
        sound(f"example {i + 1} of docs/model-format.md", json.loads(example))

    seen = 0
    for path in sorted((ROOT / "tests/errors").glob("BG*.json")):
        try:
            model = json.loads(path.read_text())
        except json.JSONDecodeError:
            continue
        if not path.name.startswith(FORM):
            continue
        if validator.is_valid(model) and path.name not in UNSEEN:
            failures.append(f"{path.name} obeys the schema")
        seen += 1

    print(f"{len(models)} models, {len(examples)} examples, {seen} faults of form")
    print("\n".join(failures))
    return 1 if failures or not examples or not seen else 0


sys.exit(main())

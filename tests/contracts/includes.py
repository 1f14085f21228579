"""Every #include of the engine points at its own stage or at one before it (docs/design/house.md), and the command line
and the bench see public headers and their own only."""
import pathlib
import re
import sys

ORDER = ["base", "expression", "model", "graph", "read", "scene", "units", "equations", "program", "run", "linear", "study", "fit", "draw", "describe"]
ENDS = {"study", "fit", "draw", "describe"}  # nothing includes these, not even each other, but that fit stands on study
# The stage of each public header; its sources are in the folder of this name.
PUBLIC = {
    "base": "csv diagnostic id text unit xml",
    "expression": "expression",
    "model": "constitutive method model modes output_times",
    "graph": "bond_graph causality",
    "read": "input_file",
    "units": "infer_units",
    "equations": "equations ordering slice",
    "program": "evaluator program",
    "run": "simulate trace_csv verify",
    "linear": "linear structure transfer",
    "study": "indices reduce sensitivity study sweep trade",
    "fit": "fit",
    "draw": "drawing",
    "describe": "describe passivity",
}

root = pathlib.Path(sys.argv[1])
stage_of = {f"bgsim/{name}.hpp": stage for stage, names in PUBLIC.items() for name in names.split()}
sources = root / "engine" / "src"
faults = []


def includes(file):
    for number, line in enumerate(file.read_text().splitlines(), 1):
        if match := re.match(r'\s*#include "([^"]+)"', line):
            yield f"{file.relative_to(root)}:{number}", match[1]


def look(stage, file):
    for place, name in includes(file):
        other = stage_of.get(name) or name.split("/")[0]
        if other not in ORDER:
            faults.append(f"{place}: {name} belongs to no stage")
        elif ORDER.index(other) > ORDER.index(stage) or (other in ENDS and other != stage and (stage, other) != ("fit", "study")):
            faults.append(f"{place}: the stage {stage} includes {name} of {other}")


count = 0
for file in sorted(sources.rglob("*.[ch]pp")):
    look(file.relative_to(sources).parts[0], file)
    count += 1
for file in sorted((root / "engine" / "include" / "bgsim").glob("*.hpp")):
    if file.name == "bgsim.hpp":
        faults += [f"bgsim.hpp: {header} is missing" for header in stage_of if f'"{header}"' not in file.read_text()]
    elif f"bgsim/{file.name}" in stage_of:
        look(stage_of[f"bgsim/{file.name}"], file)
    else:
        faults.append(f"engine/include/bgsim/{file.name}: to which stage does it belong? Say so in {pathlib.Path(__file__).name}")
for folder in ("cli", "bench"):
    for file in sorted((root / folder).rglob("*.[ch]pp")):
        faults += [f"{place}: {name} is inside the engine" for place, name in includes(file)
                   if not name.startswith("bgsim/") and ((sources / name).exists() or "engine" in name)]
# Tests other than those of single stages go through Study and Simulation.
STAGES = re.compile(r"\b(build_bond_graph|assign_causality|derive_equations|order_equations|compile)\(")
for file in sorted((root / "tests").rglob("*.[ch]pp")):
    if file.relative_to(root / "tests").parts[0] in ("unit", "fuzz"):
        continue
    for number, line in enumerate(file.read_text().splitlines(), 1):
        if match := STAGES.search(line):
            faults.append(f"{file.relative_to(root)}:{number}: {match[1]} is called where Study would do")
assert count > 150, f"only {count} sources found"
print("\n".join(faults) or f"{count} sources of {len(ORDER)} stages")
sys.exit(bool(faults))

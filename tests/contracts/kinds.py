"""What is known of a kind of element is in its row of model/element_kinds.cpp. Elsewhere no kind is compared with another,
which would pass a new kind over in silence, each switch over kinds names all of them, and the documents know them."""
import pathlib
import re
import sys

root = pathlib.Path(sys.argv[1])
table = root / "engine" / "src" / "model" / "element_kinds.cpp"
faults = []
switches = 0
for folder in ("engine", "cli", "bench"):
    for file in sorted((root / folder).rglob("*.[ch]pp")):
        text = file.read_text()
        place = lambda match: f"{file.relative_to(root)}:{text.count(chr(10), 0, match.start()) + 1}"
        if file != table:
            faults += [f"{place(m)}: compares with a kind; ask for its row"
                       for m in re.finditer(r"[!=]= *(bgsim::)?ElementKind::", text)]
        for match in re.finditer(r"^( *)switch \(.*?^\1\}", text, re.M | re.S):
            if "case ElementKind::" not in match[0]:
                continue
            switches += 1
            if "default:" in match[0]:
                faults.append(f"{place(match)}: a switch over kinds with a default; name the kinds")
for kind in re.findall(r'\.text = "(\w+)"', table.read_text()):
    for name in ("model-format.md", "notation.md"):
        if not re.search(rf"`{kind}`|\b{kind}\b *[|,:]", (root / "docs" / name).read_text()):
            faults.append(f"docs/{name} does not say what {kind} is")
assert switches > 0, "no switch over kinds found"
print("\n".join(faults) or f"{switches} switches over kinds, no comparison with one")
sys.exit(bool(faults))

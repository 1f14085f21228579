"""No comparison of a test has the tolerance that Catch gives by default (1.2e-5 of the value, for no reason that belongs to the
number): each Approx says its own, or is one of support/approx.hpp, whose names say why."""
import pathlib
import re
import sys

root = pathlib.Path(sys.argv[1])
bare, seen = [], 0
for source in sorted((root / "tests").rglob("*.[ch]pp")):
    text = source.read_text()
    for found in re.finditer(r"\bApprox\(", text):
        depth, end = 1, found.end()
        while depth:
            depth += {"(": 1, ")": -1}.get(text[end], 0)
            end += 1
        seen += 1
        if not re.match(r"\s*\.(epsilon|margin)\(", text[end:]):
            bare.append(f"{source.relative_to(root)}:{text.count(chr(10), 0, found.start()) + 1}: {text[found.start():end]}")
assert seen > 100, f"only {seen} comparisons found: the search no longer fits the sources"
print("\n".join(bare) or f"{seen} comparisons")
sys.exit(bool(bare))

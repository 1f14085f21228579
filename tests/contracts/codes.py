"""The table of codes (engine/src/base/codes.cpp), docs/errors.md and the sources agree: each code has a row, a section of
the row's title and severity, and a place where it is used; a message that is only a warning is begun by its row."""
import pathlib
import re
import sys

root = pathlib.Path(sys.argv[1])
table = root / "engine" / "src" / "base" / "codes.cpp"
rows = {code: (severity == "kWarning", title) for code, severity, title in
        re.findall(r'Code\{"(BG\d{3})", (kError|kWarning),\s*"([^"]*)"\}', table.read_text())}
sections = {code: (bool(warning), title) for code, title, warning in
            re.findall(r"^## (BG\d{3}) (.*?)( \(warning\))?$", (root / "docs" / "errors.md").read_text(), re.M)}
faults = [f"{code}: the table says {rows.get(code)}, docs/errors.md {sections.get(code)}"
          for code in sorted(rows.keys() | sections.keys()) if rows.get(code) != sections.get(code)]
used = set()
for folder in ("engine", "cli"):
    for file in sorted((root / folder).rglob("*.[ch]pp")):
        if file == table:
            continue
        text = file.read_text()
        for match in re.finditer(r'"(BG\d{3})"', text):
            place = f"{file.relative_to(root)}:{text.count(chr(10), 0, match.start()) + 1}"
            used.add(match[1])
            if match[1] not in rows:
                faults.append(f"{place}: {match[1]} has no row")
            elif rows[match[1]][0] and re.search(r"\.code = $", text[:match.start()]):
                faults.append(f"{place}: {match[1]} is a warning; begin it with diagnostic_of")
faults += [f"{code}: no source uses it" for code in sorted(rows.keys() - used)]
assert len(rows) > 90, f"only {len(rows)} rows found"
print("\n".join(faults) or f"{len(rows)} codes")
sys.exit(bool(faults))

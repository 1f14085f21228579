"""Every test's name begins with a letter or a digit: ctest hands it to the test's program as an argument, where one that begins
with a hyphen is an option, with ~ an exclusion, and with [ a tag. None has a semicolon, where ctest would cut it: then no test
has that name, and what ran none has passed."""
import pathlib
import re
import sys

root = pathlib.Path(sys.argv[1])
sources = sorted((root / "tests").rglob("*.cpp"))
names = [(source, name) for source in sources for name in re.findall(r'^(?:SCENARIO|(?:TEMPLATE_)?TEST_CASE)\(\s*"((?:[^"\\]|\\.)*)"',
                                                                     source.read_text(), re.M)]
assert len(names) > 300, f"only {len(names)} names found: the search no longer fits the sources"
faulty = [f"{source.relative_to(root)}: {name}" for source, name in names if not re.match(r"[A-Za-z0-9][^;]*$", name)]
print("\n".join(faulty) or f"{len(names)} names")
sys.exit(bool(faulty))

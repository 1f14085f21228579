"""Runs a part of the tests of a program in one process: a start takes longer than most tests.

    part.py PROGRAM --part K/N [--without TAG]

Of the tests that PROGRAM lists, every N-th from the K-th on, so that neighbours, which take about as long, are in different parts. The last line
says how many passed and failed, which scripts/test counts. A test that was asked for and not run has failed: those that a crash leaves out, and names that the
program does not find."""
import argparse
import re
import subprocess
import sys
import tempfile

arguments = argparse.ArgumentParser()
arguments.add_argument("program")
arguments.add_argument("--part", required=True)
arguments.add_argument("--without", default="")
given = arguments.parse_args()
part, parts = map(int, given.part.split("/"))

listed = subprocess.run([given.program, "--list-test-names-only"] + ([f"~[{given.without}]"] if given.without else []),
                        stdout=subprocess.PIPE, text=True)
# Catch2 2.13 answers with the number of tests, at most 255.
names = sorted(filter(None, listed.stdout.splitlines()))
asked = names[part - 1::parts]
if not asked:
    sys.exit(f"{given.program} lists {len(names)} tests: none is left for part {part} of {parts}")
with tempfile.NamedTemporaryFile("w", suffix=".txt") as file:
    file.write("\n".join(re.sub(r"([\\,])", r"\\\1", name) for name in asked) + "\n")
    file.flush()
    run = subprocess.run([given.program, "--durations", "yes", "--input-file", file.name], stdout=subprocess.PIPE, text=True)
print(run.stdout, end="")

# "All tests passed (12 assertions in 3 test cases)", or "test cases: 3 | 2 passed | 1 failed".
passed = 0
if all_passed := re.search(r"^All tests passed \(\d+ assertions? in (\d+) test cases?\)$", run.stdout, re.M):
    passed = int(all_passed[1])
elif some := re.search(r"^test cases: .*?\| *(\d+) passed", run.stdout, re.M):
    passed = int(some[1])
if run.returncode < 0:
    print(f"{given.program} was ended by signal {-run.returncode}")
failed = len(asked) - passed
if run.returncode != 0 and failed == 0:
    print(f"{given.program} ended with {run.returncode} after its tests")
    failed, passed = 1, passed - 1
print(f"part: {passed} passed, {failed} failed")
sys.exit(failed != 0)

"""Follows a document as a reader would: writes the files it shows, types its commands, and compares their output
with what it shows.

    follow.py PROJECT BGSIM DOCUMENT            checks
    follow.py PROJECT BGSIM DOCUMENT --update   updates the document's pictures

A block ```json NAME is a file of that name. In a block ```console, a line "$ COMMAND" is typed, and the lines behind it
are found in its answer, in this order; "..." means any lines. It ends with 0, unless an error is among the lines
shown. In a block ```sh each line is typed, and so is the code of a table's cell that begins with scripts/. Every picture
that the document shows is a file of the reader's folder by then.

`bgsim` and `scripts/bgsim` are the command under test; models and the other scripts are the project's.
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile

PART = re.compile(r"^```(?P<kind>\w+)(?: (?P<name>[^\n]+))?\n(?P<body>.*?)^```$|^(?P<row>\|[^\n]*)$", re.S | re.M)
CELL = re.compile(r"`(scripts/[^`]+)`")
PICTURE = re.compile(r"!\[[^\]]*\]\(([^)]+)\)")


def missing_line(answer, expected):
    """The first expected line that is not found behind the one before it; None if all are."""
    lines = iter(line.rstrip() for line in answer.splitlines())
    for line in expected:
        if line.strip() == "...":
            continue
        if not any(line.rstrip() == each for each in lines):
            return line
    return None


def type_command(command, expected, folder, environment):
    done = subprocess.run(["bash", "-c", command], cwd=folder, env=environment, text=True, stdin=subprocess.DEVNULL,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False, timeout=300)
    if "this bgsim was built without Ceres and NLopt" in done.stdout:
        return []  # bgsim fit is optional
    if done.returncode != 0 and not any(": error " in line for line in expected):
        return [f"$ {command}\n  ends with {done.returncode}:\n{done.stdout}"]
    missing = missing_line(done.stdout, expected)
    if missing is None:
        return []
    return [f"$ {command}\n  does not answer (any more):\n    {missing}\n  but:\n" +
            "".join(f"    {line}\n" for line in done.stdout.splitlines())]


def typed(body):
    """The commands of a ```console block, each with the lines that are shown behind it."""
    commands = []
    for line in body.splitlines():
        if line.startswith("$ "):
            commands.append((line[2:].strip(), []))
        elif commands:
            commands[-1][1].append(line)
    return commands


def commands_of(part):
    if part["row"]:
        return [(command, []) for command in CELL.findall(part["row"])]
    if part["kind"] == "console":
        return typed(part["body"])
    if part["kind"] == "sh":
        return [(line, []) for line in part["body"].splitlines() if line]
    return []


def follow(text, folder, environment):
    faults = []
    commands = 0
    for part in PART.finditer(text):
        if part["kind"] == "json" and part["name"]:
            with open(os.path.join(folder, part["name"]), "w", encoding="utf-8") as file:
                file.write(part["body"])
        for command, expected in commands_of(part):
            faults += type_command(command, expected, folder, environment)
            commands += 1
    if commands == 0:
        faults.append("the document has no commands")
    return faults


def prepare(folder, project, bgsim):
    """The top folder of a clone, as far as a document's commands use it."""
    os.symlink(os.path.join(project, "models"), os.path.join(folder, "models"))
    os.mkdir(os.path.join(folder, "scripts"))
    for script in os.listdir(os.path.join(project, "scripts")):
        target = bgsim if script == "bgsim" else os.path.join(project, "scripts", script)
        os.symlink(target, os.path.join(folder, "scripts", script))


def main():
    project, bgsim, document = (os.path.abspath(path) for path in sys.argv[1:4])
    with open(document, encoding="utf-8") as file:
        text = file.read()
    with tempfile.TemporaryDirectory() as folder:
        prepare(folder, project, bgsim)
        path = os.path.dirname(bgsim) + os.pathsep + os.environ["PATH"]
        faults = follow(text, folder, dict(os.environ, PATH=path, BGSIM=bgsim))
        for picture in PICTURE.findall(text):
            made = os.path.join(folder, os.path.basename(picture))
            shown = os.path.join(os.path.dirname(document), picture)
            if not os.path.exists(made):
                faults.append(f"no command makes the picture {picture}")
            elif "--update" in sys.argv[4:]:
                os.makedirs(os.path.dirname(shown), exist_ok=True)
                shutil.copyfile(made, shown)
            elif not os.path.exists(shown):
                faults.append(f"{picture} is missing: make it with --update")
    print("\n".join(faults))
    sys.exit(1 if faults else 0)


main()

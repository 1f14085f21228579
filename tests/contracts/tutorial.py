"""Follows docs/tutorial.md as a reader would: writes the files it shows, types its commands, and holds what they answer
against what it says they answer.

    tutorial.py PROJECT BGSIM            checks
    tutorial.py PROJECT BGSIM --update   makes the pictures of docs/img/tutorial anew

In the tutorial, a block ```json NAME is a file of that name. In a block ```console, a line "$ COMMAND" is typed, and the
lines behind it are found in its answer, in this order; "..." stands for any lines. It ends with 0, unless an error is
among the lines shown. Pictures that it shows are files of
the reader's folder by then.
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile

BLOCK = re.compile(r"^```(\w+)(?: ([^\n]+))?\n(.*?)^```$", re.S | re.M)
PICTURE = re.compile(r"!\[[^\]]*\]\(img/tutorial/([^)]+)\)")


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
    if done.returncode != 0 and not any(": error " in line for line in expected):
        return [f"$ {command}\n  ends with {done.returncode}:\n{done.stdout}"]
    missing = missing_line(done.stdout, expected)
    if missing is None:
        return []
    return [f"$ {command}\n  does not answer (any more):\n    {missing}\n  but:\n" +
            "".join(f"    {line}\n" for line in done.stdout.splitlines())]


def follow(text, folder, environment):
    faults = []
    commands = 0
    for kind, name, body in BLOCK.findall(text):
        if kind == "json" and name:
            with open(os.path.join(folder, name), "w", encoding="utf-8") as file:
                file.write(body)
        if kind != "console":
            continue
        command, expected = None, []
        for line in body.splitlines() + ["$ "]:
            if not line.startswith("$ "):
                expected.append(line)
                continue
            if command:
                faults += type_command(command, expected, folder, environment)
                commands += 1
            command, expected = line[2:].strip(), []
    if commands == 0:
        faults.append("docs/tutorial.md has no commands")
    return faults


def main():
    project, bgsim = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2])
    with open(os.path.join(project, "docs", "tutorial.md"), encoding="utf-8") as file:
        text = file.read()
    with tempfile.TemporaryDirectory() as folder:
        os.symlink(os.path.join(project, "models"), os.path.join(folder, "models"))
        environment = dict(os.environ, PATH=os.path.dirname(bgsim) + os.pathsep + os.environ["PATH"])
        faults = follow(text, folder, environment)
        for picture in PICTURE.findall(text):
            made = os.path.join(folder, picture)
            shown = os.path.join(project, "docs", "img", "tutorial", picture)
            if not os.path.exists(made):
                faults.append(f"no command makes the picture {picture}")
            elif "--update" in sys.argv[3:]:
                os.makedirs(os.path.dirname(shown), exist_ok=True)
                shutil.copyfile(made, shown)
            elif not os.path.exists(shown):
                faults.append(f"docs/img/tutorial/{picture} is missing: make it with --update")
    print("\n".join(faults))
    sys.exit(1 if faults else 0)


main()

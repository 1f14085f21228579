#!/usr/bin/env python3
"""Shipped models, changed at random (mutations.py), through every command.

usage: mutate.py COMMAND SOURCE_DIR [--rounds N] [--seed S] [--jobs J] [--sanitized] [--keep FOLDER]

Each round changes one model and runs one command on it. Whatever the model: the command ends by itself within its limit of time, with
one of the exit codes 0 to 3; what it refuses has a code; no text of a defect or of a sanitizer appears; JSON, SVG and CSV can be read;
and a trace of a run without a message has no number that is not finite. 100,000 rounds under the sanitizers:
mutate.py build/asan/bgsim . --rounds 100000 --sanitized --jobs 3 (docs/design/fuzzing.md)."""
import argparse
import concurrent.futures
import glob
import json
import multiprocessing.util
import os
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
import xml.etree.ElementTree

import mutations

sys.setrecursionlimit(100_000)
FOLDERS = ["models", "tests/data/models", "tests/errors", "tests/cli/models"]
RUN_LIMIT = 1.0  # seconds of wall time that a run is given
METHODS = mutations.METHODS
STAGES = ["model", "graph", "units", "causality", "equations", "order", "program"]
DEFECT = re.compile(rb"a defect of bgsim|terminate called|AddressSanitizer|runtime error|LeakSanitizer|std::|bad_alloc|[Aa]ssertion|__gnu|basic_string|vector::|json\.exception")
LONGEST = 2_000_000  # of what is printed
NOT_FINITE = re.compile(rb"(?:^|,)-?(?:nan|inf)", re.M | re.I)


class Failed(Exception):
    pass


def seeds(source):
    """The files that are changed: [folder, name, tree or None, text]."""
    found = []
    for folder in FOLDERS:
        for path in sorted(glob.glob(os.path.join(source, folder, "*.json"))):
            text = open(path, encoding="utf-8", errors="replace").read()
            if len(text) > 40_000:
                continue
            try:
                tree = mutations.parse(text)
            except (ValueError, RecursionError):
                tree = None
            if isinstance(tree, mutations.Members) or tree is None:
                # Those of the shipped models that run say more than those that are refused.
                weight = 0.05 if folder == "tests/errors" else 1.0 if tree is not None and tree.get("scenes") else 0.3
                found.append((folder, os.path.basename(path), tree, text, weight))
    return found


class Server:
    """The command as a server of itself (fork_server/fork_server.cpp)."""

    def __init__(self, command, library):
        requests, answers = os.pipe(), os.pipe()

        def descriptors():
            os.dup2(requests[0], 198)
            os.dup2(answers[1], 199)

        options = os.environ.get("ASAN_OPTIONS", "") + ":verify_asan_link_order=0:detect_leaks=0"
        environment = {**os.environ, "LD_PRELOAD": library, "ASAN_OPTIONS": options}
        self.process = subprocess.Popen([command], env=environment, preexec_fn=descriptors, close_fds=False, stdin=subprocess.DEVNULL)
        os.close(requests[0])
        os.close(answers[1])
        self.requests, self.answers = os.fdopen(requests[1], "w"), os.fdopen(answers[0])

    def run(self, fields, interrupt):
        """The exit code, negative for a signal, as of subprocess."""
        self.requests.write("\x1f".join(fields) + "\n")
        self.requests.flush()
        child = int(self.answers.readline())
        timer = threading.Timer(interrupt, os.kill, (child, signal.SIGINT)) if interrupt else None
        if timer:
            timer.start()
        code = os.waitstatus_to_exitcode(int(self.answers.readline()))
        if timer:
            timer.cancel()
        return code


class Worker:
    """A copy of the models' folders, in which one file at a time is changed."""

    def __init__(self, command, source, sanitized, server, keep):
        self.command, self.sanitized, self.keep = os.path.abspath(command), sanitized, keep
        self.cpu = 60 if sanitized else 10
        self.server = Server(self.command, server) if server else None
        self.folder = tempfile.mkdtemp(prefix="bgsim-mutate-")
        for folder in FOLDERS:
            shutil.copytree(os.path.join(source, folder), os.path.join(self.folder, folder))
        self.seeds = seeds(source)
        self.trees = [seed[2] for seed in self.seeds if seed[2] is not None]

    def limits(self):
        resource.setrlimit(resource.RLIMIT_CPU, (self.cpu, self.cpu + 1))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        resource.setrlimit(resource.RLIMIT_FSIZE, (300_000_000, 300_000_000))
        if not self.sanitized:
            resource.setrlimit(resource.RLIMIT_AS, (4_000_000_000, 4_000_000_000))

    def code_of(self, arguments, interrupt):
        if self.server:
            return self.server.run([self.work, "out", "err", str(self.cpu), *arguments], interrupt)
        with open(os.path.join(self.work, "out"), "wb") as out, open(os.path.join(self.work, "err"), "wb") as err:
            process = subprocess.Popen([self.command, *arguments], cwd=self.work, stdin=subprocess.DEVNULL, stdout=out, stderr=err, preexec_fn=self.limits)
            try:
                return process.wait(timeout=interrupt)
            except subprocess.TimeoutExpired:
                process.send_signal(signal.SIGINT)
                return process.wait()

    def run(self, arguments, interrupt=None):
        code = self.code_of(arguments, interrupt)
        with open(os.path.join(self.work, "out"), "rb") as out, open(os.path.join(self.work, "err"), "rb") as err:
            out, err = out.read(), err.read()
        if code in (-signal.SIGXCPU, -signal.SIGKILL):
            raise Failed("does not end")
        if code not in (0, 1, 2, 3):
            raise Failed(f"exit code {code}: {err[-3000:].decode(errors='replace')}")
        found = DEFECT.search(err)
        if found:
            raise Failed(f"says {err[max(0, found.start() - 300):found.end() + 300].decode(errors='replace')}")
        if code in (1, 3) and b"BG" not in err and b"interrupted" not in err and b"missed" not in out and b"out of memory" not in err:
            raise Failed(f"exit code {code} without a code: {err[-500:].decode(errors='replace')}")
        for line in err.split(b"\n"):
            if re.search(rb"(?:^|:\d+: )(?:error|warning) (?!BG\d{3}: )", line):
                raise Failed(f"a message without a code: {line[:300].decode(errors='replace')}")
        if len(err) > LONGEST:
            raise Failed(f"{len(err)} bytes of messages")
        return code, out, err

    def traces(self, err):
        for path in glob.glob(os.path.join(self.work, "*.csv")):
            with open(path, "rb") as file:
                rows = file.read(5_000_000).split(b"\n", 1)[-1]
            if NOT_FINITE.search(rows) and b"not finite" not in err and b"finite" not in err:
                raise Failed(f"a trace has {NOT_FINITE.search(rows).group().decode()} without a message")

    def c_run(self, *options):
        code, _, err = self.run(["run", self.file, "--time-limit", str(RUN_LIMIT), "--report-json", "report.json", "-o", "trace.csv", *options])
        self.traces(err)
        report = os.path.join(self.work, "report.json")
        if os.path.exists(report):
            text = open(report, encoding="utf-8").read()
            json.loads(text, parse_constant=lambda constant: (_ for _ in ()).throw(Failed(f"the report has {constant}")))

    def c_all(self):
        self.c_run_plain("run", self.file, "--all-scenes", "--time-limit", "0.3", "--quiet")

    def c_run_plain(self, *arguments, interrupt=None):
        _, out, err = self.run(list(arguments), interrupt)
        self.traces(err)
        return out

    def c_method(self):
        self.c_run("--method", self.random.choice(METHODS), *self.random.choice([[], [], ["--step", "0.01"], ["--no-audit"], ["--relative", "1e-3"], ["--relative", "1e-11"]]))

    def c_record(self):
        self.c_run("--record", self.random.choice(["all", "states", "outputs"]), "--units", "--keep-all")

    def c_resume(self):
        self.c_run("--snapshot", "s.json", "--max-steps", "20")
        if os.path.exists(os.path.join(self.work, "s.json")):
            self.c_run("--resume", "s.json")

    def c_accuracy(self):
        self.c_run_plain("run", self.file, "--accuracy", "1e-3", "--time-limit", "0.3", "-o", "trace.csv", interrupt=3)

    def c_check(self):
        self.run(["check", self.file])

    def c_equations(self):
        self.run(["equations", self.file, *self.random.choice([[], ["--latex"]])])

    def c_show(self):
        self.run(["show", "--stage", self.random.choice(STAGES), self.file])

    def c_draw(self):
        _, out, _ = self.run(["draw", self.file, "-o", "-", *self.random.choice([[], ["--effort-flow"]])])
        if out:
            xml.etree.ElementTree.fromstring(out)

    def c_dot(self):
        self.run(["draw", self.file, "-o", "x.dot"])

    def c_verify(self):
        self.run(["verify", self.file, "--time-limit", "0.3"])

    def c_reduce(self):
        self.c_run_plain("reduce", self.file, "--error", "0.3", "-o", "r.json", "--json", "j.json", interrupt=3)

    def c_trade(self):
        self.c_run_plain("trade", self.file, "--budget", "0.05", "--no-picture", "-o", "x", interrupt=4)

    def c_report(self):
        self.run(["report", self.file, "--time-limit", "0.3", "-o", "x.html"])

    def c_completion(self):
        self.run(["completion", "scenes", self.file])

    COMMANDS = [("run", 30), ("method", 20), ("record", 5), ("all", 3), ("resume", 3), ("accuracy", 1), ("check", 8), ("equations", 4), ("show", 8), ("draw", 1), ("dot", 2), ("verify", 3),
                ("reduce", 2), ("trade", 1.5), ("report", 2), ("completion", 1)]

    def change(self, folder, name, tree, text):
        if tree is None or self.random.random() < 0.03:
            return mutations.damaged(self.random, text)
        mutator = mutations.Mutator(self.random, mutations.parse(text), self.trees, self.random.random() < 0.7)
        mutator.mutate()
        changed = mutations.written(mutator.tree).replace('"SELF"', json.dumps(name))
        return changed.encode("utf-8", "surrogatepass")

    def round(self, number):
        """What went wrong, or None."""
        self.random = random.Random(number)
        folder, name, tree, text, _ = self.random.choices(self.seeds, [seed[4] for seed in self.seeds])[0]
        path = os.path.join(self.folder, folder, name)
        changed = self.change(folder, name, tree, text)
        # A submodel is changed, and a model that uses it is run.
        users = [seed for seed in self.seeds if seed[0] == folder and seed[2] is not None and isinstance(seed[2].get("types"), mutations.Members)
                 and any(file == name for _, file in seed[2].get("types"))]
        self.file = os.path.join("..", folder, self.random.choice(users)[1] if users else name)
        self.work = os.path.join(self.folder, "work")
        shutil.rmtree(self.work, ignore_errors=True)
        os.mkdir(self.work)
        names, weights = zip(*self.COMMANDS)
        command = self.random.choices(names, weights)[0]
        with open(path, "wb") as file:
            file.write(changed)
        start = time.monotonic()
        try:
            getattr(self, "c_" + command)()
            return None
        except (Failed, ValueError, xml.etree.ElementTree.ParseError) as error:
            if self.keep:
                os.makedirs(self.keep, exist_ok=True)
                with open(os.path.join(self.keep, f"{number}.{command}.json"), "wb") as file:
                    file.write(changed)
            return f"seed {number}, {folder}/{name}, {command} of {self.file}, {time.monotonic() - start:.1f} s: {error}"
        finally:
            with open(path, "w", encoding="utf-8") as file:
                file.write(text)

    def end(self):
        shutil.rmtree(self.folder, ignore_errors=True)


worker = None


def begin(*given):
    global worker
    worker = Worker(*given)
    multiprocessing.util.Finalize(None, worker.end, exitpriority=0)


def one(number):
    return worker.round(number)


def main():
    # A shell that starts this in the background has SIGINT ignored, and so would the commands that are interrupted.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command")
    parser.add_argument("source")
    parser.add_argument("--rounds", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--sanitized", action="store_true", help="the command was built with the address sanitizer: no limit of memory, more time")
    parser.add_argument("--server", help="fork_server.so, with which a process for each round starts faster")
    parser.add_argument("--keep", help="a folder for the models of rounds that failed")
    given = parser.parse_args()
    failures = 0
    rounds = range(given.seed, given.seed + given.rounds)
    with concurrent.futures.ProcessPoolExecutor(given.jobs, initializer=begin, initargs=(given.command, given.source, given.sanitized, given.server, given.keep)) as pool:
        for number, fault in zip(rounds, pool.map(one, rounds, chunksize=8)):
            if number % 1000 == 0:
                print(f"... {number}", file=sys.stderr, flush=True)
            if fault is not None:
                failures += 1
                print(fault, flush=True)
    print(f"{given.rounds} rounds, {failures} failed")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())

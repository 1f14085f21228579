"""Models as text, for scenes with known answers."""
import json
import math

FAMILIES = []  # functions of a random generator that make a Scene


def family(function):
    FAMILIES.append(function)
    return function


class Scene:
    """A model with one scene, and the function that knows its answer.

    answer()  array of records by outputs, in the order in which the outputs were named; NaN where it is not judged
    """

    def __init__(self, stop, records=41, start=0.0, **keys):
        self.start, self.stop, self.records = start, stop, records
        self.model = {"bgsim": 1, "name": "oracle", "parameters": {}, "signals": {}, "elements": {}, "bonds": [],
                      "outputs": {}, "scenes": {"run": {"start": start, "stop": stop, "samples": records, **keys}}}
        self.files = {}  # others that the model names: name to text
        self.answer = None
        self.closed = False  # whether the answer is a closed form

    @property
    def times(self):
        return [self.start + (self.stop - self.start) * k / (self.records - 1) for k in range(self.records)]

    def element(self, name, kind, **keys):
        self.model["elements"][name] = {"kind": kind, **keys}
        return self

    def junctions(self, zeros="", ones=""):
        for kind, names in (("0", zeros), ("1", ones)):
            for name in names.split():
                self.element(name, kind)
        return self

    def bonds(self, text):
        for word in text.split():
            tail, head = word.split(">")
            self.model["bonds"].append({"from": tail, "to": head})
        return self

    def parameters(self, **values):
        self.model["parameters"].update(values)
        return self

    def signals(self, **values):
        self.model["signals"].update(values)
        return self

    def event(self, name, when, **values):
        self.model.setdefault("events", {})[name] = {"when": when, "set": values}
        return self

    def outputs(self, **values):
        self.model["outputs"].update(values)
        return self

    def only_signals(self):
        """A model needs an element: a source that works on nothing but a resistance."""
        return self.element("source", "Se", effort=1).element("load", "R", resistance=1).bonds("source>load")

    def known(self, row):
        """row(t): the outputs in closed form"""
        return self.computed(lambda: [row(t) for t in self.times])

    def computed(self, answer):
        """answer(): all rows, in closed form from event to event"""
        self.answer, self.closed = answer, True
        return self

    def solved(self, rates, start, row=lambda t, y: y, **keys):
        """row(t, y): the outputs, of a state y that integrated.solution(rates, start, ...) follows"""
        def answer():
            from integrated import solution  # needs SciPy
            return [row(t, y) for t, y in zip(self.times, solution(rates, start, self.times, **keys))]
        self.answer = answer
        return self

    def text(self):
        return json.dumps(self.model, indent=1, default=float)


def between(random, low, high):
    """A number whose logarithm is evenly distributed, with few digits."""
    return float(f"{math.exp(random.uniform(math.log(low), math.log(high))):.6g}")


def flat(random, low, high):
    """An evenly distributed number with few digits."""
    return float(f"{random.uniform(low, high):.6g}")


def one_of(random, *values):
    return values[int(random.integers(len(values)))]

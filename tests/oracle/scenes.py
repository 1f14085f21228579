"""Models as text, for scenes with known answers."""
import json
import math


class Scene:
    """A model with one scene, and the function that knows its answer.

    answer()  array of records by outputs, in the order in which the outputs were named
    """

    def __init__(self, stop, records=41, **keys):
        self.stop, self.records = stop, records
        self.model = {"bgsim": 1, "name": "oracle", "parameters": {}, "signals": {}, "elements": {}, "bonds": [],
                      "outputs": {}, "scenes": {"run": {"stop": stop, "samples": records, **keys}}}
        self.answer = None

    @property
    def times(self):
        return [self.stop * k / (self.records - 1) for k in range(self.records)]

    def element(self, name, kind, **keys):
        self.model["elements"][name] = {"kind": kind, **keys}
        return self

    def bonds(self, text):
        for word in text.split():
            tail, head = word.split(">")
            self.model["bonds"].append({"from": tail, "to": head})
        return self

    def signals(self, **values):
        self.model["signals"].update(values)
        return self

    def outputs(self, **values):
        self.model["outputs"].update(values)
        return self

    def text(self):
        return json.dumps(self.model, indent=1)


def between(random, low, high):
    """A number whose logarithm is evenly distributed, with few digits."""
    return float(f"{math.exp(random.uniform(math.log(low), math.log(high))):.6g}")

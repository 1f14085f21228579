"""Models changed at random, on their JSON tree and within their expressions. mutate.py runs them.

A tree holds its objects as lists of members, so that a key may occur twice, and its numbers as they are written, so that they may be
what JSON does not have (NaN, 1e400)."""
import json
import re


class Members(list):
    """A JSON object: [key, value] pairs in file order."""

    def get(self, key, otherwise=None):
        for name, value in self:
            if name == key:
                return value
        return otherwise

    def set(self, key, value):
        for member in self:
            if member[0] == key:
                member[1] = value
                return
        self.append([key, value])

    def drop(self, key):
        self[:] = [member for member in self if member[0] != key]


class Number(str):
    """A number as it is written."""


def parse(text):
    return json.loads(text, object_pairs_hook=lambda pairs: Members([list(pair) for pair in pairs]), parse_float=Number, parse_int=Number)


def written(tree):
    """The text of a tree. Without recursion, since trees may be nested deeply."""
    parts, stack = [], [tree]
    while stack:
        node = stack.pop()
        if isinstance(node, Raw):
            parts.append(node)
        elif isinstance(node, Members):
            items = [Raw("{")]
            for i, (key, value) in enumerate(node):
                items += [Raw((", " if i else "") + json.dumps(key) + ": "), value]
            stack.extend(reversed(items + [Raw("}")]))
        elif isinstance(node, list):
            items = [Raw("[")]
            for i, value in enumerate(node):
                items += [Raw(", "), value] if i else [value]
            stack.extend(reversed(items + [Raw("]")]))
        elif isinstance(node, Number):
            parts.append(node)
        else:
            parts.append(json.dumps(node))
    return "".join(parts)


class Raw(str):
    """Text between values."""


def copy(tree):
    return parse(json_safe(tree)) if isinstance(tree, (Members, list)) else tree


def json_safe(tree):
    text = written(tree)
    try:
        json.loads(text)
        return text
    except (ValueError, RecursionError):
        return "null"


NUMBERS = ["0", "-0", "1", "-1", "2", "0.5", "1e308", "-1e308", "1e-308", "-1e-308", "5e-324", "1e-320", "1e400", "1e-400", "1e15", "1e-15", "1e18", "1e30",
           "1e-30", "1e150", "1e-150", "9007199254740993", "9223372036854775808", "18446744073709551616", "4294967296", "2147483648", "-2147483649", "1" + "0" * 300,
           "0." + "0" * 300 + "1", "0.1", "3.141592653589793", "1e6", "1e-6", "1e9", "1e-9", "100", "1000", "7"]
NO_NUMBERS = ["NaN", "Infinity", "-Infinity", "nan", "inf", "1e", "0x10", "1_000", ".5", "+1", "01", "1,5", "--1", "1e5000000000"]
FUNCTIONS1 = ["abs", "sign", "sqrt", "cbrt", "exp", "log", "log10", "sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "asinh", "acosh", "atanh",
              "log1p", "expm1", "floor", "ceil", "round", "step", "der", "-", "not "]
FUNCTIONS2 = ["min", "max", "atan2", "hypot", "mod", "ssqrt"]
OPERATORS = ["+", "-", "*", "/", "^"]
COMPARISONS = ["<", "<=", ">", ">=", "==", "!="]
KINDS = ["Se", "MSe", "Sf", "MSf", "De", "Df", "R", "MR", "C", "MC", "I", "MI", "TF", "MTF", "GY", "MGY", "CC", "II", "RR", "0", "1", "Sw", "D"]
KEYS = {"Se": "effort", "Sf": "flow", "R": "resistance", "C": "capacitance", "I": "inertance", "TF": "modulus", "GY": "modulus"}
UNITS = ["1", "m", "mm", "kg", "s", "N", "N m", "Pa", "bar", "V", "A", "Ohm", "F", "H", "K", "J", "W", "m^3/s", "rad/s", "deg", "rpm", "%", "1e308 m", "m^1e9", "m^-1",
         "J/kg K", "furlong", "m^(1/3)", "1/s^2", "", "m^0", "(((m)))", "m/m", "0 m", "-1 m", "kkg", "\u00b5m", "m\u00b2"]
METHODS = ["auto", "bdf", "adams", "ida", "erk2", "erk3", "erk4", "erk5", "erk6", "erk8", "dirk2", "dirk3", "dirk4", "dirk5", "radau", "radau9", "radau13", "rodas5p", "euler", "rk4", "implicit_euler", "verlet"]
TOKEN = re.compile(r"\s+|[A-Za-z_][A-Za-z0-9_]*(?:\.[A-Za-z0-9_]+)*|(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?|<=|>=|==|!=|\"[^\"]*\"|'[^']*'|.", re.S)
EXPRESSION_KEYS = {"law", "energy", "effort", "flow", "resistance", "capacitance", "inertance", "modulus", "value", "integral", "initial", "stop", "start", "interval", "step"}
TEXT_KEYS = {"about", "source", "unit", "name", "kind", "from", "to", "file", "method", "$schema"}


class Mutator:
    """@param chance  a random.Random
    @param others  trees of other models, whose parts may be put into this one
    @param gentle  changes that leave most models in order, so that what comes after reading is reached"""

    def __init__(self, chance, tree, others, gentle):
        self.random, self.tree, self.others, self.gentle = chance, tree, others, gentle
        self.collect()

    own = []

    def collect(self):
        """All places of the tree, and the names in it. Without recursion."""
        self.places, self.expressions, self.numbers = [], [], []
        elements, self.parameters, self.signals = self.section("elements"), self.section("parameters"), self.section("signals")
        self.elements = [name for name, _ in elements]
        self.used = []
        stack = [(self.tree, None)]
        while stack:
            node, key = stack.pop()
            if not isinstance(node, list):
                continue
            for i, item in enumerate(node):
                own_key, value = item if isinstance(node, Members) else (key, item)
                place = (node, i)
                self.places.append(place)
                if isinstance(value, Number):
                    self.numbers.append(place)
                elif isinstance(value, str) and own_key not in TEXT_KEYS:
                    self.expressions.append(place)
                    self.used += re.findall(r"[A-Za-z_]\w*(?:\.\w+)+", value)
                elif isinstance(value, list):
                    stack.append((value, own_key))

    def section(self, name):
        found = self.tree.get(name) if isinstance(self.tree, Members) else None
        if not isinstance(found, Members):
            return Members()
        return Members(member for member in found if isinstance(member[0], str))

    def value(self, place):
        node, i = place
        return node[i][1] if isinstance(node, Members) else node[i]

    def put(self, place, value):
        node, i = place
        if isinstance(node, Members):
            node[i] = [node[i][0], value]
        else:
            node[i] = value

    # Expressions

    def name(self):
        if self.gentle:
            return self.random.choice(["t"] + self.own + [name for name, _ in self.parameters] + self.used[:50])
        names = ["t", "pi", "e", "f", "q", "p", "nothing"] + [name for name, _ in self.parameters + self.signals]
        names += [f"{element}.{variable}" for element in self.elements for variable in "efqp"]
        return self.random.choice(names)

    def number(self):
        return self.random.choice(NUMBERS) if self.random.random() < 0.8 else repr(self.random.choice([-1, 1]) * 10 ** self.random.uniform(-12, 12))

    def atom(self):
        return self.name() if self.random.random() < 0.6 else self.number()

    def spans(self, tokens):
        """Stretches of tokens with balanced parentheses: single operands, calls, what stands in parentheses."""
        spans, open_at = [], []
        for i, token in enumerate(tokens):
            if token == "(":
                open_at.append(i)
            elif token == ")" and open_at:
                first = open_at.pop()
                if first > 0 and re.match(r"[A-Za-z_]", tokens[first - 1]):
                    first -= 1
                spans.append((first, i + 1))
            elif re.match(r"[A-Za-z_0-9]", token) and (i + 1 == len(tokens) or tokens[i + 1] != "("):
                spans.append((i, i + 1))
        first = 2 if len(tokens) > 2 and tokens[1] == "=" else 0  # the right side of a law
        return spans + [(first, len(tokens))] if len(tokens) > first else spans

    def wrapped(self, inner):
        kind = self.random.random() * (0.92 if self.gentle else 1.0)
        if kind < 0.35:
            return f"{self.random.choice(FUNCTIONS1[:-3] if self.gentle else FUNCTIONS1)}({inner})"
        if kind < 0.5:
            return f"{self.random.choice(FUNCTIONS2)}({inner}, {self.atom()})"
        if kind < 0.65:
            return f"if({inner} {self.random.choice(COMPARISONS[:4] if self.gentle else COMPARISONS)} {self.atom()}, {self.atom()}, {inner})"
        if kind < 0.9:
            pair = [inner, self.atom()]
            self.random.shuffle(pair)
            return f"({pair[0]} {self.random.choice(OPERATORS)} {pair[1]})"
        if kind < 0.93:
            return f"if({inner} > {self.atom()} {self.random.choice(['and', 'or'])} {self.atom()} < {inner}, {inner}, {self.atom()})"
        if kind < 0.95:
            return f"table(\"x.csv\", \"y\", {inner})"
        if kind < 0.97:
            return "(" * 2000 + inner + ")" * 2000
        return f"({inner}) {self.random.choice(OPERATORS)} ({inner})"

    def expression(self, text):
        tokens = [token for token in TOKEN.findall(text) if not token.isspace()]
        own = [token for i, token in enumerate(tokens) if re.match(r"[A-Za-z_]", token) and tokens[i + 1:i + 2] != ["("]]
        self.own = own * 3  # names that may stand here are those that do
        spans = self.spans(tokens)
        for _ in range(self.random.choice([1, 1, 1, 2, 3])):
            kind = self.random.random() * (0.74 if self.gentle else 1.0)
            if kind < 0.35 and spans:
                first, last = self.random.choice(spans)
                tokens[first:last] = [self.wrapped(" ".join(tokens[first:last]))]
            elif kind < 0.55 and spans:
                first, last = self.random.choice(spans)
                tokens[first:last] = [self.atom()]
            elif kind < 0.75:
                at = [i for i, token in enumerate(tokens) if token in OPERATORS]
                if at:
                    tokens[self.random.choice(at)] = self.random.choice(OPERATORS)
            elif kind < 0.8 and tokens:
                del tokens[self.random.randrange(len(tokens))]
            elif kind < 0.85 and len(tokens) > 1:
                one, two = self.random.randrange(len(tokens)), self.random.randrange(len(tokens))
                tokens[one], tokens[two] = tokens[two], tokens[one]
            elif kind < 0.9 and spans:
                first, last = self.random.choice(spans)
                tokens[first:last] = tokens[first:last] * 2 if self.random.random() < 0.3 else ["("] + tokens[first:last] + [")"]
            elif kind < 0.97 and tokens:
                at = [i for i, token in enumerate(tokens) if re.match(r"[A-Za-z_]", token)]
                if at:
                    i = self.random.choice(at)
                    tokens[i] = self.random.choice(FUNCTIONS1 + FUNCTIONS2) if tokens[i + 1:i + 2] == ["("] else self.name()
            else:
                tokens.insert(self.random.randint(0, len(tokens)), self.random.choice(list("()+-*/^<>=,.\"'\\;\u03c0 ") + ["and", "0 =", "\u0000"]))
            spans = self.spans(tokens)
        return " ".join(tokens)

    # Places of the tree

    def change_number(self):
        if self.numbers:
            place = self.random.choice(self.numbers)
            kind = self.random.random()
            if kind < 0.06 and not self.gentle:
                self.put(place, Number(self.random.choice(NO_NUMBERS)))
            elif kind < 0.5:
                try:
                    self.put(place, Number(repr(float(self.value(place)) * self.random.choice([-1, 0.1, 10, 1e3, 1e-3, 1e6, 1e-6, 1e-12, 1e12, 1 + 1e-12]))))
                except ValueError:
                    pass
            else:
                self.put(place, Number(self.number()))

    def change_expression(self):
        if self.expressions:
            place = self.random.choice(self.expressions)
            self.put(place, self.expression(self.value(place)))
        self.modulate()

    def modulate(self):
        """Kinds that may use everything."""
        if self.gentle:
            for _, element in self.section("elements"):
                if isinstance(element, Members) and str(element.get("kind")) in KEYS:
                    element.set("kind", "M" + element.get("kind"))

    def number_to_expression(self):
        if self.numbers:
            place = self.random.choice(self.numbers)
            self.put(place, self.expression(self.value(place)))

    def change_type(self):
        place = self.random.choice(self.places)
        value = self.value(place)
        self.put(place, self.random.choice([None, True, False, "", "x", Number("0"), [], Members(), [value], Members([["value", value]]), Members([["value", value], ["unit", "m"]]),
                                            written(value)[:2000] if isinstance(value, list) else str(value)]))

    def delete(self):
        node, i = self.random.choice(self.places)
        del node[i]

    def duplicate(self):
        node, i = self.random.choice(self.places)
        if isinstance(node, Members):
            key = node[i][0] + self.random.choice(["", "2", "_b", ".x"])
            node.insert(self.random.randint(0, len(node)), [key, copy(node[i][1])])
        else:
            node.insert(self.random.randint(0, len(node)), copy(node[i]))

    def move(self):
        node, i = self.random.choice(self.places)
        to, _ = self.random.choice(self.places)
        item = node[i]
        if isinstance(node, Members) == isinstance(to, Members) and not self.holds(item, to):
            del node[i]
            to.insert(self.random.randint(0, len(to)), item)

    def holds(self, tree, wanted):
        stack = [tree]
        while stack:
            node = stack.pop()
            if node is wanted:
                return True
            if isinstance(node, list):
                stack.extend(item for item in node if isinstance(item, list))
        return False

    def rename_key(self):
        places = [place for place in self.places if isinstance(place[0], Members)]
        node, i = self.random.choice(places)
        keys = [place[0][place[1]][0] for place in places]
        node[i] = [self.random.choice(keys + ["x", "", "t", "e", "1", "a.b", "if", "\u00e9"]), node[i][1]]

    def rename_everywhere(self):
        names = self.elements + [name for name, _ in self.parameters + self.signals]
        if not names:
            return
        old = self.random.choice(names)
        new = self.random.choice(names + ["x", "t", "e", "q", "der", "mod", "a" * 5000, "b1", "Z9"])
        pattern = re.compile(r"(?<![A-Za-z0-9_])" + re.escape(old) + r"(?![A-Za-z0-9_])")
        for place in self.places:
            node, i = place
            value = self.value(place)
            if isinstance(value, str) and not isinstance(value, Number):
                self.put(place, pattern.sub(new, value))
            if isinstance(node, Members):
                node[i] = [pattern.sub(new, node[i][0]), node[i][1]]

    def swap(self):
        one, two = self.random.choice(self.places), self.random.choice(self.places)
        a, b = self.value(one), self.value(two)
        if not self.holds(a, two[0]) and not self.holds(b, one[0]):
            self.put(one, b)
            self.put(two, a)

    def shuffle(self):
        node, _ = self.random.choice(self.places)
        self.random.shuffle(node)

    def graft(self):
        """A part of another model."""
        other = self.random.choice(self.others)
        key = self.random.choice(["elements", "bonds", "parameters", "signals", "outputs", "scenes"])
        there, here = other.get(key), self.tree.get(key)
        if isinstance(there, list) and there and isinstance(here, list) and isinstance(here, Members) == isinstance(there, Members):
            for item in self.random.sample(list(there), min(len(there), self.random.randint(1, 3))):
                here.append(copy(item) if not isinstance(there, Members) else [item[0], copy(item[1])])

    def nest(self):
        place = self.random.choice(self.places)
        value = self.value(place)
        for _ in range(self.random.choice([1, 2, 20, 3000])):
            value = [value] if self.random.random() < 0.5 else Members([["a", value]])
        self.put(place, value)

    # What a model is made of

    def bonds(self):
        bonds = self.tree.get("bonds")
        return [bond for bond in bonds if isinstance(bond, Members)] if isinstance(bonds, list) and not isinstance(bonds, Members) else []

    def an_end(self):
        ends = [end for bond in self.bonds() for end in (bond.get("from"), bond.get("to")) if isinstance(end, str)]
        if self.gentle and ends:
            return self.random.choice(ends)
        name = self.random.choice(self.elements or ["x"])
        return name + self.random.choice(["", "", "", ".1", ".2", ".3", ".q", "." + self.random.choice(self.elements or ["x"])])

    def change_bond(self):
        bonds = self.bonds()
        if not bonds:
            return
        bond = self.random.choice(bonds)
        kind = self.random.random()
        if kind < 0.3:
            start, end = bond.get("from"), bond.get("to")
            bond.set("from", end)
            bond.set("to", start)
        elif kind < 0.6:
            bond.set(self.random.choice(["from", "to"]), self.an_end())
        elif kind < 0.7:
            bond.set("to", bond.get("from"))
        elif kind < 0.8:
            other = self.random.choice(bonds)
            one, two = bond.get("to"), other.get("to")
            bond.set("to", two)
            other.set("to", one)
        else:
            self.tree.get("bonds").append(Members([["from", self.an_end()], ["to", self.an_end()]]))

    def change_kind(self):
        elements = [member for member in self.section("elements") if isinstance(member[1], Members)]
        if not elements:
            return
        _, element = self.random.choice(elements)
        old, new = str(element.get("kind")), self.random.choice(KINDS)
        element.set("kind", new)
        if self.random.random() < 0.85:  # with the keys of its kind
            for member in element:
                if member[0] in KEYS.values() and new.removeprefix("M") in KEYS:
                    member[0] = KEYS[new.removeprefix("M")]
            if not any(member[0] in list(KEYS.values()) + ["law"] for member in element) and new.removeprefix("M") in KEYS:
                element.append([KEYS[new.removeprefix("M")], Number(self.number())])
            if new in ("0", "1", "De", "Df"):
                element[:] = [member for member in element if member[0] in ("kind", "about")]
        if old[:1] in "CI" and new not in ("C", "I", "MC", "MI"):
            element.drop("initial")

    def coefficient_to_law(self):
        elements = [member for member in self.section("elements") if isinstance(member[1], Members)]
        laws = [member for _, element in elements for member in element if member[0] in ("resistance", "capacitance", "inertance")]
        if laws:
            member = self.random.choice(laws)
            left, right = {"resistance": ("e", "f"), "capacitance": ("e", "q"), "inertance": ("f", "p")}[member[0]]
            if self.random.random() < 0.3 and member[0] == "resistance":
                left, right = right, left
            body = self.random.choice([f"{right}", f"({member[1]})*{right}", f"{right}*abs({right})", f"{right}^3", f"tanh({right})", f"sinh({right})", f"exp({right}) - 1", f"max({right}, 0)",
                                       f"if({right} > 0, {right}, 0.001*{right})", f"{right}^3 - {right}", f"ssqrt({right}, 1e-3)", f"sqrt({right})", f"1/{right}", f"log({right})", f"sign({right})"])
            member[0], member[1] = "law", f"{left} = {self.expression(body) if self.random.random() < 0.3 else body}"

    def new_element(self):
        elements = self.tree.get("elements")
        bonds = self.tree.get("bonds")
        if not isinstance(elements, Members) or not isinstance(bonds, list) or isinstance(bonds, Members) or not self.elements:
            return
        kind = self.random.choice(KINDS)
        value = Members([["kind", kind]])
        if kind.removeprefix("M") in KEYS:
            value.append([KEYS[kind.removeprefix("M")], Number(self.number()) if self.random.random() < 0.6 else self.expression(self.atom())])
        name = self.random.choice(["extra", "more", "extra"])
        elements.append([name, value])
        for _ in range(2 if kind in ("TF", "GY", "MTF", "MGY", "0", "1") else 1):
            ends = [name, self.an_end()]
            self.random.shuffle(ends)
            bonds.append(Members([["from", ends[0]], ["to", ends[1]]]))

    def change_unit(self):
        units = [place for place in self.places if isinstance(place[0], Members) and place[0][place[1]][0] == "unit"]
        if units:
            self.put(self.random.choice(units), self.random.choice(UNITS))

    def change_scene(self):
        scenes = [value for _, value in self.section("scenes") if isinstance(value, Members)]
        if not scenes:
            return
        scene = self.random.choice(scenes)
        key = self.random.choice(["stop", "start", "samples", "interval", "times", "relative", "absolute", "method", "step", "max_order", "initial", "parameters", "outputs", "reference"])
        states = [f"{element}.{variable}" for element in self.elements for variable in "qpef"]
        value = {
            "method": lambda: self.random.choice(METHODS),
            "times": lambda: [Number(self.number()) for _ in range(self.random.randint(0, 4))],
            "initial": lambda: Members([[self.random.choice(states or ["x.q"]), Number(self.number())]]),
            "absolute": lambda: self.random.choice([Number(self.number()), Members([[self.random.choice(states or ["x.q"]), Number(self.number())]])]),
            "parameters": lambda: Members([[self.random.choice([name for name, _ in self.parameters] or ["x"]), self.random.choice([Number(self.number()), self.expression("1")])]]),
            "outputs": lambda: [self.random.choice([name for name, _ in self.section("outputs")] or ["x"]) for _ in range(self.random.randint(0, 3))],
            "reference": lambda: self.random.choice([Members([["file", self.random.choice(["x.csv", "reference/lever.csv", "..", "/dev/null", ""])]]), "x.csv"]),
            "max_order": lambda: Number(self.random.choice(["0", "1", "2", "5", "12", "13", "-1"])),
            "samples": lambda: Number(self.random.choice(["0", "1", "2", "3", "11", "-1", "1e9", "2.5", "100001"])),
        }.get(key, lambda: self.random.choice([Number(self.number()), Number(self.number()), self.expression(self.atom())]))()
        scene.set(key, value)
        if key == "times":
            scene.drop("samples")
            scene.drop("interval")

    def change_type_file(self):
        types = self.tree.get("types")
        if isinstance(types, Members) and types:
            self.random.choice(types)[1] = self.random.choice(["SELF", "x.json", ".", "/dev/zero", "", "../models/rlc.json", "rlc.json"])
        else:
            self.tree.set("types", Members([["part", "SELF"]]))
            self.tree.set("elements", Members((self.tree.get("elements") if isinstance(self.tree.get("elements"), Members) else []) + [["inner", Members([["kind", "part"]])]]))

    def refer_to_itself(self):
        sections = [section for section in (self.parameters, self.signals) if section]
        if sections:
            one = self.random.choice(self.random.choice(sections))
            two = self.random.choice(self.random.choice(sections))
            one_value = f"{two[0]} + 1" if self.random.random() < 0.5 else f"if(t > 1, {one[0]}, 0)"
            for section in ("parameters", "signals"):
                found = self.tree.get(section)
                if isinstance(found, Members):
                    for member in found:
                        if member[0] == one[0]:
                            member[1] = one_value

    def integral(self):
        signals = self.tree.get("signals")
        if not isinstance(signals, Members):
            signals = Members()
            self.tree.set("signals", signals)
        signals.append(["sum", Members([["integral", self.expression(self.atom())]] + ([["initial", Number(self.number())]] if self.random.random() < 0.5 else []))])

    def new_output(self):
        outputs = self.tree.get("outputs")
        if isinstance(outputs, Members):
            outputs.append([self.random.choice(["extra", "y", "t", "x"]), self.expression(self.wrapped(self.atom()))])

    OPERATIONS = [("change_number", 5), ("change_expression", 8), ("number_to_expression", 2), ("change_type", 2), ("delete", 2), ("duplicate", 2), ("move", 1), ("rename_key", 1),
                  ("rename_everywhere", 1), ("swap", 1), ("shuffle", 0.5), ("graft", 1), ("nest", 0.3), ("change_bond", 3), ("change_kind", 3), ("coefficient_to_law", 4), ("new_element", 2),
                  ("change_unit", 1), ("change_scene", 3), ("change_type_file", 0.3), ("refer_to_itself", 0.3), ("integral", 1), ("new_output", 1)]

    GENTLE = [("change_number", 5), ("change_expression", 8), ("number_to_expression", 2), ("change_bond", 2), ("change_kind", 2), ("coefficient_to_law", 4), ("new_element", 1),
              ("change_scene", 2), ("integral", 1), ("new_output", 1), ("shuffle", 0.5)]

    def mutate(self):
        names, weights = zip(*(self.GENTLE if self.gentle else self.OPERATIONS))
        for _ in range(self.random.choice([1, 1, 1, 1, 2, 2, 3, 5])):
            if not isinstance(self.tree, Members) or not self.places:
                return
            getattr(self, self.random.choices(names, weights)[0])()
            self.collect()


def damaged(chance, text):
    """A change below the tree: bytes dropped, repeated, replaced."""
    data = bytearray(text.encode("utf-8", "surrogatepass"))
    for _ in range(chance.choice([1, 1, 2, 5])):
        first = chance.randrange(len(data) + 1)
        last = min(len(data), first + chance.choice([1, 1, 2, 10, 200]))
        data[first:last] = chance.choice([b"", data[first:last] * 2, bytes([chance.randrange(256)]), b'"', b"\\u0000", b"\\ud800", b"\xff", b"{", b"]"])
    return bytes(data)

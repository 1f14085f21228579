#!/usr/bin/env python3
"""Derives the tables of engine/src/run/integrate/radau_tables.hpp: Radau IIA with five and seven stages.

    tools/radau/tables.py | clang-format     prints the tables
    tools/radau/tables.py 3                  those of three stages, to compare with radau_formula.hpp

Nodes are the zeros of d^(s-1)/dx^(s-1) x^(s-1) (x - 1)^s, coefficients follow from C(s), eigenvalues of their inverse are the zeros of the
denominator of the (s - 1, s) Pade approximation of exp (Hairer, Wanner, Solving Ordinary Differential Equations II, 1996, IV.3, IV.5). All in
decimals of 80 digits, of which the tables keep 20.
"""
import sys
from decimal import Decimal, getcontext
from math import comb, factorial

getcontext().prec = 80


class Complex:
    def __init__(self, re, im=0):
        self.re, self.im = Decimal(re), Decimal(im)

    def __add__(self, o):
        return Complex(self.re + o.re, self.im + o.im)

    def __sub__(self, o):
        return Complex(self.re - o.re, self.im - o.im)

    def __mul__(self, o):
        return Complex(self.re * o.re - self.im * o.im, self.re * o.im + self.im * o.re)

    def __truediv__(self, o):
        size = o.re * o.re + o.im * o.im
        return Complex((self.re * o.re + self.im * o.im) / size, (self.im * o.re - self.re * o.im) / size)

    def __abs__(self):
        return (self.re * self.re + self.im * self.im).sqrt()


def value(polynomial, x):
    """By coefficients from the constant on."""
    result = polynomial[-1]
    for coefficient in reversed(polynomial[:-1]):
        result = result * x + coefficient
    return result


def derivative(polynomial):
    return [k * polynomial[k] for k in range(1, len(polynomial))]


def integral(polynomial):
    return [Decimal(0)] + [c / (k + 1) for k, c in enumerate(polynomial)]


def product(factors):
    result = [Decimal(1)]
    for root in factors:
        result = [(result[k - 1] if k else 0) - root * (result[k] if k < len(result) else 0) for k in range(len(result) + 1)]
    return result


def root_between(function, low, high):
    rising = function(high) > 0
    for _ in range(270):
        middle = (low + high) / 2
        if (function(middle) > 0) == rising:
            high = middle
        else:
            low = middle
    return (low + high) / 2


def roots_on(function, low, high, parts=2000):
    grid = [low + (high - low) * k / parts for k in range(parts + 1)]
    return [root_between(function, a, b) for a, b in zip(grid, grid[1:]) if function(a) * function(b) < 0]


def solve(matrix, right):
    """Gauss with pivoting; right: a list of columns."""
    n = len(matrix)
    rows = [list(matrix[i]) + [column[i] for column in right] for i in range(n)]
    for k in range(n):
        best = max(range(k, n), key=lambda i: abs(rows[i][k]))
        rows[k], rows[best] = rows[best], rows[k]
        for i in range(n):
            if i != k:
                factor = rows[i][k] / rows[k][k]
                rows[i] = [a - factor * b for a, b in zip(rows[i], rows[k])]
    return [[rows[i][n + j] / rows[i][i] for i in range(n)] for j in range(len(right))]


def transposed(matrix):
    return [list(row) for row in zip(*matrix)]


def inverse(matrix):
    n = len(matrix)
    return transposed(solve(matrix, [[Decimal(int(i == j)) for i in range(n)] for j in range(n)]))


def nodes(s):
    polynomial = [Decimal(0)] * (s - 1) + [Decimal(comb(s, k) * (-1) ** (s - k)) for k in range(s + 1)]
    for _ in range(s - 1):
        polynomial = derivative(polynomial)
    return roots_on(lambda x: value(polynomial, x), Decimal(0), Decimal("0.9999")) + [Decimal(1)]


def eigenvalues(s):
    """The real one, then those of the pairs above the real axis, the least imaginary part first. By Durand and Kerner."""
    q = [Decimal((-1) ** j * factorial(2 * s - 1 - j) * factorial(s)) / (factorial(2 * s - 1) * factorial(j) * factorial(s - j)) for j in range(s + 1)]
    q = [Complex(c / q[-1]) for c in q]
    start, roots = Complex("0.4", "0.9"), [Complex(s)]
    while len(roots) < s:
        roots.append(roots[-1] * start)
    for _ in range(400):
        for i in range(s):
            below = Complex(1)
            for j in range(s):
                if j != i:
                    below = below * (roots[i] - roots[j])
            roots[i] = roots[i] - value(q, roots[i]) / below
    real = [r.re for r in roots if abs(r.im) < Decimal("1e-60")]
    pairs = sorted(((r.re, r.im) for r in roots if r.im > Decimal("1e-60")), key=lambda r: r[1])
    assert len(real) == 1 and len(pairs) == s // 2
    return real[0], pairs


def eigenvector(matrix, value_):
    """Its last component is 1."""
    n = len(matrix) - 1
    left = [[Complex(matrix[i][j]) - (value_ if i == j else Complex(0)) for j in range(n)] for i in range(n)]
    return solve(left, [[Complex(-matrix[i][n]) for i in range(n)]])[0] + [Complex(1)]


def tables(s):
    c = nodes(s)
    a = [solve([[x ** k for x in c] for k in range(s)], [[x ** (k + 1) / (k + 1) for k in range(s)]])[0] for x in c]
    back = inverse(a)
    gamma, pairs = eigenvalues(s)
    real = [v.re for v in eigenvector(back, Complex(gamma))]
    length = sum(x * x for x in real).sqrt()
    columns = [[x / length for x in real]]
    for re, im in pairs:
        v = eigenvector(back, Complex(re, im))
        columns += [[x.re for x in v], [-x.im for x in v]]
    transform = transposed(columns)
    # gamma times the distance of the embedded formula, which is exact for rates of degree s - 1 and has 1/gamma for the rates at the beginning,
    # from the step's end is h f + sum e z: with z = c^(k+1)/(k+1), k from 0, that is to be 0, but for the 1 of k = 0.
    e = solve([[x ** (k + 1) / (k + 1) for x in c] for k in range(s)], [[Decimal(-1 if k == 0 else 0) for k in range(s)]])[0]
    slope = product(c)
    bubble = integral(slope)
    zeros = roots_on(lambda u: value(bubble, u), Decimal("0.01"), Decimal("0.99"))
    assert len(zeros) == s - 2
    # Of the points that need no other matrix the one nearest to the middle.
    corrected = min(roots_on(lambda u: value(slope, u) - gamma * value(bubble, u), Decimal("0.001"), Decimal("0.999")),
                    key=lambda u: abs(u - Decimal("0.5")))
    largest = max(abs(value(bubble, u)) for u in c)
    basis = [product([0] + [x for x in c if x != node]) for node in c]
    size = [value(b, node) for b, node in zip(basis, c)]
    return {"at": c, "inverse": back, "gamma": gamma, "pairs": pairs, "transform": transform, "back": inverse(transform), "error": e,
            "bubble_zeros": zeros, "largest_bubble": largest, "corrected_at": corrected,
            "value": [value(b, corrected) / x for b, x in zip(basis, size)],
            "slope": [value(derivative(b), corrected) / x for b, x in zip(basis, size)]}


def digits(x):
    return f"{x:.20e}" if x else "0.0"


def initializer(x):
    """As C++ has it; clang-format breaks the lines."""
    if not isinstance(x, (list, tuple)):
        return digits(x)
    inner = ", ".join(map(initializer, x))
    return "{{" + inner + "}}" if isinstance(x[0], (list, tuple)) else "{" + inner + "}"


def print_tables(s):
    print("template <>")
    print(f"inline constexpr RadauTable<{s}> kTable<{s}> = {{")
    print(",\n".join(f"    .{name} = {initializer(x)}" for name, x in tables(s).items()) + "};\n")


if __name__ == "__main__":
    for stages in [int(word) for word in sys.argv[1:]] or [5, 7]:
        print_tables(stages)

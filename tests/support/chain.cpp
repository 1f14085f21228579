#include "support/chain.hpp"

#include <algorithm>
#include <cmath>

#include "bgsim/bgsim.hpp"

namespace bgsim::test {

namespace {

constexpr int kRows = 31;
constexpr double kStop = 3.0;

std::string number(double value) { return number_text(value, 17); }

std::string keys(const Chain::Link& link, const std::string& direction) {
  switch (link.kind) {
    case Chain::Kind::spring:
      return R"("kind": "C", "law": "e = )" + number(link.value) + "*q + " + number(link.second) + R"(*q^3")";
    case Chain::Kind::friction:
      return R"("kind": "R", "law": "e = )" + number(link.value) + "*(" + direction + ")\"";
    case Chain::Kind::diode:
      return R"("kind": "D", "passes": "out")";
    case Chain::Kind::contact:
      return R"("kind": "contact", "initial": { "q": 0 }, "gap": )" + number(link.value) + R"(, "restitution": )" +
             number(link.second);
  }
  return {};
}

}  // namespace

double Chain::Link::ground(double t) const { return ground_speed * std::sin(ground_frequency * t); }

double Chain::force(std::size_t mass, double t) const {
  return forces[mass] + amplitudes[mass] * std::sin(frequencies[mass] * t);
}

std::string Chain::text() const {
  std::string elements, bonds, outputs;
  const auto bond = [&bonds](const std::string& from, const std::string& to) {
    bonds += std::string(bonds.empty() ? "" : ", ") + R"({ "from": ")" + from + R"(", "to": ")" + to + R"(" })";
  };
  const auto element = [&elements](const std::string& name, const std::string& of) {
    elements += std::string(elements.empty() ? "\"" : ", \"") + name + R"(": { )" + of + " }";
  };
  for (std::size_t i = 0; i < masses.size(); ++i) {
    const std::string n = "n" + std::to_string(i), m = "m" + std::to_string(i), F = "F" + std::to_string(i);
    element(n, R"("kind": "1")");
    element(m, R"("kind": "I", "inertance": )" + number(masses[i]));
    const std::string sine = number(amplitudes[i]) + "*sin(" + number(frequencies[i]) + "*t)";
    element(F, R"("kind": "Se", "effort": ")" + number(forces[i]) + " + " + sine + "\"");
    bond(n, m);
    bond(F, n);
    outputs += std::string(outputs.empty() ? "\"v" : ", \"v") + std::to_string(i) + R"(": ")" + n + R"(.f")";
  }
  for (std::size_t k = 0; k < links.size(); ++k) {
    const Link& link = links[k];
    const std::string name = "e" + std::to_string(k), n = "n" + std::to_string(link.from);
    element(name, keys(link, direction));
    if (link.to < 0 && link.ground_speed == 0.0) {
      bond(n, name);
      continue;
    }
    const std::string h = "h" + std::to_string(k);
    element(h, R"("kind": "0")");
    bond(n, h);
    if (link.to < 0) {
      const std::string g = "g" + std::to_string(k);
      const std::string speed = number(-link.ground_speed) + "*sin(" + number(link.ground_frequency) + "*t)";
      element(g, R"("kind": "Sf", "flow": ")" + speed + "\"");
      bond(g, h);
    } else {
      bond(h, "n" + std::to_string(link.to));
    }
    bond(h, name);
  }
  return R"({ "bgsim": 1, "name": "chain", "elements": { )" + elements + R"( }, "bonds": [ )" + bonds +
         R"( ], "outputs": { )" + outputs + R"( }, "scenes": { "main": { "stop": )" + number(kStop) +
         R"(, "samples": )" + std::to_string(kRows) + " } } }";
}

std::vector<std::vector<double>> Chain::stepped(double step) const {
  constexpr int kSweeps = 2000;
  constexpr double kTouching = 1e-12;  // of what friction holds at its gap, where sums of speeds are rounding
  const auto in_a_row = static_cast<int>(std::lround(kStop / (kRows - 1) / step));
  std::vector<double> v(masses.size(), 0.0), stretch(links.size(), 0.0), before(links.size()), impulse(links.size());
  std::vector<std::vector<double>> rows{v};
  double t = 0.0;
  const auto at = [](int mass) { return static_cast<std::size_t>(mass); };
  const auto speed = [&](const Link& link) {
    return v[at(link.from)] - (link.to < 0 ? link.ground(t) : v[at(link.to)]);
  };
  const auto push = [&](const Link& link, double by) {
    v[at(link.from)] -= by / masses[at(link.from)];
    if (link.to >= 0) v[at(link.to)] += by / masses[at(link.to)];
  };
  // The impulse by which the link comes to what its law asks for, where the others are as they are.
  const auto next = [&](std::size_t k) {
    const Link& link = links[k];
    const double of_ground = link.to < 0 ? 0.0 : 1.0 / masses[at(link.to)];
    const double inverse = 1.0 / masses[at(link.from)] + of_ground;
    const double stops = impulse[k] + speed(link) / inverse;
    if (link.kind == Kind::friction) return std::clamp(stops, -step * link.value, step * link.value);
    if (link.kind == Kind::diode) return std::max(0.0, stops);
    if (stretch[k] < link.value - kTouching) return 0.0;  // a contact that is open
    return std::max(0.0, stops + link.second * std::max(0.0, before[k]) / inverse);
  };
  for (int count = 0; count < in_a_row * (kRows - 1); ++count) {
    for (std::size_t k = 0; k < links.size(); ++k) before[k] = speed(links[k]);
    // Contacts are looked at in the middle of the step.
    for (std::size_t k = 0; k < links.size(); ++k) stretch[k] += 0.5 * step * before[k];
    t = step * (count + 0.5);
    for (std::size_t i = 0; i < v.size(); ++i) v[i] += step * force(i, t) / masses[i];
    for (std::size_t k = 0; k < links.size(); ++k)
      if (const double q = stretch[k]; links[k].kind == Kind::spring)
        push(links[k], step * (links[k].value * q + links[k].second * q * q * q));
    t = step * (count + 1);
    std::fill(impulse.begin(), impulse.end(), 0.0);
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
      double most = 0.0;
      for (std::size_t k = 0; k < links.size(); ++k) {
        if (links[k].kind == Kind::spring) continue;
        const double change = next(k) - impulse[k];
        push(links[k], change);
        most = std::max(most, std::abs(change));
        impulse[k] += change;
      }
      if (most < 1e-14) break;
    }
    for (std::size_t k = 0; k < links.size(); ++k) stretch[k] += 0.5 * step * speed(links[k]);
    if ((count + 1) % in_a_row == 0) rows.push_back(v);
  }
  return rows;
}

Chain random_chain(std::mt19937& random, bool contacts) {
  const auto between = [&random](double a, double b) { return std::uniform_real_distribution<double>(a, b)(random); };
  const auto below = [&random](int n) { return std::uniform_int_distribution<int>(0, n - 1)(random); };
  Chain chain;
  const int count = 2 + below(3);
  for (int i = 0; i < count; ++i) {
    chain.masses.push_back(between(0.5, 3.0));
    chain.forces.push_back(below(2) == 0 ? between(-2.0, 2.0) : 0.0);
    chain.amplitudes.push_back(below(3) > 0 ? between(1.0, 6.0) : 0.0);
    chain.frequencies.push_back(between(1.0, 8.0));
  }
  const auto link = [&](int from, int to) {
    using Kind = Chain::Kind;
    const Kind of[] = {Kind::spring, Kind::friction, Kind::friction, Kind::diode,
                       Kind::diode,  Kind::contact,  Kind::contact};
    Chain::Link made{of[below(contacts ? 7 : 5)], from, to, between(0.3, 3.0)};
    if (made.kind == Kind::spring) made.value = between(5.0, 60.0);
    if (made.kind == Kind::spring && below(2) == 0) made.second = between(0.0, 400.0);
    if (made.kind == Kind::contact) made.value = below(2) == 0 ? 0.0 : between(0.0, 0.2);
    if (made.kind == Kind::contact && below(2) == 0) made.second = 0.5;
    if (to < 0 && below(4) == 0) {
      made.ground_speed = between(0.1, 1.0);
      made.ground_frequency = between(1.0, 8.0);
    }
    chain.links.push_back(made);
  };
  for (int i = 0; i < count; ++i) link(i, -1);
  for (int i = 0; i + 1 < count; ++i) link(i, i + 1);
  if (below(2) == 0) link(0, 1);
  return chain;
}

}  // namespace bgsim::test

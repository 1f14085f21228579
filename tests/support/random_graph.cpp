#include "support/random_graph.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <random>

namespace bgsim::test {

namespace {

/// Distributions of the standard library differ between implementations; these do not.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : engine_(seed * 0x9E3779B97F4A7C15U + 1) {}

  double unit() { return static_cast<double>(engine_() >> 11U) * 0x1.0p-53; }
  /// 0 ... count - 1.
  std::size_t below(std::size_t count) { return static_cast<std::size_t>(unit() * static_cast<double>(count)); }
  bool chance(double probability) { return unit() < probability; }
  /// Between 1/3 and 3, evenly by ratio: poles stay within a few decades of each other.
  double moderate() { return std::pow(3.0, 2.0 * unit() - 1.0); }

  template <class T>
  void shuffle(std::vector<T>& items) {
    for (std::size_t i = items.size(); i > 1; --i) std::swap(items[i - 1], items[below(i)]);
  }

 private:
  std::mt19937_64 engine_;
};

std::string number(double value) {
  std::array<char, 32> buffer{};
  return {buffer.data(), std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr};
}

class Generator {
 public:
  Generator(std::uint64_t seed, const RandomGraphOptions& options) : dice_(seed), options_(options) {}

  RandomGraph graph() {
    const std::size_t junctions = 1 + dice_.below(options_.most_junctions);
    for (std::size_t i = 0; i < junctions; ++i) {
      const std::string junction = add(dice_.chance(0.5) ? "0" : "1", 0.0);
      if (i > 0) connect(junctions_[dice_.below(i)], junction);
      junctions_.push_back(junction);
    }
    const std::size_t rings = junctions < 2 ? 0 : dice_.below(options_.most_rings + 1);
    for (std::size_t i = 0; i < rings; ++i) {
      const std::size_t one = dice_.below(junctions);
      const std::size_t two = (one + 1 + dice_.below(junctions - 1)) % junctions;
      connect(junctions_[one], junctions_[two]);
    }
    for (std::size_t i = 0; i < junctions; ++i) add_one_ports(junctions_[i], junctions == 1);
    return std::move(result_);
  }

 private:
  std::string add(const std::string& kind, double value) {
    std::string name = (kind == "0" || kind == "1" ? "j" + kind : kind) + "_" + std::to_string(result_.elements.size());
    result_.elements.push_back({name, kind, value});
    return name;
  }
  void bond(const std::string& one, const std::string& two) {
    if (dice_.chance(0.5))
      result_.bonds.emplace_back(one, two);
    else
      result_.bonds.emplace_back(two, one);
  }
  void connect(const std::string& one, const std::string& two) {
    if (dice_.chance(1.0 - options_.two_ports)) return bond(one, two);
    const std::string two_port = add(dice_.chance(0.5) ? "TF" : "GY", modulus());
    bond(one, two_port + ".1");
    bond(two_port + ".2", two);
  }
  double modulus() {
    if (!options_.simple_moduli) return dice_.moderate();
    static constexpr std::array<double, 6> kSimple{0.5, 1.0, 2.0, -0.5, -1.0, -2.0};
    return kSimple[dice_.below(kSimple.size())];
  }
  void add_one_ports(const std::string& junction, bool only_junction) {
    std::size_t count = dice_.below(options_.most_at_junction + 1);
    if (only_junction) count += 1;
    for (std::size_t i = 0; i < count && result_.bonds.size() < options_.most_bonds; ++i) {
      if (options_.mixed_fields > 0.0 && dice_.chance(options_.mixed_fields)) {
        const std::string field = add("IC", dice_.moderate());
        bond(junction, field + ".a");
        bond(junctions_[dice_.below(junctions_.size())], field + ".b");
        continue;
      }
      static const std::array<std::string, 3> kPassive{"R", "C", "I"};
      const std::string kind =
          dice_.chance(options_.sources) ? (dice_.chance(0.5) ? "Se" : "Sf") : kPassive[dice_.below(3)];
      bond(junction, add(kind, dice_.moderate()));
    }
  }

  Dice dice_;
  RandomGraphOptions options_;
  std::vector<std::string> junctions_;
  RandomGraph result_;
};

std::string key_of(const std::string& kind) {
  if (kind == "Se") return "effort";
  if (kind == "Sf") return "flow";
  if (kind == "R") return "resistance";
  if (kind == "C") return "capacitance";
  if (kind == "I") return "inertance";
  return "modulus";
}

}  // namespace

RandomGraph random_graph(std::uint64_t seed, const RandomGraphOptions& options) {
  return Generator(seed, options).graph();
}

RandomGraph shuffled(const RandomGraph& graph, std::uint64_t seed) {
  Dice dice(seed);
  RandomGraph other = graph;
  dice.shuffle(other.elements);
  dice.shuffle(other.bonds);
  return other;
}

std::string RandomGraph::json() const {
  std::string parameters, members, outputs, list;
  const auto append = [](std::string& text, const std::string& member) {
    text += (text.empty() ? "\n  " : ",\n  ") + member;
  };
  const auto quoted = [](const std::string& text) { return '"' + text + '"'; };
  for (const RandomElement& element : elements) {
    const bool detector = element.kind == "De" || element.kind == "Df";
    const bool no_value = detector || element.kind == "0" || element.kind == "1";
    const bool source = element.kind == "Se" || element.kind == "Sf";
    if (source) append(parameters, quoted("u_" + element.name) + ": " + number(element.value));
    if (element.kind == "IC") {
      // Positive: the product of the squares' factors is above that of the mixed one's, for values above 0.16.
      append(members, quoted(element.name) + R"(: {"kind": "IC", "ports": {"a": "q", "b": "p"}, "energy": "()" +
                          number(element.value) + R"(*a.q^2 + 0.8*a.q*b.p + b.p^2)/2"})");
      for (const std::string variable : {"a.e", "a.f", "a.q", "b.e", "b.f", "b.p"})
        append(outputs, quoted(element.name + "_" + variable) + ": " + quoted(element.name + "." + variable));
      continue;
    }
    const std::string value = source ? quoted("u_" + element.name) : number(element.value);
    append(members, quoted(element.name) + R"(: {"kind": )" + quoted(element.kind) +
                        (no_value ? "}" : ", " + quoted(key_of(element.kind)) + ": " + value + "}"));
    if (detector)
      append(outputs, quoted(element.name) + ": " + quoted(element.name + (element.kind == "De" ? ".e" : ".f")));
    if (element.kind == "C" || element.kind == "I")
      for (const std::string variable : {"e", "f", element.kind == "C" ? "q" : "p"})
        append(outputs, quoted(element.name + "_" + variable) + ": " + quoted(element.name + "." + variable));
  }
  for (const auto& [from, to] : bonds) append(list, R"({"from": )" + quoted(from) + R"(, "to": )" + quoted(to) + "}");
  return "{\"bgsim\": 1, \"name\": \"random\",\n \"parameters\": {" + parameters + "},\n \"elements\": {" + members +
         "},\n \"bonds\": [" + list + "],\n \"outputs\": {" + outputs +
         "},\n \"scenes\": {\"run\": {\"stop\": 2, \"samples\": 9}}}\n";
}

}  // namespace bgsim::test

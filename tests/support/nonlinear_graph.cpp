#include "support/nonlinear_graph.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <random>

namespace bgsim::test {

namespace {

constexpr double kDiodeVoltage = 0.05, kDiodeLeak = 1e-3, kRootWidth = 0.1;

std::string number(double value) {
  std::array<char, 32> buffer{};
  return {buffer.data(), std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr};
}

/// Distributions of the standard library differ between implementations; these do not.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : engine_(seed * 0x9E3779B97F4A7C15U + 7) {}
  double unit() { return static_cast<double>(engine_() >> 11U) * 0x1.0p-53; }
  std::size_t below(std::size_t count) { return static_cast<std::size_t>(unit() * static_cast<double>(count)); }
  bool chance(double probability) { return unit() < probability; }
  double moderate() { return std::pow(3.0, 2.0 * unit() - 1.0); }
  double between(double least, double most) { return least + (most - least) * unit(); }

 private:
  std::mt19937_64 engine_;
};

}  // namespace

// --- laws

double Curve::value(double x) const {
  switch (shape) {
    case Shape::linear:
      return scale * x;
    case Shape::cubic:
      return scale * (x + 2.0 * x * x * x);
    case Shape::hyperbolic_sine:
      return scale * std::sinh(2.0 * x);
    case Shape::saturating:
      return scale * (std::tanh(5.0 * x) + 0.1 * x);
    case Shape::arc:
      return scale * (std::atan(10.0 * x) + 0.05 * x);
    case Shape::root:
      return scale * x / std::sqrt(std::sqrt(x * x + kRootWidth * kRootWidth));
    case Shape::diode:
      // Newton's iterates beyond what a double holds follow the tangent.
      if (x > 30.0 * kDiodeVoltage)
        return value(30.0 * kDiodeVoltage) + slope(30.0 * kDiodeVoltage) * (x - 30.0 * kDiodeVoltage);
      return scale * (1e-3 * (std::exp(x / kDiodeVoltage) - 1.0) + kDiodeLeak * x);
    case Shape::inverse_sine:
      return scale * std::asinh(4.0 * x);
    case Shape::stiffening:
      return scale * x * (1.0 + 3.0 * x * x) / (1.0 + x * x);
  }
  return 0.0;
}

double Curve::slope(double x) const {
  switch (shape) {
    case Shape::linear:
      return scale;
    case Shape::cubic:
      return scale * (1.0 + 6.0 * x * x);
    case Shape::hyperbolic_sine:
      return scale * 2.0 * std::cosh(2.0 * x);
    case Shape::saturating:
      return scale * (5.0 * (1.0 - std::tanh(5.0 * x) * std::tanh(5.0 * x)) + 0.1);
    case Shape::arc:
      return scale * (10.0 / (1.0 + 100.0 * x * x) + 0.05);
    case Shape::root: {
      const double s = x * x + kRootWidth * kRootWidth;
      return scale * (s - x * x / 2.0) / (s * std::sqrt(std::sqrt(s)));
    }
    case Shape::diode:
      return scale * (1e-3 / kDiodeVoltage * std::exp(std::min(x, 30.0 * kDiodeVoltage) / kDiodeVoltage) + kDiodeLeak);
    case Shape::inverse_sine:
      return scale * 4.0 / std::sqrt(1.0 + 16.0 * x * x);
    case Shape::stiffening: {
      const double d = 1.0 + x * x;
      return scale * ((1.0 + 9.0 * x * x) * d - 2.0 * x * x * (1.0 + 3.0 * x * x)) / (d * d);
    }
  }
  return 0.0;
}

std::string Curve::text(const std::string& x) const {
  const std::string a = number(scale);
  switch (shape) {
    case Shape::linear:
      return a + "*" + x;
    case Shape::cubic:
      return a + "*(" + x + " + 2*" + x + "^3)";
    case Shape::hyperbolic_sine:
      return a + "*sinh(2*" + x + ")";
    case Shape::saturating:
      return a + "*(tanh(5*" + x + ") + 0.1*" + x + ")";
    case Shape::arc:
      return a + "*(atan(10*" + x + ") + 0.05*" + x + ")";
    case Shape::root:
      return a + "*ssqrt(" + x + ", " + number(kRootWidth) + ")";
    case Shape::diode:
      return a + "*(1e-3*(exp(" + x + "/" + number(kDiodeVoltage) + ") - 1) + " + number(kDiodeLeak) + "*" + x + ")";
    case Shape::inverse_sine:
      return a + "*asinh(4*" + x + ")";
    case Shape::stiffening:
      return a + "*" + x + "*(1 + 3*" + x + "^2)/(1 + " + x + "^2)";
  }
  return {};
}

// --- the graphs

namespace {

class Decorator {
 public:
  Decorator(std::uint64_t seed, const NonlinearGraphOptions& options) : dice_(seed), options_(options) {
    result_.graph = random_graph(seed, options.graph);
  }

  NonlinearGraph graph() {
    for (const RandomElement& element : result_.graph.elements)
      if (element.kind == "C" || element.kind == "I") stores_.push_back(element.name);
    for (const RandomElement& element : result_.graph.elements) decorate(element);
    for (const std::string kind : {"C", "I"}) join(kind);
    return std::move(result_);
  }

 private:
  void decorate(const RandomElement& element) {
    const std::string& kind = element.kind;
    if (kind == "Se" || kind == "Sf") {
      NonlinearGraph::Source source{dice_.between(-1.0, 1.0), dice_.chance(0.5) ? dice_.moderate() : 0.0,
                                    dice_.between(0.5, 6.0), dice_.chance(0.3) ? dice_.between(-1.0, 1.0) : 0.0};
      result_.sources[element.name] = source;
    } else if (kind == "R") {
      const Curve curve = any_curve(element.value, options_.diodes);
      result_.curves[element.name] = curve;
      // A diode is written as it is everywhere: its current by its voltage.
      result_.gives_effort[element.name] = curve.shape != Curve::Shape::diode && dice_.chance(0.5);
    } else if (kind == "C" || kind == "I") {
      // e = q/C
      result_.curves[element.name] = any_curve(1.0 / element.value, false);
      result_.initial[element.name] = dice_.chance(0.5) ? dice_.between(-1.0, 1.0) : 0.0;
    } else if (kind == "TF" || kind == "GY") {
      NonlinearGraph::Modulus modulus{element.value, 0.0, {}};
      if (dice_.chance(options_.modulated)) {
        modulus.swing = 0.5 * element.value;
        if (!stores_.empty() && dice_.chance(0.7)) modulus.store = stores_[dice_.below(stores_.size())];
      }
      result_.moduli[element.name] = modulus;
    }
  }

  Curve any_curve(double scale, bool diode) {
    if (!dice_.chance(options_.nonlinear)) return {Curve::Shape::linear, scale};
    static constexpr std::array kShapes{
        Curve::Shape::cubic, Curve::Shape::hyperbolic_sine, Curve::Shape::saturating, Curve::Shape::arc,
        Curve::Shape::root,  Curve::Shape::inverse_sine,    Curve::Shape::stiffening, Curve::Shape::diode};
    return {kShapes[dice_.below(kShapes.size() - (diode ? 0 : 1))], scale};
  }

  /// Two stores of a kind become a field.
  void join(const std::string& kind) {
    std::vector<std::string> names;
    for (const RandomElement& element : result_.graph.elements)
      if (element.kind == kind) names.push_back(element.name);
    for (std::size_t i = 0; i + 1 < names.size(); i += 2)
      if (dice_.chance(options_.fields))
        result_.fields.push_back({"field_" + names[i], names[i], names[i + 1], kind == "C", dice_.moderate(),
                                  dice_.between(-0.8, 0.8), dice_.chance(0.5) ? 0.1 : 0.0});
  }

  Dice dice_;
  NonlinearGraphOptions options_;
  std::vector<std::string> stores_;
  NonlinearGraph result_;
};

}  // namespace

NonlinearGraph random_nonlinear_graph(std::uint64_t seed, const NonlinearGraphOptions& options) {
  return Decorator(seed, options).graph();
}

namespace {

using Lines = std::vector<std::string>;

std::string joined(Lines lines, Dice* dice) {
  if (dice != nullptr)
    for (std::size_t i = lines.size(); i > 1; --i) std::swap(lines[i - 1], lines[dice->below(i)]);
  std::string text;
  for (const std::string& line : lines) text += (text.empty() ? "\n  " : ",\n  ") + line;
  return text;
}

std::string quoted(const std::string& text) { return "\"" + text + "\""; }

class Writer {
 public:
  Writer(const NonlinearGraph& graph, const Writing& how) : graph_(graph), how_(how) {
    for (std::size_t i = 0; i < graph.graph.elements.size(); ++i) {
      const std::string& name = graph.graph.elements[i].name;
      kinds_[name] = graph.graph.elements[i].kind;
      names_[name] = how.renamed ? "z" + std::to_string(997 * (i + 1) % 1009) + "_" + name.substr(0, 1) : name;
    }
    for (const NonlinearGraph::Field& field : graph.fields) {
      names_[field.one] = "field_" + names_[field.one] + ".a";
      names_[field.two] = names_[field.one].substr(0, names_[field.one].size() - 1) + "b";
    }
  }

  std::string json() {
    for (const RandomElement& element : graph_.graph.elements) write(element);
    for (const NonlinearGraph::Field& field : graph_.fields) write(field);
    for (const auto& [from, to] : graph_.graph.bonds) write(from, to);
    Dice dice(how_.order);
    Dice* order = how_.order == 0 ? nullptr : &dice;
    return "{\"bgsim\": 1, \"name\": \"random\",\n \"elements\": {" + joined(members_, order) + "},\n \"bonds\": [" +
           joined(bonds_, order) + "],\n \"outputs\": {" + joined(outputs_, nullptr) +
           "},\n \"scenes\": {\"run\": {\"stop\": " + number(graph_.stop) +
           ", \"samples\": " + std::to_string(graph_.intervals + 1) + "}}}\n";
  }

 private:
  [[nodiscard]] static std::string scaled(const std::string& text, double factor) {
    return factor == 1.0 ? text : number(factor) + "*(" + text + ")";
  }
  [[nodiscard]] bool is_flow_like(const std::string& kind) const { return kind == "C" || kind == "Sf"; }
  /// What q or p is divided by to have the unscaled one.
  [[nodiscard]] double unit(const std::string& store) const {
    return is_flow_like(kinds_.at(store)) ? how_.flow : how_.effort;
  }
  [[nodiscard]] static std::string over(const std::string& variable, double unit) {
    return unit == 1.0 ? variable : "(" + variable + "/" + number(unit) + ")";
  }
  [[nodiscard]] std::string stored(const std::string& name) const {
    return names_.at(name) + (kinds_.at(name) == "C" ? ".q" : ".p");
  }
  void member(const std::string& name, const std::string& kind, Lines keys) {
    keys.push_back("\"kind\": " + quoted(kind));
    Dice dice(how_.order + 1);
    members_.push_back(quoted(name) + ": {" + joined(std::move(keys), how_.order == 0 ? nullptr : &dice) + "}");
  }

  void write(const RandomElement& element) {
    const std::string& name = element.name;
    const std::string& kind = element.kind;
    if (kind == "0" || kind == "1") return member(names_.at(name), kind, {});
    if (kind == "Se" || kind == "Sf") return write_source(name, kind);
    if (kind == "TF" || kind == "GY") return write_two_port(name, kind);
    for (const std::string variable : {"e", "f"})
      outputs_.push_back(quoted(name + "_" + variable) + ": " + quoted(names_.at(name) + "." + variable));
    if (kind != "R") outputs_.push_back(quoted(name + "_x") + ": " + quoted(stored(name)));
    if (names_.at(name).find('.') != std::string::npos) return;  // a port of a field
    const Curve& curve = graph_.curves.at(name);
    Lines keys;
    const auto law = [&](const std::string& left, double left_unit, const std::string& right, double right_unit) {
      keys.push_back("\"law\": " + quoted(left + " = " + scaled(curve.text(over(right, right_unit)), left_unit)));
    };
    if (kind == "R" && graph_.gives_effort.at(name)) law("e", how_.effort, "f", how_.flow);
    if (kind == "R" && !graph_.gives_effort.at(name)) law("f", how_.flow, "e", how_.effort);
    if (kind == "C") law("e", how_.effort, "q", how_.flow);
    if (kind == "I") law("f", how_.flow, "p", how_.effort);
    if (kind != "R" && graph_.initial.at(name) != 0.0)
      keys.push_back("\"initial\": {" + quoted(kind == "C" ? "q" : "p") + ": " +
                     number(graph_.initial.at(name) * unit(name)) + "}");
    member(names_.at(name), kind, keys);
  }

  void write_source(const std::string& name, const std::string& kind) {
    const NonlinearGraph::Source& s = graph_.sources.at(name);
    const double factor =
        (kind == "Se" ? how_.effort : how_.flow) * (turned(name) && kind == turning_sign(name) ? -1.0 : 1.0);
    member(names_.at(name), kind,
           {quoted(kind == "Se" ? "effort" : "flow") + ": " +
            quoted(scaled(number(s.mean) + " + " + number(s.swing) + "*sin(" + number(s.frequency) + "*t) + " +
                              number(s.jump) + "*step(t - " + number(graph_.jump_time) + ")",
                          factor))});
  }

  void write_two_port(const std::string& name, const std::string& kind) {
    const NonlinearGraph::Modulus& m = graph_.moduli.at(name);
    const std::string by = m.store.empty() ? "t" : over(stored(m.store), unit(m.store));
    member(names_.at(name), "M" + kind,
           {"\"modulus\": " + quoted(scaled(number(m.mean) + " + " + number(m.swing) + "*sin(" + by + ")",
                                            kind == "GY" ? how_.effort / how_.flow : 1.0))});
  }

  void write(const NonlinearGraph::Field& field) {
    const std::string x = field.displacements ? "q" : "p";
    const double u = unit(field.one);
    const std::string a = over("a." + x, u), b = over("b." + x, u);
    Lines starts;
    for (const auto& [port, name] : {std::pair("a." + x, field.one), std::pair("b." + x, field.two)})
      if (graph_.initial.at(name) != 0.0) starts.push_back(quoted(port) + ": " + number(graph_.initial.at(name) * u));
    const std::string energy = "(" + a + "^2 + " + b + "^2)/(2*" + number(field.scale) + ") + " +
                               number(field.coupling / field.scale) + "*" + a + "*" + b + " + " +
                               number(field.stiffening) + "*(" + a + " + " + b + ")^4";
    const std::string& port = names_.at(field.one);
    member(port.substr(0, port.size() - 2), field.displacements ? "CC" : "II",
           {"\"ports\": [\"a\", \"b\"]", "\"energy\": " + quoted(scaled(energy, how_.effort * how_.flow)),
            "\"initial\": {" + joined(starts, nullptr) + "}"});
  }

  /// The junction of a one-port.
  [[nodiscard]] std::string junction(const std::string& name) const {
    for (const auto& [from, to] : graph_.graph.bonds) {
      if (from == name) return to;
      if (to == name) return from;
    }
    return {};
  }
  /// Whether the half-arrow of a one-port is written the other way: at a 0-junction nothing is another for it but the
  /// sign of a flow that is given, at a 1-junction only for sources, where an effort has the other sign.
  [[nodiscard]] bool turned(const std::string& name) const {
    if (!how_.reversed || !kinds_.contains(name)) return false;
    const std::string& kind = kinds_.at(name);
    if (kind == "0" || kind == "1" || kind == "TF" || kind == "GY") return false;
    return kinds_.at(junction(name)) == "0" || kind == "Se" ? true : kind == "Sf" && kinds_.at(junction(name)) == "0";
  }
  [[nodiscard]] std::string turning_sign(const std::string& name) const {
    return kinds_.at(junction(name)) == "0" ? "Sf" : "Se";
  }

  void write(const std::string& from, const std::string& to) {
    const bool turn = turned(from) || turned(to);
    const std::string start = quoted(end(turn ? to : from)), stop = quoted(end(turn ? from : to));
    bonds_.push_back(R"({"from": )" + start + R"(, "to": )" + stop + "}");
  }
  [[nodiscard]] std::string end(const std::string& written) const {
    if (names_.contains(written)) return names_.at(written);
    const std::size_t dot = written.find('.');
    return names_.at(written.substr(0, dot)) + written.substr(dot);
  }

  const NonlinearGraph& graph_;
  const Writing& how_;
  std::map<std::string, std::string> kinds_, names_;
  Lines members_, bonds_, outputs_;
};

}  // namespace

std::string NonlinearGraph::json(const Writing& writing) const { return Writer(*this, writing).json(); }

}  // namespace bgsim::test

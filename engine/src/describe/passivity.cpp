#include "bgsim/passivity.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <deque>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <unordered_map>

#include "base/text.hpp"
#include "bgsim/text.hpp"
#include "describe/semidefinite.hpp"
#include "expression/graph.hpp"
#include "expression/interval.hpp"
#include "model/constitutive.hpp"

namespace bgsim {
namespace {

constexpr double kLargest = std::numeric_limits<double>::max();
constexpr double kSmallest = std::numeric_limits<double>::denorm_min();

/// Ranges of expressions, where what they are made of has any value that it can have.
class Ranges {
 public:
  Ranges(const Model& model, const RunInputs& inputs) : model_(model), inputs_(inputs), pool_(model.pool) {}

  ExprPool& pool() { return pool_; }

  /// Of @p root, with @p own within @p x.
  Range of(ExprId root, SymbolId own = {}, const Range& x = kAllNumbers) {
    return of(root, std::span(&own, own.valid() ? 1 : 0), std::span(&x, own.valid() ? 1 : 0));
  }

  /// With each of @p own within the range at its position.
  Range of(ExprId root, std::span<const SymbolId> own, std::span<const Range> x) {
    std::unordered_map<std::uint32_t, Range> known;
    arguments_first(
        pool_, root, [&](ExprId id) { return known.contains(id.value); },
        [&](ExprId id) {
          const ExprNode& node = pool_[id];
          const auto at = [&](std::uint32_t argument) { return known.at(argument); };
          if (node.op == Op::constant) {
            known.emplace(id.value, Range(node.constant, node.constant));
          } else if (node.op == Op::symbol) {
            const SymbolId symbol = pool_.symbol_of(id);
            const auto found = std::find(own.begin(), own.end(), symbol);
            known.emplace(id.value,
                          found == own.end() ? of_symbol(symbol) : x[static_cast<std::size_t>(found - own.begin())]);
          } else if (node.op == Op::der) {
            const Range& argument = known.at(node.a);
            const bool constant = argument.lower() == argument.upper() || number(ExprId(node.a));
            known.emplace(id.value, constant ? Range(0.0, 0.0) : kAllNumbers);
          } else {
            const int n = arity(node.op);
            const Table* table = is_table(node.op) ? pool_.tables()[node.b].get() : nullptr;
            const Range none;
            known.emplace(id.value,
                          range_of(node.op, table, at(node.a), n > 1 ? at(node.b) : none, n > 2 ? at(node.c) : none));
          }
        });
    return known.at(root.value);
  }

  /// With parameters alone.
  std::optional<double> number(ExprId root) {
    bool fixed = true;
    std::vector<double> values(model_.symbols.size(), 0.0);
    each_symbol(root, [&](SymbolId symbol) {
      const ModelSymbol& what = model_.symbols[symbol.index()];
      fixed &= what.kind == ModelSymbol::Kind::parameter;
      if (fixed) values[symbol.index()] = inputs_.parameters[what.parameter.index()];
    });
    const double value = fixed ? evaluate(pool_, root, values) : 0.0;
    return fixed && std::isfinite(value) ? std::optional(value) : std::nullopt;
  }

  /// Whether @p root depends on anything but parameters and time, signals followed.
  bool depends_on_states(ExprId root) {
    bool depends = false;
    each_symbol(root, [&](SymbolId symbol) { depends |= symbol_depends(symbol); });
    return depends;
  }

 private:
  void each_symbol(ExprId root, const std::function<void(SymbolId)>& take) {
    std::unordered_map<std::uint32_t, bool> known;
    arguments_first(
        pool_, root, [&](ExprId id) { return known.contains(id.value); },
        [&](ExprId id) {
          known.emplace(id.value, true);
          if (pool_[id].op == Op::symbol) take(pool_.symbol_of(id));
        });
  }

  /// Signals refer to signals in an order without cycles; the depth is that of the model's own definitions.
  Range of_symbol(SymbolId symbol) {
    const ModelSymbol& what = model_.symbols[symbol.index()];
    if (what.kind == ModelSymbol::Kind::parameter) {
      const double value = inputs_.parameters[what.parameter.index()];
      return {value, value};
    }
    if (what.kind == ModelSymbol::Kind::time) return {inputs_.start, kInfinity};
    if (what.kind != ModelSymbol::Kind::signal) return kAllNumbers;
    const Signal& signal = model_.signals[what.signal.index()];
    if (signal.is_state() || signal.delay) return kAllNumbers;
    if (const auto found = signals_.find(symbol.value); found != signals_.end()) return found->second;
    signals_.emplace(symbol.value, kAllNumbers);  // a signal in itself, which other stages refuse
    Range range = of(signal.value);
    if (is_empty(range)) range = kAllNumbers;
    signals_[symbol.value] = range;
    return range;
  }

  bool symbol_depends(SymbolId symbol) {
    const ModelSymbol& what = model_.symbols[symbol.index()];
    if (what.kind == ModelSymbol::Kind::parameter || what.kind == ModelSymbol::Kind::time) return false;
    if (what.kind != ModelSymbol::Kind::signal) return true;
    const Signal& signal = model_.signals[what.signal.index()];
    if (const auto found = dependent_.find(symbol.value); found != dependent_.end()) return found->second;
    dependent_.emplace(symbol.value, true);
    const bool depends = depends_on_states(signal.value);
    dependent_[symbol.value] = depends;
    return depends;
  }

  const Model& model_;
  const RunInputs& inputs_;
  ExprPool pool_;
  std::unordered_map<std::uint32_t, Range> signals_;
  std::unordered_map<std::uint32_t, bool> dependent_;
};

/// The double halfway between two of one sign, counted in doubles: so that all magnitudes have their share.
double halfway(double a, double b) {
  const auto bits = [](double x) { return std::bit_cast<std::uint64_t>(x); };
  return std::bit_cast<double>(bits(a) + (bits(b) - bits(a)) / 2);
}

double next_double(double x) { return std::bit_cast<double>(std::bit_cast<std::uint64_t>(x) + 1); }

struct Searched {
  std::optional<Range> wrong, undecided;  ///< magnitudes: certainly wrong; the widest that is neither
};

/// The widest of @p parts, those side by side being one; none if there are none.
std::optional<Range> widest(std::vector<Range> parts) {
  std::sort(parts.begin(), parts.end(), [](const Range& a, const Range& b) { return a.lower() < b.lower(); });
  std::optional<Range> best, run;
  for (const Range& part : parts) {
    run = run && next_double(run->upper()) >= part.lower() ? Range(run->lower(), part.upper()) : part;
    if (!best || run->upper() - run->lower() >= best->upper() - best->lower()) best = run;
  }
  return best;
}

/// All magnitudes of doubles but 0, from the smallest to the largest, in parts until each is decided; large parts
/// first, so that one that cannot be decided does not keep the others from it.
/// @param decide  of a part: 1 right, -1 wrong for all of it, 0 not decided
Searched search_magnitudes(const std::function<int(const Range&)>& decide) {
  std::deque<Range> open{Range(kSmallest, kLargest)};
  std::vector<Range> wrong, undecided;
  constexpr int kMost = 50000;
  for (int count = 0; !open.empty() && count < kMost; ++count) {
    const Range part = open.front();
    open.pop_front();
    const int verdict = decide(part);
    if (verdict > 0) continue;
    if (verdict < 0) {
      wrong.push_back(part);
    } else if (is_thin(part)) {
      undecided.push_back(part);
    } else {
      const double middle = halfway(part.lower(), part.upper());
      open.emplace_back(part.lower(), middle);
      open.emplace_back(next_double(middle), part.upper());
    }
  }
  undecided.insert(undecided.end(), open.begin(), open.end());
  return {widest(std::move(wrong)), widest(std::move(undecided))};
}

class Judging {
 public:
  Judging(const Model& model, const RunInputs& inputs) : model_(model), ranges_(model, inputs) {}

  Passivity run() {
    Passivity found;
    for (std::size_t i = 0; i < model_.elements.size(); ++i) {
      const Element& element = model_.elements[i];
      const ElementId id(i);
      if (is_store(element.kind)) {
        found.stores.push_back(of_store(id, element));
      } else if (element.contact) {
        found.others.push_back(of_contact(element));
      } else if (is_diode(element.kind)) {
        found.others.push_back(of_diode(element));
      } else if (is_switch(element.kind) || is_detector(element.kind)) {
        continue;  // a switch is ideal: no power while it stands, a loss when it closes
      } else if (is_source(element.kind)) {
        const bool driven = !element.coefficient.valid() || ranges_.depends_on_states(element.coefficient);
        (driven ? found.driven : found.sources).push_back(element.name);
      } else if (const std::vector<Law> laws = port_laws(model_, ranges_.pool(), id); !laws.empty()) {
        found.resistors.push_back(of_resistor(element, laws));
      }
    }
    for (const ModelEvent& event : model_.events)
      found.others.push_back({event.name, Proof::undecided, "an event that sets stores may add energy", "", 0.0, 0.0});
    return found;
  }

 private:
  PassivityFinding of_resistor(const Element& element, const std::vector<Law>& laws) {
    PassivityFinding finding;
    finding.element = element.name;
    if (std::any_of(laws.begin(), laws.end(), [](const Law& law) { return law.zero; })) {
      finding.reason = "its law is not solved for a variable";
      return finding;
    }
    if (laws.size() != 1) {
      of_field(element, laws, finding);
      return finding;
    }
    const Law& law = laws.front();
    const Variable own = law.variable == Variable::effort ? Variable::flow : Variable::effort;
    same_sign(law.right, port_variable(element, 0, own), own, finding);
    if (finding.proof == Proof::proved) finding.reason = "e f >= 0";
    if (finding.proof == Proof::refuted) finding.reason = "e f < 0";
    return finding;
  }

  /// A resistive field: the sum of e f over its ports. Each port takes what its law does not give.
  void of_field(const Element& element, const std::vector<Law>& laws, PassivityFinding& finding) {
    std::vector<SymbolId> own;
    std::vector<Variable> kinds;
    std::vector<ExprId> given;
    std::unordered_map<SymbolId, ExprId> known;
    for (const Law& law : laws) {
      kinds.push_back(law.variable == Variable::effort ? Variable::flow : Variable::effort);
      own.push_back(port_variable(element, law.port, kinds.back()));
      known[port_variable(element, law.port, law.variable)] = law.right;
    }
    // What one law gives another one may read.
    for (const Law& law : laws) {
      ExprId right = law.right;
      for (std::size_t i = 0; i < laws.size(); ++i) right = substitute(ranges_.pool(), right, known);
      for (const SymbolId symbol : symbols_in(ranges_.pool(), {&right, 1}))
        if (known.contains(symbol)) {
          finding.reason = "its laws read each other's results in a ring";
          return;
        }
      given.push_back(right);
    }
    if (decide_linear(own, kinds, laws, element, given, finding) || decide_apart(own, kinds, given, finding)) return;
    decide_by_boxes(own, laws, element, given, finding);
  }

  /// "base.e = 0.7, collector.e = -0.7"
  static std::string point_words(const Element& element, const std::vector<Law>& laws,
                                 const std::vector<Variable>& kinds, const std::vector<std::string>& values) {
    std::string words;
    for (std::size_t i = 0; i < laws.size(); ++i)
      words += (i > 0 ? ", " : "") + port_name(element, laws[i].port).substr(element.name.size() + 1) + '.' +
               letter(kinds[i]) + values[i];
    return words;
  }

  /// Laws that are sums of their variables times numbers: by the definiteness of the matrix. False: they are not.
  bool decide_linear(const std::vector<SymbolId>& own, const std::vector<Variable>& kinds, const std::vector<Law>& laws,
                     const Element& element, const std::vector<ExprId>& given, PassivityFinding& finding) {
    std::vector<std::vector<double>> matrix;
    const std::vector<Range> zeros(own.size(), Range(0.0, 0.0));
    for (const ExprId value : given) {
      const Range at_zero = ranges_.of(value, own, zeros);
      if (is_empty(at_zero) || at_zero.lower() != 0.0 || at_zero.upper() != 0.0) return false;
      std::vector<double>& row = matrix.emplace_back(own.size(), 0.0);
      const auto wanted = [&](SymbolId s) { return std::find(own.begin(), own.end(), s) != own.end(); };
      for (const auto& [symbol, partial] : gradient(ranges_.pool(), value, wanted)) {
        const std::optional<double> number = ranges_.number(partial);
        if (!number) return false;
        row[static_cast<std::size_t>(std::find(own.begin(), own.end(), symbol) - own.begin())] = *number;
      }
    }
    if (!all_smooth(given)) return false;
    if (is_positive_semidefinite(matrix)) {
      finding.proof = Proof::proved;
      finding.reason = "the sum of e f is not negative: the symmetric part of its matrix is positive semidefinite";
      return true;
    }
    const std::vector<double> u = direction_of_negative_power(matrix);
    finding.proof = u.empty() ? Proof::undecided : Proof::refuted;
    finding.reason = "the symmetric part of its matrix is indefinite";
    if (u.empty()) return true;
    std::vector<std::string> values;
    for (const double x : u) values.push_back(" = " + number_text(x, 3));
    finding.reason = "the sum of e f is negative at " + point_words(element, laws, kinds, values);
    return true;
  }

  /// Whether a slope that is a number everywhere is that of a straight line: no step or sign adds to it.
  bool all_smooth(const std::vector<ExprId>& roots) {
    const std::vector<ExprId> nodes = reachable(ranges_.pool(), roots);
    return std::none_of(nodes.begin(), nodes.end(), [&](ExprId e) {
      const Op op = ranges_.pool()[e].op;
      return is_comparison(op) || op == Op::sign || op == Op::step || is_rounding(op) || op == Op::mod || is_table(op);
    });
  }

  /// Ports that do not read each other: each by itself. False: some do.
  bool decide_apart(const std::vector<SymbolId>& own, const std::vector<Variable>& kinds,
                    const std::vector<ExprId>& given, PassivityFinding& finding) {
    for (std::size_t i = 0; i < given.size(); ++i)
      for (const SymbolId symbol : symbols_in(ranges_.pool(), {&given[i], 1}))
        if (symbol != own[i] && std::find(own.begin(), own.end(), symbol) != own.end()) return false;
    PassivityFinding worst;
    worst.proof = Proof::proved;
    for (std::size_t i = 0; i < given.size(); ++i) {
      PassivityFinding one;
      same_sign(given[i], own[i], kinds[i], one);
      if (one.proof == Proof::refuted || (one.proof == Proof::undecided && worst.proof == Proof::proved)) worst = one;
    }
    worst.element = finding.element;
    worst.reason = worst.proof == Proof::proved    ? "e f >= 0 at each port"
                   : worst.proof == Proof::refuted ? "e f < 0"
                                                   : "not decided";
    finding = worst;
    return true;
  }

  /// The power over boxes of all variables, by signs and magnitudes.
  void decide_by_boxes(const std::vector<SymbolId>& own, const std::vector<Law>& laws, const Element& element,
                       const std::vector<ExprId>& given, PassivityFinding& finding) {
    finding.reason = "the power of a field is a sum over its ports, which is not decided";
    ExprPool& pool = ranges_.pool();
    ExprId power = pool.constant(0.0);
    for (std::size_t i = 0; i < own.size(); ++i) power = pool.add(power, pool.mul(pool.symbol(own[i]), given[i]));
    if (pool.is_constant(power, 0.0)) {
      finding.proof = Proof::proved;
      finding.reason = "what one port takes another gives";
      return;
    }
    constexpr std::size_t kMostPorts = 3;  // 26 parts by signs
    if (own.size() > kMostPorts) return;
    std::vector<int> signs(own.size(), -1);
    bool all = true;
    while (true) {
      std::optional<std::vector<Range>> wrong;
      all = search_boxes(power, own, signs, wrong) && all;
      if (wrong) {
        finding.proof = Proof::refuted;
        // Any point of it will do: one of moderate size.
        std::vector<std::string> values;
        for (const Range& x : *wrong) {
          const double near =
              x.upper() < 0.0 ? -std::clamp(1.0, -x.upper(), -x.lower()) : std::clamp(1.0, x.lower(), x.upper());
          values.push_back(" = " + number_text(near, 3));
        }
        std::vector<Variable> kinds;
        for (const Law& law : laws)
          kinds.push_back(law.variable == Variable::effort ? Variable::flow : Variable::effort);
        finding.reason = "the sum of e f is negative at " + point_words(element, laws, kinds, values);
        return;
      }
      std::size_t at = 0;
      while (at < signs.size() && ++signs[at] > 1) signs[at++] = -1;
      if (at == signs.size()) break;
    }
    if (!all) return;
    finding.proof = Proof::proved;
    finding.reason = "the sum of e f is not negative";
  }

  /// @param wrong  a box in which the power is negative throughout, if one is found
  /// @return whether it is not negative in any.
  bool search_boxes(ExprId power, const std::vector<SymbolId>& own, const std::vector<int>& signs,
                    std::optional<std::vector<Range>>& wrong) {
    using Box = std::vector<Range>;
    std::deque<Box> open{Box(own.size(), Range(kSmallest, kLargest))};
    constexpr int kMost = 5000;
    bool decided = true;
    for (int count = 0; !open.empty(); ++count) {
      if (count == kMost) return false;
      const Box box = open.front();
      open.pop_front();
      Box at(own.size(), Range(0.0, 0.0));
      for (std::size_t i = 0; i < own.size(); ++i)
        if (signs[i] != 0) at[i] = box[i] * Range(signs[i], signs[i]);
      const Range y = ranges_.of(power, own, at);
      if (is_empty(y) || y.lower() >= 0.0) continue;
      if (y.upper() < 0.0) {
        wrong = at;
        return false;
      }
      // Along the variable over which it has most doubles.
      std::size_t longest = own.size();
      std::uint64_t most = 0;
      for (std::size_t i = 0; i < own.size(); ++i) {
        const std::uint64_t length =
            std::bit_cast<std::uint64_t>(box[i].upper()) - std::bit_cast<std::uint64_t>(box[i].lower());
        if (signs[i] != 0 && length > most) {
          most = length;
          longest = i;
        }
      }
      if (longest == own.size()) {
        decided = false;
        continue;
      }
      const double middle = halfway(box[longest].lower(), box[longest].upper());
      Box half = box;
      half[longest] = Range(box[longest].lower(), middle);
      open.push_back(half);
      half[longest] = Range(next_double(middle), box[longest].upper());
      open.push_back(std::move(half));
    }
    return decided;
  }

  /// Whether the law has the sign of its variable, so that their product is not negative.
  void same_sign(ExprId right, SymbolId own, Variable variable, PassivityFinding& finding) {
    finding.proof = Proof::proved;
    for (const double side : {1.0, -1.0}) {
      const Searched found = search_magnitudes([&](const Range& part) {
        const Range y = ranges_.of(right, own, part * Range(side, side)) * Range(side, side);
        return is_empty(y) || y.lower() >= 0.0 ? 1 : y.upper() < 0.0 ? -1 : 0;
      });
      take(found, side, variable, finding);
    }
    if (finding.proof == Proof::undecided) finding.reason = "not decided";
  }

  static void take(const Searched& found, double side, Variable variable, PassivityFinding& finding) {
    const auto place = [&](const Range& part) {
      finding.variable = letter(variable);
      const double near = part.lower() == kSmallest ? 0.0 : part.lower();
      const double far = part.upper() == kLargest ? kInfinity : part.upper();
      finding.from = side > 0.0 ? near : -far;
      finding.to = side > 0.0 ? far : 0.0 - near;
    };
    if (found.wrong && finding.proof != Proof::refuted) {
      finding.proof = Proof::refuted;
      place(*found.wrong);
    } else if (found.undecided && finding.proof != Proof::refuted) {
      const bool first = finding.proof == Proof::proved;
      finding.proof = Proof::undecided;
      if (first || found.undecided->upper() - found.undecided->lower() > finding.to - finding.from)
        place(*found.undecided);
    }
  }

  PassivityFinding of_store(ElementId id, const Element& element) {
    PassivityFinding finding;
    finding.element = element.name;
    if (is_modulated(element)) {
      finding.reason = "its energy depends on signals, which may add to it";
      return finding;
    }
    if (element.energy.valid()) {
      const Range energy = ranges_.of(element.energy);
      if (!is_empty(energy) && energy.lower() > -kInfinity) {
        finding.proof = Proof::proved;
        finding.reason = "its energy is at least " + number_text(energy.lower(), 6);
        return finding;
      }
    }
    const std::vector<Law> laws = port_laws(model_, ranges_.pool(), id);
    if (laws.size() != 1 || laws.front().zero) {
      finding.reason = laws.size() != 1 ? "the energy of a field with several ports is not decided"
                                        : "its law is not solved for a variable";
      return finding;
    }
    const Law& law = laws.front();
    const Variable held = stores_displacement(element, 0) ? Variable::displacement : Variable::momentum;
    const Variable conjugate = held == Variable::momentum ? Variable::flow : Variable::effort;
    const bool by_held = law.variable == conjugate;
    const Variable own = by_held ? held : conjugate;
    const SymbolId symbol = port_variable(element, 0, own);
    if (!by_held) {
      // q = q(e) with e q >= 0: on the way to any q the energy does not fall below that at 0.
      same_sign(law.right, symbol, own, finding);
    } else {
      // The energy is an integral of the law from 0: bounded below where, outward, the law turns to the sign of what is
      // held, and is finite until then.
      finding.proof = Proof::proved;
      for (const double side : {1.0, -1.0}) {
        const Searched found = search_magnitudes([&](const Range& part) {
          const Range y = ranges_.of(law.right, symbol, part * Range(side, side)) * Range(side, side);
          const bool finite = !is_empty(y) && y.lower() > -kInfinity && y.upper() < kInfinity;
          constexpr double kFar = 1e100;  // a sign beyond this is asked for
          if (finite && part.upper() <= kFar) return 1;
          if (!is_empty(y) && y.lower() >= 0.0 && (finite || part.lower() >= kFar)) return 1;
          return 0;
        });
        take(found, side, own, finding);
      }
    }
    // A law that draws outwards need not do so for ever, nor without end: that is no counterexample.
    if (finding.proof == Proof::refuted) finding.proof = Proof::undecided;
    finding.reason = finding.proof == Proof::proved ? "its energy is bounded below"
                                                    : "not decided whether its energy has a lower bound";
    return finding;
  }

  /// Whether it depends on more than what the element holds, whatever its kind may depend on.
  [[nodiscard]] bool is_modulated(const Element& element) {
    std::vector<ExprId> roots;
    if (element.coefficient.valid()) roots.push_back(element.coefficient);
    if (element.energy.valid()) roots.push_back(element.energy);
    for (const Law& law : element.laws) roots.push_back(law.right);
    for (const ExprId root : roots) {
      bool foreign = false;
      std::unordered_map<std::uint32_t, bool> known;
      arguments_first(
          ranges_.pool(), root, [&](ExprId id) { return known.contains(id.value); },
          [&](ExprId id) {
            known.emplace(id.value, true);
            if (ranges_.pool()[id].op != Op::symbol) return;
            const ModelSymbol& what = model_.symbols[ranges_.pool().symbol_of(id).index()];
            const bool own =
                what.kind == ModelSymbol::Kind::port_variable && &model_.elements[what.element.index()] == &element;
            foreign |= !own && what.kind != ModelSymbol::Kind::parameter;
          });
      if (foreign) return true;
    }
    return false;
  }

  /// A contact whose gap stands does no work. An impact takes energy if nothing rebounds, or if no other contact is
  /// hit in the same instant: with several at once Newton's restitution may give some.
  PassivityFinding of_contact(const Element& element) {
    PassivityFinding finding;
    finding.element = element.name;
    const auto within = [&](ExprId value, double most) {
      const Range range = value.valid() ? ranges_.of(value) : Range(0.0, 0.0);
      return !is_empty(range) && range.lower() >= 0.0 && range.upper() <= most;
    };
    const auto contacts = std::count_if(model_.elements.begin(), model_.elements.end(),
                                        [](const Element& each) { return each.contact.has_value(); });
    if (!within(element.contact->speed, 0.0))
      finding.reason = "its gap moves, and may do work";
    else if (!within(element.contact->restitution, contacts == 1 ? 1.0 : 0.0))
      finding.reason = "impacts on several contacts that rebound may add energy";
    else
      finding.proof = Proof::proved;
    if (finding.proof == Proof::proved) finding.reason = "its gap stands, and impacts take energy";
    return finding;
  }

  PassivityFinding of_diode(const Element& element) {
    PassivityFinding finding;
    finding.element = element.name;
    const Range threshold = element.coefficient.valid() ? ranges_.of(element.coefficient) : Range(0.0, 0.0);
    if (!is_empty(threshold) && threshold.lower() >= 0.0) {
      finding.proof = Proof::proved;
      finding.reason = "e f >= 0";
    } else {
      finding.proof = !is_empty(threshold) && threshold.upper() < 0.0 ? Proof::refuted : Proof::undecided;
      finding.reason = "a negative threshold gives power while it passes";
    }
    return finding;
  }

  const Model& model_;
  Ranges ranges_;
};

}  // namespace

bool Passivity::holds() const {
  const auto proved = [](const std::vector<PassivityFinding>& all) {
    return std::all_of(all.begin(), all.end(), [](const PassivityFinding& f) { return f.proof == Proof::proved; });
  };
  return driven.empty() && proved(resistors) && proved(stores) && proved(others);
}

Passivity passivity(const Model& model, const RunInputs& inputs) { return Judging(model, inputs).run(); }

}  // namespace bgsim

// What contradicting units say in words.
//
// One mistake makes many equations fail. Contradictions that rest on one equation are therefore reported together: if
// it is a unit that the model gives, that unit is named with the evidence against it; else the first of them is
// reported.
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "base/codes.hpp"
#include "base/text.hpp"
#include "bgsim/text.hpp"
#include "expression/graph.hpp"
#include "model/element_kinds.hpp"
#include "units/equations.hpp"

namespace bgsim {

namespace {

constexpr std::size_t kMostNotes = 6;
constexpr std::size_t kMostOperands = 8;
constexpr std::size_t kMostTrials = 5;  ///< units left out to see whether they are the cause; each solves all again
constexpr std::size_t kLongestText = 72;
constexpr const char* kEqualUnits =
    "the sides of an equation, and terms that are added or compared, have one unit; numbers are used as they are "
    "written";
constexpr const char* kPureNumbers =
    "only powers, roots and abs, min, max, hypot, mod, ssqrt take quantities with a unit";

/// "Pa/bar", "(m/s)/(km/h)".
std::string quotient_text(const std::string& above, const std::string& below) {
  const auto wrapped = [](const std::string& text) {
    return text.find_first_of(" /") == std::string::npos ? text : "(" + text + ")";
  };
  return wrapped(above) + "/" + wrapped(below);
}

/// The equations in words. Units have the model's own names.
class UnitWords {
 public:
  UnitWords(const Model& model, const BondGraph& graph, const UnitEquations& all, const UnitName& name)
      : model_(model), graph_(graph), all_(all), name_(name) {}

  /// An equation that does not hold. A side whose unit is unknown is in "one unit" or "another".
  [[nodiscard]] std::string disagreement(const UnitEquation& e, const std::optional<Unit>& left_unit,
                                         const std::optional<Unit>& right_unit) const {
    const std::string& own_text = given_text(e);
    const std::string left = !own_text.empty() ? " is in " + own_text : left_unit ? is(left_unit) : " is in one unit";
    const std::string right = right_unit ? is(right_unit) : " is in another";
    switch (e.kind) {
      case UnitEquation::Kind::given:  // these come first: contradictions to them are reported
        return support(e, left_unit);
      case UnitEquation::Kind::value: {
        const bool own = e.site.kind == UnitSite::Kind::parameter || e.site.kind == UnitSite::Kind::signal;
        const bool inside = e.site.kind == UnitSite::Kind::law || e.site.kind == UnitSite::Kind::initial;
        return (inside ? "in " + site(e.site) + ", " : std::string()) + e.name + left + ", but " +
               (own ? "its value " : "") + text(e.right) + right;
      }
      case UnitEquation::Kind::quotient:
        return site(e.site) + ", " + text(e.right) + "," + right + ", but its " + e.name + left;
      case UnitEquation::Kind::energy:
        return site(e.site) + right + ", but " + at_port(e) + left;
      case UnitEquation::Kind::one_energy:
        return "an energy at port " + element(e).ports.front() + " of " + in_quotes(element(e).name) + left +
               ", but at port " + element(e).ports[e.site.port] + right;
      case UnitEquation::Kind::same_power:
        return "the power at port 1 of " + in_quotes(element(e).name) + left + ", but at port 2" + right;
      case UnitEquation::Kind::sum:
        return "in " + site(e.site) + ", " + text(e.left) + left + " and " + text(e.right) + right + ", but " +
               together(e.operation);
      case UnitEquation::Kind::pure:
        return "in " + site(e.site) + ", " + argument(e) + right + ", but must be a pure number";
      case UnitEquation::Kind::abscissa:
        return "in " + site(e.site) + ", " + in_quotes(e.name) + " is read at " + text(e.right) + ", which" + right +
               ", but its first column" + left;
    }
    return {};
  }

  /// An equation that another one rests on.
  [[nodiscard]] std::string support(const UnitEquation& e, const std::optional<Unit>& unit) const {
    const std::string& own_text = given_text(e);
    const std::string in = !own_text.empty() ? ", in " + own_text : unit ? ", " + in_unit(*unit) : std::string();
    switch (e.kind) {
      case UnitEquation::Kind::given:
        return (e.site.kind == UnitSite::Kind::parameter ? "parameter " : "signal ") + in_quotes(given_name(e)) +
               " is in " + given_text(e);
      case UnitEquation::Kind::value:
        return (e.site.kind == UnitSite::Kind::law ? "by " + site(e.site) + ", " : std::string()) + e.name + " is " +
               text(e.right) + in;
      case UnitEquation::Kind::quotient:
        if (e.name == "effort" || e.name == "flow") return site(e.site) + " is " + text(e.right) + in;
        return site(e.site) + " is " + text(e.right) + ": " + e.name + in;
      case UnitEquation::Kind::energy:
        return at_port(e) + " is part of its energy" + in;
      case UnitEquation::Kind::one_energy:
        return "the ports of " + in_quotes(element(e).name) + " store one kind of energy" + in;
      case UnitEquation::Kind::same_power:
        return in_quotes(element(e).name) + " passes power on" + in;
      case UnitEquation::Kind::sum:
        return "in " + site(e.site) + ", " + text(e.left) + " and " + text(e.right) + " are alike" + in + ": " +
               together(e.operation);
      case UnitEquation::Kind::pure:
        return "in " + site(e.site) + ", " + argument(e) + " is a pure number";
      case UnitEquation::Kind::abscissa:
        return "in " + site(e.site) + ", " + in_quotes(e.name) + " is read at " + text(e.right) + in;
    }
    return {};
  }

  /// "A in m^2, k in N/m": the units of the names in an equation, as far as they are known.
  [[nodiscard]] std::string operands(const UnitEquation& e) const {
    std::string result;
    std::size_t listed = 0;
    for (const SymbolId symbol : symbols_of(e)) {
      const auto unit = all_.system.value(unit_form(model_, graph_, all_, symbol));
      if (!unit || symbol == model_.time) continue;
      if (listed++ == kMostOperands) return result + ", ...";
      result += (result.empty() ? "" : ", ") + symbol_name(model_, symbol) + " " + in_unit(*unit);
    }
    return result;
  }
  [[nodiscard]] std::vector<SymbolId> symbols_of(const UnitEquation& e) const {
    std::vector<ExprId> roots;
    for (const ExprId root : {e.left, e.right})
      if (root.valid()) roots.push_back(root);
    return symbols_in(model_.pool, roots);
  }

  /// " is in N m", " is a pure number".
  [[nodiscard]] std::string is(const std::optional<Unit>& unit) const {
    if (!unit) return " is in a unit that is not known";
    return is_pure_number(*unit) ? std::string(" is a pure number") : " is in " + name_(*unit);
  }
  [[nodiscard]] std::string name(const Unit& unit) const { return name_(unit); }

 private:
  [[nodiscard]] std::string in_unit(const Unit& unit) const {
    return is_pure_number(unit) ? std::string("a pure number") : "in " + name_(unit);
  }
  [[nodiscard]] const std::string& given_name(const UnitEquation& e) const {
    return e.site.kind == UnitSite::Kind::parameter ? model_.parameters[e.site.index].name
                                                    : model_.signals[e.site.index].name;
  }
  /// The unit of an equation's left side as the model gives it, or empty.
  [[nodiscard]] const std::string& given_text(const UnitEquation& e) const {
    static const std::string kNone;
    if (e.kind == UnitEquation::Kind::given)
      return e.site.kind == UnitSite::Kind::parameter ? model_.parameters[e.site.index].unit
                                                      : model_.signals[e.site.index].unit;
    const bool output = e.kind == UnitEquation::Kind::value && e.site.kind == UnitSite::Kind::output;
    return output && e.left_form.terms.empty() ? model_.outputs[e.site.index].unit : kNone;  // else a part of it
  }
  [[nodiscard]] std::string text(ExprId expression) const {
    std::string result =
        readable_text(model_.pool, expression, [this](SymbolId symbol) { return symbol_name(model_, symbol); });
    if (result.size() > kLongestText) result = result.substr(0, kLongestText - 4) + " ...";
    return result;
  }
  [[nodiscard]] const Element& element(const UnitEquation& e) const { return model_.elements[e.site.index]; }
  [[nodiscard]] std::string at_port(const UnitEquation& e) const {
    const Element& field = element(e);
    return std::string(stores_displacement(field, e.site.port) ? "effort times displacement" : "flow times momentum") +
           " at port " + field.ports[e.site.port] + " of " + in_quotes(field.name);
  }
  [[nodiscard]] std::string argument(const UnitEquation& e) const {
    if (e.operation != Op::pow) return "the argument " + text(e.right) + " of " + std::string(name_of(e.operation));
    return text(e.right) + " (an exponent, or with one that varies)";
  }
  [[nodiscard]] std::string site(const UnitSite& s) const {
    switch (s.kind) {
      case UnitSite::Kind::parameter:
        return "parameter " + in_quotes(model_.parameters[s.index].name);
      case UnitSite::Kind::signal:
        return "signal " + in_quotes(model_.signals[s.index].name);
      case UnitSite::Kind::output:
        return "output " + in_quotes(model_.outputs[s.index].name);
      case UnitSite::Kind::element:
        return "the " + coefficient_words(model_.elements[s.index]) + " of " + in_quotes(model_.elements[s.index].name);
      case UnitSite::Kind::law:
        return "the law of " + in_quotes(port_name(model_.elements[s.index], s.port));
      case UnitSite::Kind::energy:
        return "the energy of " + in_quotes(model_.elements[s.index].name);
      case UnitSite::Kind::initial:
        return "the initial value of " + in_quotes(model_.elements[s.index].name);
      case UnitSite::Kind::event:
        return "the event " + in_quotes(model_.events[s.index].name);
      case UnitSite::Kind::scene:
        return "the scene";
    }
    return {};
  }
  static std::string together(Op op) {
    switch (op) {
      case Op::add:
        return "they are added";
      case Op::sub:
        return "one is subtracted from the other";
      case Op::select:
        return "they are alternatives of one if";
      case Op::min:
      case Op::max:
      case Op::hypot:
      case Op::atan2:
      case Op::ssqrt:
      case Op::mod:
        return "they are arguments of one " + std::string(name_of(op));
      default:
        return "they are compared";
    }
  }

  const Model& model_;
  const BondGraph& graph_;
  const UnitEquations& all_;
  const UnitName& name_;
};

class UnitMessages {
 public:
  UnitMessages(const Model& model, const BondGraph& graph, const UnitEquations& all, const UnitName& name,
               const TryWithout& try_without)
      : model_(model), all_(all), words_(model, graph, all, name), try_without_(try_without) {}

  std::vector<Diagnostic> messages() {
    std::vector<std::size_t> open(all_.system.contradictions().size());
    for (std::size_t i = 0; i < open.size(); ++i) open[i] = i;
    while (!open.empty()) {
      const auto counts = count_written(open);
      std::optional<std::uint32_t> suspect = blamed(open, counts);
      if (suspect) {
        tell_given(*suspect, split(open, *suspect));
        continue;
      }
      suspect = most_common(counts);
      if (!suspect) break;
      const std::vector<std::size_t> explained = split(open, *suspect);
      tell(contradiction(explained.front()), explained.size() - 1);
      for (const std::size_t i : explained) remember(contradiction(i));
    }
    for (const std::size_t i : open) tell(contradiction(i), 0);
    return std::move(diagnostics_);
  }

 private:
  [[nodiscard]] const UnitEquation& equation(std::uint32_t number) const { return all_.equations[number]; }
  [[nodiscard]] bool is_given(std::uint32_t number) const { return equation(number).kind == UnitEquation::Kind::given; }
  /// One number for all instances of a submodel's equation: they are written in one place.
  std::uint32_t written(std::uint32_t number) {
    const UnitEquation& e = equation(number);
    const std::array<std::uint32_t, 4> key{e.place.document.value, e.place.begin, e.place.end,
                                           static_cast<std::uint32_t>(e.kind)};
    return written_.try_emplace(key, number).first->second;
  }
  bool rests_on(const UnitContradiction& c, std::uint32_t suspect) {
    return std::any_of(c.equations.begin(), c.equations.end(), [&](std::uint32_t n) { return written(n) == suspect; });
  }

  [[nodiscard]] const UnitContradiction& contradiction(std::size_t i) const { return all_.system.contradictions()[i]; }

  /// Takes those that rest on @p suspect out of @p open.
  std::vector<std::size_t> split(std::vector<std::size_t>& open, std::uint32_t suspect) {
    const auto rest = std::stable_partition(open.begin(), open.end(),
                                            [&](std::size_t i) { return !rests_on(contradiction(i), suspect); });
    std::vector<std::size_t> explained(rest, open.end());
    open.erase(rest, open.end());
    return explained;
  }

  using Counts = std::map<std::uint32_t, std::size_t>;
  /// How many contradictions rest on each equation.
  Counts count_written(const std::vector<std::size_t>& open) {
    Counts counts;
    for (const std::size_t i : open) {
      std::set<std::uint32_t> once;
      for (const std::uint32_t number : contradiction(i).equations) once.insert(written(number));
      for (const std::uint32_t number : once) ++counts[number];
    }
    return counts;
  }

  /// The one unit that the model gives without which several contradictions would be none; none if there are two.
  std::optional<std::uint32_t> blamed(const std::vector<std::size_t>& open, const Counts& counts) {
    std::vector<std::pair<std::size_t, std::uint32_t>> suspects;
    for (const auto& [number, count] : counts)
      if (count > 1 && is_given(number)) suspects.emplace_back(count, number);
    std::stable_sort(suspects.begin(), suspects.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
    if (suspects.size() > kMostTrials) suspects.resize(kMostTrials);
    std::optional<std::uint32_t> found;
    for (const auto& [count, number] : suspects) {
      const auto explained = static_cast<std::size_t>(std::count_if(
          open.begin(), open.end(), [&, n = number](std::size_t i) { return rests_on(contradiction(i), n); }));
      const UnitTrial trial = try_without_(equation(number));
      if (trial.contradictions + explained > all_.system.contradictions().size()) continue;
      if (found) return std::nullopt;
      found = number;
      instead_ = trial.unit;
    }
    return found;
  }

  /// The equation that most contradictions rest on, if more than one do.
  std::optional<std::uint32_t> most_common(const Counts& counts) {
    std::size_t most = 1;
    std::optional<std::uint32_t> found;
    for (const auto& [number, count] : counts)
      if (count > most && !is_given(number)) most = count, found = number;
    return found;
  }

  void remember(const UnitContradiction& c) {
    for (const std::uint32_t number : c.equations)
      if (!is_given(number)) told_.insert(number);
  }
  /// Whether it rests on an equation that has been reported.
  [[nodiscard]] bool follows(const UnitContradiction& c) const {
    return std::any_of(c.equations.begin(), c.equations.end(), [&](std::uint32_t n) { return told_.contains(n); });
  }

  struct Sides {
    std::optional<Unit> left, right;
  };
  [[nodiscard]] Sides sides(std::uint32_t number) const {
    const UnitEquation& e = equation(number);
    const auto left = all_.system.value(e.left_form);
    const auto quotient = all_.system.value(all_.system.form(number));
    if (!left || !quotient) return {left, std::nullopt};
    return {left, *left / *quotient};
  }
  [[nodiscard]] std::string situation(std::uint32_t number) const {
    const Sides s = sides(number);
    return words_.disagreement(equation(number), s.left, s.right);
  }

  /// The equation at which a contradiction shows. Where it shows in a combination of several, the last one whose sides
  /// differ, or the last of all where none of them does by itself.
  [[nodiscard]] std::uint32_t shown(const UnitContradiction& c) const {
    if (c.equation < all_.equations.size()) return c.equation;
    std::optional<std::uint32_t> last, differs;
    for (const std::uint32_t number : c.equations) {
      if (is_given(number)) continue;
      last = std::max(last.value_or(number), number);
      const Sides s = sides(number);
      if (s.left && s.right && !same_unit(*s.left, *s.right)) differs = std::max(differs.value_or(number), number);
    }
    return differs ? *differs : last.value_or(c.equations.front());
  }

  void tell(const UnitContradiction& c, std::size_t further) {
    if (follows(c)) return;
    const std::uint32_t number = shown(c);
    const UnitEquation& e = equation(number);
    const Sides s = sides(number);
    const bool one_dimension = s.left && s.right && same_dimension(*s.left, *s.right);
    Diagnostic d = diagnostic_of(one_dimension ? "BG162" : "BG161", situation(number), e.place,
                                 e.kind == UnitEquation::Kind::pure ? kPureNumbers : kEqualUnits);
    d.help = help(e, s);
    add_supports(d, c, number);
    if (further > 0)
      d.notes.push_back({std::nullopt, std::to_string(further) +
                                           (further == 1 ? " more contradiction rests" : " more contradictions rest") +
                                           " on the same"});
    remember(c);
    emit(std::move(d));
  }

  /// What an equation's two sides rest on: the units of the names in it, then each equation that gave them. Units that
  /// the model gives and that are in these lists need no place of their own.
  void add_supports(Diagnostic& d, const UnitContradiction& c, std::uint32_t number) const {
    std::set<SymbolId> listed;
    const auto list = [&](const UnitEquation& e) {
      for (const SymbolId symbol : words_.symbols_of(e)) listed.insert(symbol);
      return words_.operands(e);
    };
    const UnitEquation& failed = equation(number);
    const std::string operands = list(failed);
    if (!operands.empty() && (failed.left.valid() || !model_.pool.is_symbol(failed.right)))
      d.notes.push_back({std::nullopt, "with " + operands});
    std::size_t left_out = 0;
    for (const std::uint32_t other : c.equations) {
      const UnitEquation& e = equation(other);
      if (other == number || is_given(other)) continue;
      const std::string names = list(e);
      const bool plain = names.empty() || (e.right.valid() && model_.pool.is_symbol(e.right));
      std::string support = words_.support(e, sides(other).left);
      if (!plain) support.append(" (").append(names).append(")");
      if (!add_note(d, std::move(support), e.place)) ++left_out;
    }
    for (const std::uint32_t other : c.equations)
      if (is_given(other) && !listed.contains(given_symbol(equation(other))) &&
          !add_note(d, words_.support(equation(other), sides(other).left), equation(other).place))
        ++left_out;
    if (left_out > 0)
      d.notes.push_back({std::nullopt, "and " + std::to_string(left_out) + " more, which these rest on"});
  }
  [[nodiscard]] SymbolId given_symbol(const UnitEquation& e) const {
    return e.site.kind == UnitSite::Kind::parameter ? model_.parameters[e.site.index].symbol
                                                    : model_.signals[e.site.index].symbol;
  }

  /// One unit that the model gives, against all that speaks against it.
  void tell_given(std::uint32_t suspect, const std::vector<std::size_t>& against) {
    const UnitEquation& e = equation(suspect);
    Diagnostic d = diagnostic_of("BG162", {}, e.place, kEqualUnits);
    std::size_t left_out = 0;
    std::set<std::uint32_t> noted;
    for (const std::size_t i : against) {
      const std::uint32_t number = shown(all_.system.contradictions()[i]);
      const Sides s = sides(number);
      if (!s.left || !s.right || !same_dimension(*s.left, *s.right)) d.code = "BG161";
      if (noted.insert(written(number)).second && !add_note(d, situation(number), equation(number).place)) ++left_out;
    }
    d.situation = words_.support(e, sides(suspect).left) + ", which " +
                  (noted.size() == 1 ? std::string("an equation contradicts")
                                     : std::to_string(noted.size()) + " equations contradict");
    if (left_out > 0) d.notes.push_back({std::nullopt, "and " + std::to_string(left_out) + " more"});
    d.help =
        instead_ ? "all of them hold if it is" + words_.is(instead_).substr(3) : "all of them hold without this unit";
    if (instead_ && same_dimension(*instead_, *sides(suspect).left))
      d.help += "; conversions are explicit, as " + conversion(*instead_, *sides(suspect).left);
    emit(std::move(d));
  }

  /// @return false if there are enough notes.
  static bool add_note(Diagnostic& d, std::string text, const Place& place) {
    if (d.notes.size() >= kMostNotes) return false;
    d.notes.push_back({place, std::move(text)});
    return true;
  }

  void emit(Diagnostic d) {
    if (d.place && !places_.insert({d.place->document.value, d.place->begin, d.place->end}).second) return;
    diagnostics_.push_back(std::move(d));
  }

  /// "a parameter { "value": 100000, "unit": "Pa/bar" }"
  [[nodiscard]] std::string conversion(const Unit& to, const Unit& from) const {
    return "a parameter { \"value\": " + number_text(std::exp(from.log_scale - to.log_scale), 6) + ", \"unit\": \"" +
           quotient_text(words_.name(to), words_.name(from)) + "\" }";
  }

  [[nodiscard]] std::string help(const UnitEquation& e, const Sides& s) const {
    if (!s.left || !s.right) return "the notes cannot all hold: look for the one that is not meant so";
    const Unit ratio = *s.left / *s.right;
    const std::string right = words_.name(*s.right);
    if (same_dimension(*s.left, *s.right)) {
      const bool sides_are_written = e.kind == UnitEquation::Kind::value || e.kind == UnitEquation::Kind::sum;
      if (sides_are_written)
        return "conversions are explicit: multiply what is in " + right + " by " + conversion(*s.left, *s.right);
      return "they differ by the factor " + number_text(std::exp(std::abs(ratio.log_scale)), 6) +
             ": somewhere among the notes a unit is not meant so; conversions are explicit, as a parameter "
             "{ \"value\": 100000, \"unit\": \"Pa/bar\" }";
    }
    if (e.kind == UnitEquation::Kind::pure) return "divide by a quantity in " + right;
    std::string text = "the two differ by the factor " + unit_text(ratio);
    const Unit molar = *parse_unit("kg/mol").unit;
    if (same_dimension(ratio, molar) || same_dimension(ratio, power(molar, -1.0)))
      return text + ", a molar mass: a molar quantity is used instead of a specific one, or the reverse";
    if (same_dimension(ratio, second()) || same_dimension(ratio, power(second(), -1.0)))
      return text + ": a rate is used instead of an amount, or the reverse";
    if (const auto number = factor(e.right))
      return text + "; beside quantities a number is a pure number: if " + number_text(*number, 6) +
             " represents a quantity, make it a parameter in " + unit_text(ratio);
    return text;
  }

  /// A number that an expression is multiplied by, or that is divided.
  [[nodiscard]] std::optional<double> factor(ExprId expression) const {
    const ExprPool& pool = model_.pool;
    while (expression.valid()) {
      const ExprNode& node = pool[expression];
      if (node.op != Op::mul && node.op != Op::div && node.op != Op::neg) return std::nullopt;
      if (pool.is_constant(ExprId(node.a))) return pool[ExprId(node.a)].constant;
      expression = ExprId(node.a);
    }
    return std::nullopt;
  }

  const Model& model_;
  const UnitEquations& all_;
  UnitWords words_;
  const TryWithout& try_without_;
  std::optional<Unit> instead_;  ///< the unit that would fit, of the one that is blamed
  std::set<std::uint32_t> told_;
  std::map<std::array<std::uint32_t, 4>, std::uint32_t> written_;
  std::set<std::array<std::uint32_t, 3>> places_;
  std::vector<Diagnostic> diagnostics_;
};

}  // namespace

Diagnostic no_power(const Model& model, const BondGraph& graph, const UnitEquations& equations, const UnitName& name,
                    std::uint32_t region) {
  const UnitWords words(model, graph, equations, name);
  const UnitSystem& system = equations.system;
  const Unit effort = *system.value(2 * region), flow = *system.value(2 * region + 1);
  const auto bond =
      static_cast<std::size_t>(std::find(equations.regions.of_bond.begin(), equations.regions.of_bond.end(), region) -
                               equations.regions.of_bond.begin());
  Diagnostic d = diagnostic_of("BG163");
  d.situation = "bond \"" + model.bonds[bond].name + "\" and those it shares a junction with have efforts in " +
                name(effort) + " and flows in " + name(flow) + ": their product, in " + name(effort * flow) +
                ", is not a power";
  d.place = model.bonds[bond].place;
  std::set<std::uint32_t> noted;
  for (const std::uint32_t variable : {2 * region, 2 * region + 1})
    for (const std::uint32_t number : system.reasons(variable)) {
      const UnitEquation& e = equations.equations[number];
      if (d.notes.size() < kMostNotes && noted.insert(number).second)
        d.notes.push_back({e.place, words.support(e, system.value(e.left_form))});
    }
  d.rule = "effort times flow is a power, in W; pseudo bond graphs have flows of heat, mass or matter instead";
  d.help = "with these efforts, flows would be in " + name(watt() / effort) + "; with these flows, efforts in " +
           name(watt() / flow);
  return d;
}

std::vector<Diagnostic> unit_diagnostics(const Model& model, const BondGraph& graph, const UnitEquations& equations,
                                         const UnitName& name, const TryWithout& try_without) {
  return UnitMessages(model, graph, equations, name, try_without).messages();
}

}  // namespace bgsim

#include "linear/partials.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <unordered_map>

#include "base/codes.hpp"
#include "bgsim/text.hpp"
#include "expression/graph.hpp"
#include "expression/right_limit.hpp"

namespace bgsim {
namespace {

constexpr double kEps = std::numeric_limits<double>::epsilon();
/// Slopes that differ by less are one: both sides of a border are computed by different operations.
constexpr double kSame = 1e-9;
/// A slope that changes by more within what the point is uncertain by is not known.
constexpr double kKnown = 1e-3;
/// So many times as far off slopes are looked at again.
constexpr double kFar = 1e4;

[[noreturn]] void fail(const Model& model, const char* code, std::string situation, std::string help,
                       std::optional<Place> place = {}, std::string rule = {}) {
  throw ModelError({diagnostic_of(code, std::move(situation), place, std::move(rule), std::move(help))}, model.sources);
}

/// Constant but for steps.
bool decides(const ExprPool& pool, const ExprNode& node) {
  if (node.op == Op::table_slope) return pool.table(TableId(node.b)).interpolation == Interpolation::linear;
  return is_comparison(node.op) || node.op == Op::sign || node.op == Op::step || is_rounding(node.op) ||
         node.op == Op::mod;
}

/// Values of expressions at one point, with decisions forced where that is asked for.
class PointValues {
 public:
  PointValues(ExprPool& pool, SymbolId time, std::vector<double> symbols, std::vector<char> moves)
      : pool_(pool), time_(time), symbols_(std::move(symbols)), moves_(std::move(moves)), later_(symbols_) {
    later_[time.index()] = std::nextafter(symbols_[time.index()], std::numeric_limits<double>::infinity());
  }

  double operator()(ExprId root) {
    if (known_.size() < pool_.size()) {
      known_.resize(pool_.size(), 0);
      value_.resize(pool_.size());
      moving_.resize(pool_.size(), 0);
    }
    arguments_first(
        pool_, root, [this](ExprId e) { return known_[e.index()] != 0; }, [this](ExprId e) { compute(e); });
    return value_[root.index()];
  }
  [[nodiscard]] bool moving(ExprId e) const { return moving_[e.index()] != 0; }
  void force(ExprId decision, double value) {
    forced_ = {decision, value};
    forget();
  }
  void release() {
    forced_.reset();
    forget();
  }
  void move(SymbolId symbol, double value) {
    symbols_[symbol.index()] = later_[symbol.index()] = value;
    forget();
  }
  [[nodiscard]] double symbol(SymbolId symbol) const { return symbols_[symbol.index()]; }

 private:
  void forget() { std::fill(known_.begin(), known_.end(), 0); }

  void compute(ExprId e) {
    const ExprNode& node = pool_[e];
    double& result = value_[e.index()];
    char& moving = moving_[e.index()];
    moving = 0;
    for_each_argument(node, [&](ExprId a) { moving |= moving_[a.index()]; });
    const auto value = [this](std::uint32_t child) { return value_[child]; };
    if (forced_ && forced_->first == e) {
      result = forced_->second;
    } else if (node.op == Op::constant) {
      result = node.constant;
    } else if (node.op == Op::symbol) {
      result = symbols_[node.a];
      moving = moves_[node.a];
    } else if (decides(pool_, node) && moving == 0) {
      // Of time alone: as just after it.
      const auto limit = right_limit(pool_, e, time_, symbols_, symbols_[time_.index()]);
      result = limit ? limit->value : evaluate(pool_, e, later_);
    } else if (is_table(node.op)) {
      result = apply_table(node.op, pool_.table(TableId(node.b)), value(node.a));
    } else {
      const int n = arity(node.op);
      result = apply(node.op, value(node.a), n > 1 ? value(node.b) : 0.0, n > 2 ? value(node.c) : 0.0);
    }
    known_[e.index()] = 1;
  }

  ExprPool& pool_;
  SymbolId time_;
  std::vector<double> symbols_;
  std::vector<char> moves_;  ///< by symbol: a state or a loop's variable
  std::vector<double> later_;
  std::vector<char> known_, moving_;
  std::vector<double> value_;
  std::optional<std::pair<ExprId, double>> forced_;
};

/// What is differentiated.
struct Root {
  ExprId value;
  std::string name;  ///< "the rate of tank.q"
  std::optional<Place> place;
};

struct Slope {
  std::uint32_t root = 0, column = 0;
  ExprId partial;
};

class PartialsAt {
 public:
  PartialsAt(const Model& model, const EquationSystem& system, const BlockOrder& order, const LinearizationPoint& point,
             std::span<const double> tears)
      : model_(model), system_(system), order_(order), point_(point), pool_(order.pool) {
    std::vector<double> values(system.symbols.size(), std::numeric_limits<double>::quiet_NaN());
    std::vector<char> moves(system.symbols.size(), 0);
    values[system.time.index()] = point.t;
    for (std::size_t i = 0; i < point.parameters.size(); ++i)
      values[system.parameters[i].index()] = point.parameters[i];
    const auto column = [&](SymbolId symbol, double value) {
      values[symbol.index()] = value;
      moves[symbol.index()] = 1;
      column_[symbol] = static_cast<std::uint32_t>(columns_.size());
      columns_.push_back(symbol);
    };
    for (std::size_t i = 0; i < system.states.size(); ++i) {
      column(system.states[i].symbol, point.x[i]);
      roots_.push_back(
          {order.rates[i], "the rate of " + short_name(system.states[i].name), place_of(model, system.states[i])});
    }
    std::size_t tear = 0;
    double relative = 1e-12;  // to which the loops are solved, at least
    for (std::size_t i = 0; i < point.errors.size(); ++i)
      if (point.x[i] != 0.0) relative = std::max(relative, std::min(1.0, point.errors[i] / std::abs(point.x[i])));
    errors_.assign(point.errors.begin(), point.errors.end());
    errors_.resize(system.states.size(), 0.0);
    for (const Block& block : order.blocks) {
      for (const SymbolId symbol : block.tears) {
        errors_.push_back(relative * std::abs(tears[tear]));
        column(symbol, tears[tear++]);
      }
      std::string through;
      for (std::size_t i = 0; i < block.elements.size() && i < 4; ++i)
        through += (i > 0 ? ", " : " through ") + short_name(model.elements[block.elements[i].index()].name);
      for (const ExprId residual : block.residuals) roots_.push_back({residual, "the loop" + through, {}});
    }
    for (std::size_t i = 0; i < order.outputs.size(); ++i)
      roots_.push_back({order.outputs[i], "the output " + short_name(system.outputs[i].name), model.outputs[i].place});
    values_.emplace(pool_, system.time, std::move(values), std::move(moves));
    for (std::uint32_t r = 0; r < roots_.size(); ++r)
      for (const auto& [symbol, partial] : gradient_of(roots_[r].value))
        slopes_.push_back({r, column_.at(symbol), partial});
  }

  void check_finite() {
    for (const Root& root : roots_)
      if (!std::isfinite((*values_)(root.value)))
        fail(model_, "BG407", "the system cannot be linearized here: " + root.name + " has no finite value",
             "choose a point at which every law has a value", root.place);
    for (const Slope& slope : slopes_)
      if (!std::isfinite((*values_)(slope.partial))) fail_steep(slope);
  }

  void check_edges() {
    const std::vector<double> roots = root_values(), slopes = slope_values();
    const std::vector<double> magnitude = row_magnitudes(slopes);
    for (const ExprId decision : decisions()) {
      const auto sides = sides_of(decision);
      if (!sides) continue;
      for (const double side : {sides->first, sides->second}) {
        values_->force(decision, side);
        const std::vector<double> other_roots = root_values(), other_slopes = slope_values();
        values_->release();
        compare(decision, roots, other_roots, slopes, other_slopes, magnitude);
      }
    }
    check_certain(slopes, magnitude);
  }

  [[nodiscard]] PointPartials result(std::size_t loops) {
    PointPartials made;
    const auto n = static_cast<std::uint32_t>(system_.states.size());
    const auto m = static_cast<std::uint32_t>(loops);
    const auto columns = columns_.size();
    made.rates = {n, columns, {}};
    made.loops = {m, columns, {}};
    made.outputs = {roots_.size() - n - m, columns, {}};
    for (const Slope& slope : slopes_) {
      const double value = (*values_)(slope.partial);
      if (value == 0.0) continue;
      LinearMatrix& to = slope.root < n ? made.rates : slope.root < n + m ? made.loops : made.outputs;
      const std::uint32_t first = slope.root < n ? 0 : slope.root < n + m ? n : n + m;
      to.entries.push_back({slope.root - first, slope.column, value});
    }
    for (LinearMatrix* matrix : {&made.rates, &made.loops, &made.outputs})
      std::sort(matrix->entries.begin(), matrix->entries.end(),
                [](const auto& a, const auto& b) { return a.row != b.row ? a.row < b.row : a.column < b.column; });
    const std::vector<double> values = root_values();
    made.rate.assign(values.begin(), values.begin() + n);
    made.output.assign(values.begin() + n + m, values.end());
    return made;
  }

 private:
  std::vector<std::pair<SymbolId, ExprId>> gradient_of(ExprId root) {
    return gradient(pool_, root, [this](SymbolId s) { return column_.contains(s); });
  }
  std::vector<double> root_values() {
    std::vector<double> values;
    for (const Root& root : roots_) values.push_back((*values_)(root.value));
    return values;
  }
  std::vector<double> slope_values() {
    std::vector<double> values;
    for (const Slope& slope : slopes_) values.push_back((*values_)(slope.partial));
    return values;
  }
  /// Of a column: what a change of it is compared with.
  [[nodiscard]] double scale(std::uint32_t column) const {
    const double value = std::abs(values_->symbol(columns_[column]));
    return value > 0.0 ? value : 1.0;
  }
  [[nodiscard]] std::vector<double> row_magnitudes(const std::vector<double>& slopes) const {
    std::vector<double> magnitude(roots_.size(), 0.0);
    for (std::size_t i = 0; i < slopes_.size(); ++i)
      magnitude[slopes_[i].root] += std::abs(slopes[i]) * scale(slopes_[i].column);
    return magnitude;
  }

  /// Conditions and the like among the values and their slopes that what moves can change.
  std::vector<ExprId> decisions() {
    std::vector<ExprId> all, found;
    for (const Root& root : roots_) all.push_back(root.value);
    for (const Slope& slope : slopes_) all.push_back(slope.partial);
    for (const ExprId e : reachable(pool_, all))
      if (decides(pool_, pool_[e]) && values_->moving(e)) found.push_back(e);
    return found;
  }

  /// Both sides of a decision, if the point may be at its border.
  std::optional<std::pair<double, double>> sides_of(ExprId decision) {
    const ExprNode node = pool_[decision];  // a copy: the pool grows
    const double a = (*values_)(ExprId(node.a));
    const bool two = arity(node.op) > 1;
    const double b = two ? (*values_)(ExprId(node.b)) : 0.0;
    double error = 4.0 * kEps * (std::abs(a) + std::abs(b));
    for (std::uint32_t argument = 0; argument < (two ? 2U : 1U); ++argument)
      for (const auto& [symbol, partial] : gradient_of(ExprId(argument == 0 ? node.a : node.b))) {
        const double moved = std::abs((*values_)(partial)) * errors_[column_.at(symbol)];
        if (std::isfinite(moved)) error += moved;
      }
    error = std::max(error, std::numeric_limits<double>::min());
    const auto at = [&](double first) {
      return node.op == Op::table_slope ? apply_table(node.op, pool_.table(TableId(node.b)), first)
                                        : apply(node.op, first, b);
    };
    const double below = at(a - 2.0 * error), above = at(a + 2.0 * error), here = (*values_)(decision);
    const bool jumps =
        node.op == Op::mod ? std::abs(above - below) > 0.5 * std::abs(b) : !(below == here && above == here);
    if (!jumps) return std::nullopt;
    return std::pair(below, above);
  }

  void compare(ExprId decision, const std::vector<double>& roots, const std::vector<double>& other_roots,
               const std::vector<double>& slopes, const std::vector<double>& other_slopes,
               const std::vector<double>& magnitude) {
    std::vector<double> allowed(roots.size());
    for (std::size_t i = 0; i < roots.size(); ++i) allowed[i] = kSame * std::max(std::abs(roots[i]), magnitude[i]);
    for (std::size_t i = 0; i < slopes_.size(); ++i)
      allowed[slopes_[i].root] += 4.0 * std::abs(slopes[i]) * errors_[slopes_[i].column];
    for (std::size_t i = 0; i < roots.size(); ++i)
      if (!(std::abs(other_roots[i] - roots[i]) <= allowed[i])) fail_edge(decision, roots_[i], "jumps");
    for (std::size_t i = 0; i < slopes_.size(); ++i)
      if (differs(slopes[i], other_slopes[i], kSame, slopes_[i], magnitude))
        fail_edge(decision, roots_[slopes_[i].root], "changes its slope");
  }

  [[nodiscard]] bool differs(double one, double other, double part, const Slope& slope,
                             const std::vector<double>& magnitude) const {
    const double apart = std::abs(one - other);
    if (apart <= part * std::max(std::abs(one), std::abs(other))) return false;
    return !(apart * scale(slope.column) <= part * magnitude[slope.root]);
  }

  /// Slopes where states are off by what they can be off by: one that is known has the same value there.
  void check_certain(const std::vector<double>& slopes, const std::vector<double>& magnitude) {
    for (std::uint32_t c = 0; c < system_.states.size(); ++c) {
      const double value = values_->symbol(columns_[c]);
      if (!(errors_[c] > 8.0 * kEps * std::abs(value))) continue;
      for (const double sign : {-1.0, 1.0}) {
        const auto slopes_at = [&](double distance) {
          values_->move(columns_[c], value + sign * distance);
          std::vector<double> there = slope_values();
          values_->move(columns_[c], value);
          return there;
        };
        // A slope that passes zero here is as large further off, and what it changes by is known beside that.
        const std::vector<double> other = slopes_at(errors_[c]), far = slopes_at(kFar * errors_[c]);
        for (std::size_t i = 0; i < slopes_.size(); ++i) {
          if (!differs(slopes[i], other[i], kKnown, slopes_[i], magnitude)) continue;
          if (std::abs(slopes[i] - other[i]) <= kKnown * std::abs(far[i])) continue;
          const Root& root = roots_[slopes_[i].root];
          fail(model_, "BG408",
               "the system cannot be linearized here: " + root.name + " has a slope of " + number_text(slopes[i], 3) +
                   " by " + system_.symbols[columns_[slopes_[i].column].index()].name + ", and of " +
                   number_text(other[i], 3) + " where " + system_.symbols[columns_[c].index()].name +
                   " differs by as much as it is uncertain, " + number_text(errors_[c], 2),
               "choose a point further from where the slope changes, or a law with a bounded slope (ssqrt(x, d))",
               root.place, "a slope that changes within the uncertainty of the point is not known");
        }
      }
    }
  }

  [[nodiscard]] std::string text_of(ExprId e) const {
    return short_line(readable_text(pool_, e, [&](SymbolId s) { return system_.symbols[s.index()].name; }), 120);
  }
  /// Whose expression it is.
  [[nodiscard]] std::string owner(ExprId e) const {
    for (const ExprId part : {e, ExprId(pool_[e].a)}) {
      if (!part.valid() || part.index() >= order_.origins.size()) continue;
      const Origin origin = order_.origins[part.index()];
      if (origin.element.valid()) return " (" + short_name(model_.elements[origin.element.index()].name) + ")";
      if (origin.signal.valid()) return " (signal " + short_name(model_.signals[origin.signal.index()].name) + ")";
    }
    return {};
  }

  [[noreturn]] void fail_edge(ExprId decision, const Root& root, const char* what) {
    const ExprNode& node = pool_[decision];
    const bool is_slope = is_table(node.op);
    const std::string text = is_slope ? "its table is at a data point, " + text_of(ExprId(node.a)) + " = " +
                                            number_text((*values_)(ExprId(node.a)), 6)
                                      : text_of(decision) + owner(decision) + " is at its border";
    fail(model_, "BG408", "the system cannot be linearized here: " + root.name + " " + what + ", " + text,
         "choose a point on one side of it (--set, --at T), or write a law that is smooth there", root.place,
         "a derivative exists where both sides have the same slope");
  }

  [[noreturn]] void fail_steep(const Slope& slope) {
    // The innermost expression whose slope is not finite.
    const std::vector<ExprId> nodes = reachable(pool_, {&roots_[slope.root].value, 1});
    std::string guilty;
    for (const ExprId e : nodes) {
      for (const auto& [symbol, partial] : gradient_of(e))
        if (!std::isfinite((*values_)(partial))) guilty = text_of(e) + owner(e);
      if (!guilty.empty()) break;
    }
    if (guilty.empty()) guilty = roots_[slope.root].name;
    const std::string by = system_.symbols[columns_[slope.column].index()].name;
    fail(model_, "BG407",
         "the system cannot be linearized here: " + guilty + " has no finite slope by " + by + " = " +
             number_text(values_->symbol(columns_[slope.column]), 6) + "; " + roots_[slope.root].name +
             " depends on it",
         "choose a point at which every law has a slope, or a law with a bounded one (ssqrt(x, d))",
         roots_[slope.root].place);
  }

  const Model& model_;
  const EquationSystem& system_;
  const BlockOrder& order_;
  const LinearizationPoint& point_;
  ExprPool pool_;
  std::unordered_map<SymbolId, std::uint32_t> column_;
  std::vector<SymbolId> columns_;
  std::vector<double> errors_;  ///< by column
  std::vector<Root> roots_;
  std::vector<Slope> slopes_;
  std::optional<PointValues> values_;
};

}  // namespace

std::string words_of(const Fault& fault) {
  switch (fault.kind) {
    case Fault::Kind::loop_singular:
      return fault.target + " is singular";
    case Fault::Kind::loop_no_convergence:
      return fault.target + " has no solution";
    case Fault::Kind::outside_table:
      return "a table is read outside its data: " + fault.what;
    case Fault::Kind::none:
      return "its conditions contradict each other";
    default:
      return fault.what + " is not a finite number";
  }
}

PointPartials partials_at(const std::shared_ptr<const Model>& model, const EquationSystem& system,
                          const BlockOrder& order, const LinearizationPoint& point, bool edges) {
  // The loops are solved by the evaluator.
  CompileOptions options;
  options.energies = false;
  const Program program = compile(model, system, order, options);
  Evaluator evaluator(program, point.parameters);
  std::vector<double> rates(system.states.size());
  std::vector<std::string> found;
  Branch branch = first_branch(program);
  if (!evaluator.initialize_modes(point.t, point.x.data(), branch) ||
      !evaluator.explore_loops(point.t, point.x.data(), branch, found) ||
      !evaluator.rates(point.t, point.x.data(), branch, rates.data()))
    fail(*model, "BG407", "the system cannot be linearized here: " + words_of(evaluator.fault()),
         "choose a point at which " + evaluator.fault().target + " has a value");
  PartialsAt at(*model, system, order, point, branch.tears);
  at.check_finite();
  if (edges) at.check_edges();
  PointPartials made = at.result(program.tear_names.size());
  made.rate = std::move(rates);
  made.loop.assign(branch.tears.begin(), branch.tears.end());
  made.loop_names = program.tear_names;
  for (std::string& line : found)
    if (line.find("other solutions exist") != std::string::npos) made.notes.push_back(std::move(line));
  return made;
}

}  // namespace bgsim

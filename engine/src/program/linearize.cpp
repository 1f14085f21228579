#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "base/codes.hpp"
#include "bgsim/evaluator.hpp"

namespace bgsim {
namespace {

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

[[noreturn]] void fail(const Model& model, const char* code, std::string situation, std::string help) {
  throw ModelError({diagnostic_of(code, std::move(situation), {}, {}, std::move(help))}, model.sources);
}

std::string words_of(const Fault& fault) {
  switch (fault.kind) {
    case Fault::Kind::loop_singular:
      return fault.target + " is singular";
    case Fault::Kind::loop_no_convergence:
      return fault.target + " has no solution";
    case Fault::Kind::outside_table:
      return "a table is read outside its data: " + fault.what;
    default:
      return fault.what + " is not a finite number";
  }
}

/// Values of all nodes of a pool that some roots need, at one point.
class PointValues {
 public:
  PointValues(ExprPool& pool, std::vector<double> symbol_values)
      : pool_(pool), symbol_values_(std::move(symbol_values)) {}

  double operator()(ExprId root) {
    const std::vector<ExprId> roots{root};
    for (const ExprId e : reachable(pool_, roots)) {
      if (known_.contains(e)) continue;
      const ExprNode& node = pool_[e];
      const auto value = [this](std::uint32_t child) { return known_.at(ExprId(child)); };
      double result = 0.0;
      if (node.op == Op::constant)
        result = node.constant;
      else if (node.op == Op::symbol)
        result = symbol_values_[node.a];
      else if (is_table(node.op))
        result = apply_table(node.op, pool_.table(TableId(node.b)), value(node.a));
      else
        result = apply(node.op, value(node.a), arity(node.op) > 1 ? value(node.b) : 0.0,
                       arity(node.op) > 2 ? value(node.c) : 0.0);
      known_[e] = result;
    }
    return known_.at(root);
  }

 private:
  ExprPool& pool_;
  std::vector<double> symbol_values_;
  std::unordered_map<ExprId, double> known_;
};

}  // namespace

Linearization linearize(const std::shared_ptr<const Model>& model, const EquationSystem& system,
                        const BlockOrder& order, const RunInputs& inputs, double t, std::span<const double> x,
                        const std::vector<std::string>& input_parameters) {
  // The point: loops solved by the evaluator.
  CompileOptions options;
  options.energies = false;
  const Program program = compile(model, system, order, options);
  Evaluator evaluator(program, inputs.parameters);
  std::vector<double> rates(system.states.size());
  std::vector<std::string> found;
  Branch branch = first_branch(program);
  if (!evaluator.initialize_modes(t, x.data(), branch) || !evaluator.explore_loops(t, x.data(), branch, found) ||
      !evaluator.rates(t, x.data(), branch, rates.data()))
    fail(*model, "BG407", "the system cannot be linearized here: " + words_of(evaluator.fault()),
         "choose a point at which " + evaluator.fault().target + " has a value");

  // Columns: states, tears, inputs.
  std::unordered_map<SymbolId, Eigen::Index> column;
  std::vector<double> values(system.symbols.size(), std::numeric_limits<double>::quiet_NaN());
  values[system.time.index()] = t;
  for (std::size_t i = 0; i < inputs.parameters.size(); ++i)
    values[system.parameters[i].index()] = inputs.parameters[i];
  const auto n = static_cast<Eigen::Index>(system.states.size());
  for (std::size_t i = 0; i < system.states.size(); ++i) {
    values[system.states[i].symbol.index()] = x[i];
    column[system.states[i].symbol] = static_cast<Eigen::Index>(i);
  }
  Eigen::Index columns = n;
  std::vector<ExprId> residuals;
  std::size_t tear = 0;
  for (const Block& block : order.blocks) {
    for (const SymbolId symbol : block.tears) {
      values[symbol.index()] = branch.tears[tear++];
      column[symbol] = columns++;
    }
    residuals.insert(residuals.end(), block.residuals.begin(), block.residuals.end());
  }
  const auto m = static_cast<Eigen::Index>(residuals.size());
  for (const std::string& name : input_parameters) {
    bool known = false;
    for (std::size_t i = 0; i < model->parameters.size(); ++i) {
      if (model->parameters[i].name != name) continue;
      column[system.parameters[i]] = columns++;
      known = true;
    }
    if (!known) fail(*model, "BG406", "there is no parameter \"" + name + "\" to serve as input", "name a parameter");
  }

  ExprPool pool = order.pool;
  PointValues value_at(pool, values);
  const auto partials = [&](const std::vector<ExprId>& roots) {
    Matrix result = Matrix::Zero(static_cast<Eigen::Index>(roots.size()), columns);
    for (std::size_t r = 0; r < roots.size(); ++r)
      for (const auto& [symbol, partial] : gradient(pool, roots[r], [&](SymbolId s) { return column.contains(s); }))
        result(static_cast<Eigen::Index>(r), column.at(symbol)) = value_at(partial);
    return result;
  };
  const Matrix of_rates = partials(order.rates), of_outputs = partials(order.outputs), of_loops = partials(residuals);

  // dz = -F_z^-1 (F_x dx + F_u du)
  const Eigen::Index k = columns - n - m;
  Matrix others(m, n + k);
  others << of_loops.leftCols(n), of_loops.rightCols(k);
  Matrix tears_by_others(m, n + k);
  const auto check_finite = [&](const Matrix& values_there) {
    if (!values_there.allFinite())
      fail(*model, "BG407", "the system cannot be linearized here: a partial derivative is not finite",
           "choose a point at which every law has a slope");
  };
  check_finite(of_loops);
  // Not by full pivoting, which leaves out what is small beside the largest: loops may differ by any scale. That none
  // is singular the evaluator has found.
  if (m > 0 && n + k > 0)
    tears_by_others = -Eigen::PartialPivLU<Eigen::MatrixXd>(of_loops.middleCols(n, m)).solve(Eigen::MatrixXd(others));
  const auto eliminate = [&](const Matrix& of) {
    Matrix result(of.rows(), n + k);
    result << of.leftCols(n), of.rightCols(k);
    if (m > 0 && n + k > 0) result += of.middleCols(n, m) * tears_by_others;
    return result;
  };
  const Matrix ab = eliminate(of_rates), cd = eliminate(of_outputs);
  check_finite(ab);
  check_finite(cd);

  Linearization result;
  result.states = system.states.size();
  result.inputs = static_cast<std::size_t>(k);
  result.outputs = order.outputs.size();
  const auto copy = [](const Matrix& from) { return std::vector<double>(from.data(), from.data() + from.size()); };
  result.a = copy(ab.leftCols(n));
  result.b = copy(ab.rightCols(k));
  result.c = copy(cd.leftCols(n));
  result.d = copy(cd.rightCols(k));
  return result;
}

}  // namespace bgsim

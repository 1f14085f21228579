#include "linear/steady_field.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "base/lu.hpp"
#include "equations/solvable_causality.hpp"
#include "graph/law_numbers.hpp"

namespace bgsim {

SteadyField::SteadyField(const std::shared_ptr<const Model>& model, const RunInputs& scene)
    : parameters_(scene.parameters), t_(scene.start) {
  const BondGraph graph = build_bond_graph(*model);
  const CausalGraph causal = solvable_causality(*model, graph);
  check_laws(*model, graph, causal, scene.parameters);
  system_ = derive_equations(*model, graph, causal);
  const BlockOrder order = order_equations(*model, system_);
  // The loops on which the rates of dependent stores depend may be those of powers alone.
  program_ = compile(model, system_, order, {{}, !system_.dependent.empty()});
  terms_.emplace(*model, graph, system_, order, parameters_, t_);
  evaluator_.emplace(program_, parameters_);
  branch_ = first_branch(program_);
}

bool SteadyField::rates(const Vector& x, Vector& f) {
  Branch branch = branch_;
  f.resize(size());
  if (!evaluator_->initialize_modes(t_, x.data(), branch) || !evaluator_->rates(t_, x.data(), branch, f.data())) {
    // Loops are solved from several starts, as at the start of a run.
    std::vector<std::string> found;
    branch = first_branch(program_);
    if (!evaluator_->initialize_modes(t_, x.data(), branch) ||
        !evaluator_->explore_loops(t_, x.data(), branch, found) || !evaluator_->rates(t_, x.data(), branch, f.data()))
      return false;
  }
  branch_ = branch;
  return f.allFinite();
}

bool SteadyField::slopes(const Vector& x, const Vector& f, Rates& jacobian, Vector& terms) {
  const Sparsity& pattern = program_.jacobian_pattern;
  std::vector<double> values(pattern.row.size(), 0.0), rounding;
  Branch branch = branch_;
  if (!evaluator_->initialize_modes(t_, x.data(), branch) ||
      !evaluator_->jacobian(t_, x.data(), branch, values.data(), rounding))
    return false;
  std::vector<Eigen::Triplet<double>> triplets;
  terms = f.cwiseAbs();
  // Of what a rate is the sum: by its rounding. What slopes times states say is no measure, for a state may be any
  // number (an angle of 1e15) and its law still be of size 1.
  const bool known = !rounding.empty();
  for (std::size_t c = 0; c < pattern.size; ++c)
    for (auto k = pattern.column_start[c]; k < pattern.column_start[c + 1]; ++k) {
      const auto row = static_cast<int>(pattern.row[static_cast<std::size_t>(k)]);
      const double value = values[static_cast<std::size_t>(k)];
      if (!std::isfinite(value)) return false;
      triplets.emplace_back(row, static_cast<int>(c), value);
      if (!known) terms(row) = std::max(terms(row), std::abs(value * x(static_cast<Eigen::Index>(c))));
    }
  for (std::size_t i = 0; i < rounding.size(); ++i)
    if (std::isfinite(rounding[i]))
      terms(static_cast<Eigen::Index>(i)) =
          std::max(terms(static_cast<Eigen::Index>(i)), 0.25 * rounding[i] / std::numeric_limits<double>::epsilon());
  jacobian.resize(size(), size());
  jacobian.setFromTriplets(triplets.begin(), triplets.end());
  return true;
}

RateTerms* SteadyField::terms_at(const Vector& x) {
  if (!program_.dependent.empty()) {
    std::vector<double> unused(std::max(program_.dependent.size(), program_.powers.results.size()));
    if (!evaluator_->dependents(t_, x.data(), branch_, unused.data())) return nullptr;
    evaluator_->powers(t_, x.data(), branch_, unused.data());
  }
  terms_->set(x, branch_.tears);
  return &*terms_;
}

std::vector<RunInputs::Initial> SteadyField::stored(const Vector& x, const Vector& errors) {
  std::vector<RunInputs::Initial> values;
  const auto add = [&](const StateInfo& state, double value, double error) {
    values.push_back({state.element, state.port, value, state.place, state.signal, error});
  };
  for (Eigen::Index i = 0; i < size(); ++i) add(program_.states[static_cast<std::size_t>(i)], x(i), errors(i));
  std::vector<double> dependent(program_.dependent.size());
  Branch branch = branch_;
  if (!dependent.empty() && evaluator_->initialize_modes(t_, x.data(), branch) &&
      evaluator_->dependents(t_, x.data(), branch, dependent.data()))
    for (std::size_t i = 0; i < dependent.size(); ++i) add(program_.dependent[i], dependent[i], 0.0);
  std::sort(values.begin(), values.end(), [](const auto& a, const auto& b) {
    return std::tuple(a.element, a.port, a.signal) < std::tuple(b.element, b.port, b.signal);
  });
  return values;
}

bool solve_shifted(const Eigen::SparseMatrix<double>& jacobian, double shift, const Eigen::VectorXd& f,
                   const Eigen::VectorXd& size, Eigen::VectorXd& dx) {
  const Eigen::Index n = f.size();
  dx = Eigen::VectorXd::Zero(n);
  if (n == 0) return true;
  std::vector<Eigen::Triplet<double>> triplets;
  Eigen::VectorXd row = Eigen::VectorXd::Zero(n);
  const auto entry = [&](Eigen::Index r, Eigen::Index c, double value) {
    triplets.emplace_back(static_cast<int>(r), static_cast<int>(c), value * size(c));
  };
  for (Eigen::Index k = 0; k < jacobian.outerSize(); ++k)
    for (Eigen::SparseMatrix<double>::InnerIterator it(jacobian, k); it; ++it) entry(it.row(), it.col(), -it.value());
  for (Eigen::Index i = 0; i < n; ++i) entry(i, i, shift);
  Eigen::SparseMatrix<double> matrix(n, n);
  matrix.setFromTriplets(triplets.begin(), triplets.end());
  for (Eigen::Index k = 0; k < matrix.outerSize(); ++k)
    for (Eigen::SparseMatrix<double>::InnerIterator it(matrix, k); it; ++it)
      row(it.row()) = std::max(row(it.row()), std::abs(it.value()));
  for (Eigen::Index i = 0; i < n; ++i)
    if (row(i) == 0.0) return false;
  for (Eigen::Index k = 0; k < matrix.outerSize(); ++k)
    for (Eigen::SparseMatrix<double>::InnerIterator it(matrix, k); it; ++it) it.valueRef() /= row(it.row());
  const Eigen::VectorXd right = f.cwiseQuotient(row);
  constexpr Eigen::Index kDense = 120;
  if (n <= kDense) {
    Eigen::MatrixXd full(matrix);
    // Rows have like magnitudes; columns, too, so that a rank is one of the graph and not of units.
    Eigen::VectorXd column = full.cwiseAbs().colwise().maxCoeff();
    for (Eigen::Index c = 0; c < n; ++c) {
      if (column(c) == 0.0) return false;
      full.col(c) /= column(c);
    }
    const DenseLu lu(full);
    if (shift == 0.0 && !(lu.rcond() > 1e-14)) return false;
    dx = Eigen::VectorXd(lu.solve(right)).cwiseQuotient(column);
  } else {
    matrix.makeCompressed();
    SparseLu<double> lu;
    lu.analyze(matrix);
    if (!lu.factorize(matrix)) return false;
    dx = lu.solve(right);
  }
  dx = dx.cwiseProduct(size);
  return dx.allFinite();
}

}  // namespace bgsim

#include "support/tableau.hpp"

#include <stdexcept>

#include "support/algebra.hpp"

namespace bgsim::test {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;

// Coefficients lie between 1/3 and 3, so that ranks are clear: what is not zero is far above rounding.
constexpr double kRank = 1e-10;

class TableauWriter {
 public:
  TableauWriter(const Model& model, const BondGraph& graph, std::span<const double> parameters)
      : model_(model), graph_(graph), values_(model.symbols.size()) {
    for (std::size_t i = 0; i < parameters.size(); ++i) values_[model.parameters[i].symbol.index()] = parameters[i];
  }

  Tableau write() {
    for (std::size_t i = 0; i < graph_.kinds.size(); ++i) {
      for (std::size_t k = 0; is_store(graph_.kinds[i]) && k < graph_.port_count(ElementId(i)); ++k)
        tableau_.stores.push_back(graph_.port(ElementId(i), k));
      if (graph_.kinds[i] == ElementKind::effort_source || graph_.kinds[i] == ElementKind::flow_source)
        tableau_.sources.push_back(ElementId(i));
    }
    const Index bonds = index(graph_.bonds.size()), stores = index(tableau_.stores.size());
    tableau_.rate_y = MatrixXd::Zero(stores, 2 * bonds);
    tableau_.law_x = MatrixXd::Zero(2 * bonds, stores);
    tableau_.law_y = MatrixXd::Zero(2 * bonds, 2 * bonds);
    tableau_.law_u = MatrixXd::Zero(2 * bonds, index(tableau_.sources.size()));
    for (std::size_t i = 0; i < graph_.kinds.size(); ++i) write_element(ElementId(i));
    return std::move(tableau_);
  }

 private:
  static Index index(std::size_t i) { return static_cast<Index>(i); }
  [[nodiscard]] Index effort(PortId port) const { return index(graph_[port].bond.index()); }
  [[nodiscard]] Index flow(PortId port) const { return index(graph_.bonds.size() + graph_[port].bond.index()); }
  /// +1 where the bond's flow runs into the element.
  [[nodiscard]] double into(PortId port) const { return graph_[port].head ? 1.0 : -1.0; }

  void write_element(ElementId id) {
    const ElementKind kind = graph_.kinds[id.index()];
    if (is_junction(kind)) return write_junction(id, kind == ElementKind::zero_junction);
    const PortId port = graph_.port(id, 0);
    const ExprId coefficient = model_.elements[id.index()].coefficient;
    const double value = coefficient.valid() ? evaluate(model_.pool, coefficient, values_) : 0.0;
    MatrixXd& y = tableau_.law_y;
    switch (kind) {
      case ElementKind::effort_source:
        y(row_, effort(port)) = 1.0;
        tableau_.law_u(row_++, source_++) = -1.0;
        break;
      case ElementKind::flow_source:
        y(row_, flow(port)) = 1.0;
        tableau_.law_u(row_++, source_++) = -1.0;
        break;
      case ElementKind::open_switch:
      case ElementKind::blocking_diode:
      case ElementKind::closed_contact:
      case ElementKind::effort_detector:
        y(row_++, flow(port)) = 1.0;
        break;
      case ElementKind::closed_switch:
      case ElementKind::conducting_diode:
      case ElementKind::free_contact:
      case ElementKind::flow_detector:
        y(row_++, effort(port)) = 1.0;
        break;
      case ElementKind::resistor:
        y(row_, effort(port)) = 1.0;
        y(row_++, flow(port)) = -value * into(port);
        break;
      case ElementKind::capacitor:
        tableau_.rate_y(store_, flow(port)) = into(port);
        y(row_, effort(port)) = 1.0;
        tableau_.law_x(row_++, store_++) = -1.0 / value;
        break;
      case ElementKind::inertia:
        tableau_.rate_y(store_, effort(port)) = 1.0;
        y(row_, flow(port)) = into(port);
        tableau_.law_x(row_++, store_++) = -1.0 / value;
        break;
      case ElementKind::transformer:
        write_two_port(id, value, false);
        break;
      case ElementKind::gyrator:
        write_two_port(id, value, true);
        break;
      case ElementKind::c_field:
      case ElementKind::i_field:
      case ElementKind::ic_field:
        write_field(id);
        break;
      case ElementKind::r_field:
      case ElementKind::zero_junction:
      case ElementKind::one_junction:
        throw std::invalid_argument("the tableau knows no such element");
    }
  }

  /// Of H = z^T A z/2, A by values of H: no derivative of the engine's.
  void write_field(ElementId id) {
    const Element& field = model_.elements[id.index()];
    const std::size_t ports = field.ports.size();
    const auto stored = [&](std::size_t k) {
      return port_variable(field, k, stores_displacement(field, k) ? Variable::displacement : Variable::momentum);
    };
    const auto energy_at = [&](std::size_t i, std::size_t j) {
      for (std::size_t k = 0; k < ports; ++k) values_[stored(k).index()] = 0.0;
      values_[stored(i).index()] += 1.0;
      values_[stored(j).index()] += 1.0;
      return evaluate(model_.pool, field.energy, values_);
    };
    for (std::size_t i = 0; i < ports; ++i) {
      const PortId port = graph_.port(id, i);
      const bool q = stores_displacement(field, i);
      tableau_.rate_y(store_ + index(i), q ? flow(port) : effort(port)) = q ? into(port) : 1.0;
      tableau_.law_y(row_, q ? effort(port) : flow(port)) = q ? 1.0 : into(port);
      for (std::size_t j = 0; j < ports; ++j) {
        // H(2 e_i) is 2 A_ii, and H(e_i + e_j) is A_ij and half of A_ii and A_jj.
        const double a = i == j ? energy_at(i, i) / 2 : energy_at(i, j) - (energy_at(i, i) + energy_at(j, j)) / 4;
        tableau_.law_x(row_, store_ + index(j)) = -a;
      }
      ++row_;
    }
    store_ += index(ports);
  }

  /// Power goes in at port 1 and out at port 2: TF e1 = n e2, f2 = n f1; GY e1 = r f2, e2 = r f1.
  void write_two_port(ElementId id, double modulus, bool gyrator) {
    const PortId one = graph_.port(id, 0), two = graph_.port(id, 1);
    const double flow_in = into(one), flow_out = -into(two);
    MatrixXd& y = tableau_.law_y;
    y(row_, effort(one)) = 1.0;
    if (gyrator)
      y(row_++, flow(two)) = -modulus * flow_out;
    else
      y(row_++, effort(two)) = -modulus;
    if (gyrator)
      y(row_, effort(two)) = 1.0;
    else
      y(row_, flow(two)) = flow_out;
    y(row_++, flow(one)) = -modulus * flow_in;
  }

  void write_junction(ElementId id, bool zero) {
    const std::size_t count = graph_.port_count(id);
    const PortId first = graph_.port(id, 0);
    for (std::size_t number = 0; number < count; ++number) {
      const PortId port = graph_.port(id, number);
      // What is not shared sums up to zero, by power.
      tableau_.law_y(row_, zero ? flow(port) : effort(port)) = into(port);
    }
    ++row_;
    for (std::size_t number = 1; number < count; ++number) {
      const PortId port = graph_.port(id, number);
      tableau_.law_y(row_, zero ? effort(first) : flow(first)) = 1.0;
      tableau_.law_y(row_++, zero ? effort(port) : flow(port)) = -1.0;
    }
  }

  const Model& model_;
  const BondGraph& graph_;
  std::vector<double> values_;
  Tableau tableau_;
  Index row_ = 0, store_ = 0, source_ = 0;
};

/// Whether det(s E - A) vanishes at two arbitrary s, and so everywhere.
bool pencil_is_singular(const Tableau& t) {
  const Index n = t.rate_y.rows(), m = t.law_y.rows();
  for (const double s : {0.7310585786, -1.2824271291}) {
    MatrixXd pencil(n + m, n + m);
    pencil << s * MatrixXd::Identity(n, n), -t.rate_y, t.law_x, t.law_y;
    if (is_invertible(pencil, kRank)) return false;
  }
  return true;
}

/// The case of dependent stores: the laws alone do not determine y.
void constrain(const Tableau& t, Motion& motion) {
  const Index n = t.rate_y.rows(), m = t.law_y.rows();
  // law_y = U S V^T. Where it has no rank, the laws constrain x (left) and leave some of y free (right).
  const SingularValues svd = singular_values(t.law_y);
  const Index rank = svd.rank(kRank);
  const MatrixXd u1 = svd.u.leftCols(rank), u2 = svd.u.rightCols(m - rank);
  const MatrixXd v1 = svd.v.leftCols(rank), v2 = svd.v.rightCols(m - rank);
  const MatrixXd solve = -v1 * svd.values.head(rank).cwiseInverse().asDiagonal() * u1.transpose();
  motion.constraint_x = u2.transpose() * t.law_x;
  motion.constraint_u = u2.transpose() * t.law_u;
  motion.bonds_x = solve * t.law_x;
  motion.bonds_u = solve * t.law_u;
  // The free part of y keeps x on its constraint: 0 = constraint_x x' for constant u.
  const MatrixXd pull = motion.constraint_x * t.rate_y * v2;
  motion.index_two = is_invertible(pull, kRank);
  if (!motion.index_two) return;
  const MatrixXd free_x = -solved(pull, motion.constraint_x * t.rate_y * motion.bonds_x);
  const MatrixXd free_u = -solved(pull, motion.constraint_x * t.rate_y * motion.bonds_u);
  motion.bonds_x += v2 * free_x;
  motion.bonds_u += v2 * free_u;
  motion.basis = singular_values(motion.constraint_x).v.rightCols(n - (m - rank));
}

}  // namespace

Tableau form_tableau(const Model& model, const BondGraph& graph, std::span<const double> parameters) {
  return TableauWriter(model, graph, parameters).write();
}

Motion motion_of(const Tableau& t) {
  Motion motion;
  motion.regular = !pencil_is_singular(t);
  if (!motion.regular) return motion;
  const Index n = t.rate_y.rows();
  motion.index_two = true;
  motion.basis = MatrixXd::Identity(n, n);
  if (is_invertible(t.law_y, kRank)) {
    motion.bonds_x = -solved(t.law_y, t.law_x);
    motion.bonds_u = -solved(t.law_y, t.law_u);
    motion.constraint_x = MatrixXd::Zero(0, n);
    motion.constraint_u = MatrixXd::Zero(0, t.law_u.cols());
  } else {
    constrain(t, motion);
  }
  motion.rate_x = t.rate_y * motion.bonds_x;
  motion.rate_u = t.rate_y * motion.bonds_u;
  return motion;
}

Motion motion_without_circulation(const Tableau& t) {
  const Index n = t.rate_y.rows(), m = t.law_y.rows(), inputs = t.law_u.cols();
  // y = keep z: what neither a law nor a rate contains is left out.
  MatrixXd all(n + m, m);
  all << t.rate_y, t.law_y;
  const SingularValues columns = singular_values(all);
  MatrixXd laws(m, n + m + inputs);
  laws << t.law_x, t.law_y, t.law_u;
  const SingularValues rows = singular_values(laws);
  const Index rank = columns.rank(kRank);
  if (m == 0 || rank != rows.rank(kRank)) return {};  // not one law too many for each variable too many
  const MatrixXd keep = columns.v.leftCols(rank);
  const MatrixXd combine = rows.u.leftCols(rank).transpose();
  Tableau less = t;
  less.rate_y = t.rate_y * keep;
  less.law_x = combine * t.law_x;
  less.law_y = combine * t.law_y * keep;
  less.law_u = combine * t.law_u;
  Motion motion = motion_of(less);
  if (!motion.regular) return motion;
  motion.bonds_x = keep * motion.bonds_x;
  motion.bonds_u = keep * motion.bonds_u;
  return motion;
}

Eigen::VectorXcd Motion::poles() const {
  const MatrixXd within = basis.transpose() * rate_x * basis;
  if (within.rows() == 0) return {};
  return eigenvalues(within);
}

Eigen::VectorXd Motion::at(double time, const Eigen::VectorXd& start, const Eigen::VectorXd& u) const {
  const Index n = rate_x.rows();
  if (n == 0) return start;
  // (x, 1)' = (rate_x x + rate_u u, 0)
  MatrixXd matrix = MatrixXd::Zero(n + 1, n + 1);
  matrix.topLeftCorner(n, n) = rate_x * time;
  if (u.size() > 0) matrix.topRightCorner(n, 1) = rate_u * u * time;
  Eigen::VectorXd extended(n + 1);
  extended << start, 1.0;
  return (exponential(matrix) * extended).head(n);
}

}  // namespace bgsim::test

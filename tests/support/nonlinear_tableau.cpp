// The oracle: see nonlinear_graph.hpp.

#include <algorithm>
#include <cmath>

#include "support/algebra.hpp"
#include "support/nonlinear_graph.hpp"

namespace bgsim::test {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// 0 = r(t, x, y), x' = rate y: y are the efforts and then the flows of all bonds.
class Tableau {
 public:
  explicit Tableau(const NonlinearGraph& graph) : graph_(graph), bonds_(static_cast<Index>(graph.graph.bonds.size())) {
    for (const RandomElement& element : graph.graph.elements)
      if (element.kind == "C" || element.kind == "I") store_.emplace(element.name, static_cast<Index>(store_.size()));
    for (Index i = 0; i < bonds_; ++i) {
      const auto& [from, to] = graph.graph.bonds[static_cast<std::size_t>(i)];
      ends_[element_of(from)].push_back({i, -1.0, port_of(from)});
      ends_[element_of(to)].push_back({i, 1.0, port_of(to)});
    }
    for (const NonlinearGraph::Field& field : graph.fields) field_of_[field.one] = field_of_[field.two] = &field;
    rate_ = MatrixXd::Zero(stores(), 2 * bonds_);
    for (const auto& [name, i] : store_) {
      const End end = ends_.at(name).front();
      if (name.starts_with("C"))
        rate_(i, bonds_ + end.bond) = end.into;
      else
        rate_(i, end.bond) = 1.0;
    }
  }

  [[nodiscard]] Index stores() const { return static_cast<Index>(store_.size()); }
  [[nodiscard]] Index variables() const { return 2 * bonds_; }
  [[nodiscard]] const MatrixXd& rate() const { return rate_; }
  [[nodiscard]] const std::map<std::string, Index>& store() const { return store_; }

  struct Linearized {
    VectorXd value;
    MatrixXd by_x, by_y;
  };

  void evaluate(double t, bool after_jump, const VectorXd& x, const VectorXd& y, Linearized& out) const {
    out.value = VectorXd::Zero(variables());
    out.by_x = MatrixXd::Zero(variables(), stores());
    out.by_y = MatrixXd::Zero(variables(), variables());
    Index row = 0;
    for (const RandomElement& element : graph_.graph.elements) row = add(element, t, after_jump, x, y, out, row);
  }

  [[nodiscard]] double effort(const std::string& name, const VectorXd& y) const {
    return y(ends_.at(name).front().bond);
  }
  /// Positive into the element.
  [[nodiscard]] double flow(const std::string& name, const VectorXd& y) const {
    const End end = ends_.at(name).front();
    return end.into * y(bonds_ + end.bond);
  }

 private:
  struct End {
    Index bond;
    double into;  ///< +1 where the bond's flow runs into the element
    int port;
  };
  static std::string element_of(const std::string& end) { return end.substr(0, end.find('.')); }
  static int port_of(const std::string& end) { return end.ends_with(".1") ? 1 : end.ends_with(".2") ? 2 : 0; }

  Index add(const RandomElement& element, double t, bool after_jump, const VectorXd& x, const VectorXd& y,
            Linearized& out, Index row) const {
    const std::string& kind = element.kind;
    if (!ends_.contains(element.name)) return row;
    const std::vector<End>& ends = ends_.at(element.name);
    const Index e = ends.front().bond, f = bonds_ + e;
    const double into = ends.front().into;
    const auto linear = [&](Index at, Index column, double factor) {
      out.value(at) += factor * y(column);
      out.by_y(at, column) += factor;
    };
    if (kind == "0" || kind == "1") {
      const bool zero = kind == "0";
      for (const End& end : ends) linear(row, zero ? bonds_ + end.bond : end.bond, end.into);
      ++row;
      for (std::size_t i = 1; i < ends.size(); ++i, ++row) {
        linear(row, zero ? e : f, 1.0);
        linear(row, zero ? ends[i].bond : bonds_ + ends[i].bond, -1.0);
      }
    } else if (kind == "Se" || kind == "Sf") {
      const NonlinearGraph::Source& s = graph_.sources.at(element.name);
      linear(row, kind == "Se" ? e : f, 1.0);
      out.value(row++) -= s.mean + s.swing * std::sin(s.frequency * t) + (after_jump ? s.jump : 0.0);
    } else if (kind == "R") {
      const Curve& curve = graph_.curves.at(element.name);
      const bool effort = graph_.gives_effort.at(element.name);
      const double argument = effort ? into * y(f) : y(e);
      linear(row, effort ? e : f, effort ? 1.0 : into);
      out.value(row) -= curve.value(argument);
      out.by_y(row++, effort ? f : e) -= curve.slope(argument) * (effort ? into : 1.0);
    } else if (kind == "C" || kind == "I") {
      linear(row, kind == "C" ? e : f, kind == "C" ? 1.0 : into);
      store(element.name, x, out, row++);
    } else {
      two_port(element, ends, t, x, y, out, row);
      row += 2;
    }
    return row;
  }

  void store(const std::string& name, const VectorXd& x, Linearized& out, Index row) const {
    const Index i = store_.at(name);
    const auto found = field_of_.find(name);
    if (found == field_of_.end()) {
      const Curve& curve = graph_.curves.at(name);
      out.value(row) -= curve.value(x(i));
      out.by_x(row, i) -= curve.slope(x(i));
      return;
    }
    const NonlinearGraph::Field& field = *found->second;
    const Index k = store_.at(name == field.one ? field.two : field.one);
    const double sum = x(i) + x(k), bend = 12.0 * field.stiffening * sum * sum;
    out.value(row) -=
        x(i) / field.scale + field.coupling / field.scale * x(k) + 4.0 * field.stiffening * sum * sum * sum;
    out.by_x(row, i) -= 1.0 / field.scale + bend;
    out.by_x(row, k) -= field.coupling / field.scale + bend;
  }

  /// TF: e1 = n e2, f2 = n f1; GY: e1 = r f2, e2 = r f1; power goes in at port 1 and out at port 2.
  void two_port(const RandomElement& element, const std::vector<End>& ends, double t, const VectorXd& x,
                const VectorXd& y, Linearized& out, Index row) const {
    const NonlinearGraph::Modulus& m = graph_.moduli.at(element.name);
    const Index by = m.store.empty() ? -1 : store_.at(m.store);
    const double argument = by < 0 ? t : x(by), n = m.mean + m.swing * std::sin(argument),
                 slope = m.swing * std::cos(argument);
    const End one = ends[0].port == 1 ? ends[0] : ends[1], two = ends[0].port == 1 ? ends[1] : ends[0];
    const bool gyrator = element.kind == "GY";
    const auto equation = [&](Index at, Index left, double left_sign, Index right, double right_sign) {
      out.value(at) = left_sign * y(left) - n * right_sign * y(right);
      out.by_y(at, left) += left_sign;
      out.by_y(at, right) -= n * right_sign;
      if (by >= 0) out.by_x(at, by) -= slope * right_sign * y(right);
    };
    const Index e1 = one.bond, e2 = two.bond, f1 = bonds_ + one.bond, f2 = bonds_ + two.bond;
    if (gyrator) {
      equation(row, e1, 1.0, f2, -two.into);
      equation(row + 1, e2, 1.0, f1, one.into);
    } else {
      equation(row, e1, 1.0, e2, 1.0);
      equation(row + 1, f2, -two.into, f1, one.into);
    }
  }

  const NonlinearGraph& graph_;
  Index bonds_;
  std::map<std::string, Index> store_;
  std::map<std::string, std::vector<End>> ends_;
  std::map<std::string, const NonlinearGraph::Field*> field_of_;
  MatrixXd rate_;
};

/// Steps of Radau IIA of order 5: collocation at three points, the last of them the end (Hairer, Wanner, Solving
/// Ordinary Differential Equations II, table IV.5.6).
class Radau {
 public:
  explicit Radau(const Tableau& tableau) : tableau_(tableau) {
    const double r = std::sqrt(6.0);
    a_ << (88 - 7 * r) / 360, (296 - 169 * r) / 1800, (-2 + 3 * r) / 225, (296 + 169 * r) / 1800, (88 + 7 * r) / 360,
        (-2 - 3 * r) / 225, (16 - r) / 36, (16 + r) / 36, 1.0 / 9;
    c_ << (4 - r) / 10, (4 + r) / 10, 1.0;
    stages_ = VectorXd::Zero(3 * tableau.variables());
  }

  /// @return whether Newton's iteration converged.
  bool step(double t, double h, bool after_jump, VectorXd& x) {
    const Index m = tableau_.variables();
    VectorXd y = stages_;
    VectorXd residual = evaluate(t, h, after_jump, x, y, nullptr);
    MatrixXd jacobian;
    for (int i = 0; i < kIterations; ++i) {
      residual = evaluate(t, h, after_jump, x, y, &jacobian);
      const VectorXd change = quickly_solved(jacobian, residual);
      if (!change.allFinite()) return false;
      double part = 1.0;
      VectorXd next;
      for (int k = 0; k < 12; ++k, part /= 2.0) {
        next = y - part * change;
        const double norm = evaluate(t, h, after_jump, x, next, nullptr).norm();
        if (std::isfinite(norm) && norm <= (1.0 - part / 4.0) * residual.norm() + 1e-12) break;
      }
      y = next;
      if (part * change.norm() <= 1e-10 * (1.0 + y.norm())) {
        stages_ = y;
        for (Index j = 0; j < 3; ++j) x += h * a_(2, j) * (tableau_.rate() * y.segment(j * m, m));
        return true;
      }
    }
    return false;
  }

  /// At the end of the latest step.
  [[nodiscard]] VectorXd variables() const { return stages_.tail(tableau_.variables()); }

 private:
  static constexpr int kIterations = 40;

  VectorXd evaluate(double t, double h, bool after_jump, const VectorXd& x, const VectorXd& y, MatrixXd* jacobian) {
    const Index m = tableau_.variables();
    VectorXd residual(3 * m);
    if (jacobian != nullptr) jacobian->resize(3 * m, 3 * m);
    Tableau::Linearized at;
    for (Index i = 0; i < 3; ++i) {
      VectorXd stage = x;
      for (Index j = 0; j < 3; ++j) stage += h * a_(i, j) * (tableau_.rate() * y.segment(j * m, m));
      tableau_.evaluate(t + c_(i) * h, after_jump, stage, y.segment(i * m, m), at);
      residual.segment(i * m, m) = at.value;
      if (jacobian == nullptr) continue;
      const MatrixXd through = at.by_x * tableau_.rate();
      for (Index j = 0; j < 3; ++j) jacobian->block(i * m, j * m, m, m) = h * a_(i, j) * through;
      jacobian->block(i * m, i * m, m, m) += at.by_y;
    }
    return residual;
  }

  const Tableau& tableau_;
  Eigen::Matrix3d a_;
  Eigen::Vector3d c_;
  VectorXd stages_;
};

std::optional<OracleTrace> trace_with(const NonlinearGraph& graph, const Tableau& tableau,
                                      const std::map<std::string, double>& start, std::size_t parts) {
  VectorXd x(tableau.stores());
  for (const auto& [name, i] : tableau.store()) x(i) = start.at(name);
  Radau radau(tableau);
  OracleTrace trace;
  const double h = graph.stop / static_cast<double>(graph.intervals * parts);
  for (std::size_t step = 0; step < graph.intervals * parts; ++step) {
    const double t = h * static_cast<double>(step);
    if (!radau.step(t, h, t + h / 2 > graph.jump_time, x)) return std::nullopt;
    if ((step + 1) % parts != 0) continue;
    const VectorXd y = radau.variables();
    for (const RandomElement& element : graph.graph.elements) {
      if (element.kind != "R" && element.kind != "C" && element.kind != "I") continue;
      trace.columns[element.name + "_e"].push_back(tableau.effort(element.name, y));
      trace.columns[element.name + "_f"].push_back(tableau.flow(element.name, y));
      if (element.kind != "R") trace.columns[element.name + "_x"].push_back(x(tableau.store().at(element.name)));
    }
  }
  return trace;
}

}  // namespace

std::optional<OracleTrace> solve(const NonlinearGraph& graph, const std::map<std::string, double>& start,
                                 double agreement) {
  const Tableau tableau(graph);
  std::optional<OracleTrace> before;
  for (std::size_t parts = 3; parts <= 100; parts *= 2) {
    std::optional<OracleTrace> now = trace_with(graph, tableau, start, parts);
    if (before && now) {
      for (const auto& [name, values] : now->columns) {
        const auto [least, most] = std::minmax_element(values.begin(), values.end());
        const double range = std::max(*most - *least, 1e-6);
        for (std::size_t i = 0; i < values.size(); ++i)
          now->uncertainty = std::max(now->uncertainty, std::abs(values[i] - before->columns[name][i]) / range);
      }
      if (now->uncertainty <= agreement) return now;
    }
    before = std::move(now);
  }
  return std::nullopt;
}

}  // namespace bgsim::test

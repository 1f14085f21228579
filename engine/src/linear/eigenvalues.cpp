// Eigenvalues by blocks of states that act on each other, balanced, with what rounding can have made of them.
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <boost/graph/compressed_sparse_row_graph.hpp>
#include <boost/graph/strong_components.hpp>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "linear/dense.hpp"
#include "linear/sparse_eigenvalues.hpp"

namespace bgsim {
namespace {

using Index = Eigen::Index;
constexpr double kRoundOff = std::numeric_limits<double>::epsilon();
/// An entry is a sum of few products of partials: some roundings.
constexpr double kEntry = 4.0 * kRoundOff;
/// Larger blocks are not refined, which takes the fourth power of their size.
constexpr Index kRefined = 60;
/// Powers of two by row, such that rows and columns of D^-1 A D have like magnitudes (Parlett and Reinsch).
Eigen::VectorXd balance(Eigen::MatrixXd& a) {
  const Index n = a.rows();
  Eigen::VectorXd scale = Eigen::VectorXd::Ones(n);
  for (int sweep = 0; sweep < 200; ++sweep) {
    bool done = true;
    for (Index i = 0; i < n; ++i) {
      const double row = a.row(i).cwiseAbs().sum() - std::abs(a(i, i)),
                   column = a.col(i).cwiseAbs().sum() - std::abs(a(i, i));
      if (row == 0.0 || column == 0.0) continue;
      const double f = std::exp2(std::round(0.5 * std::log2(row / column)));
      if (f == 1.0 || row / f + column * f >= 0.95 * (row + column)) continue;
      done = false;
      scale(i) *= f;
      a.row(i) /= f;
      a.col(i) *= f;
    }
    if (done) break;
  }
  return scale;
}

using Real = long double;
using Complex = std::complex<Real>;
using Vectors = Eigen::Matrix<Complex, Eigen::Dynamic, Eigen::Dynamic>;

/// By Gauss and Jordan with pivots by column: written out, since Eigen's takes minutes to compile for such numbers.
Vectors inverse_of(Vectors matrix) {
  const Index n = matrix.rows();
  Vectors inverse = Vectors::Identity(n, n);
  for (Index k = 0; k < n; ++k) {
    Index pivot = k;
    for (Index r = k + 1; r < n; ++r)
      if (std::norm(matrix(r, k)) > std::norm(matrix(pivot, k))) pivot = r;
    for (Index c = 0; c < n; ++c) {
      std::swap(matrix(k, c), matrix(pivot, c));
      std::swap(inverse(k, c), inverse(pivot, c));
    }
    const Complex scale = Real(1) / matrix(k, k);
    for (Index c = 0; c < n; ++c) {
      matrix(k, c) *= scale;
      inverse(k, c) *= scale;
    }
    for (Index r = 0; r < n; ++r) {
      const Complex factor = matrix(r, k);
      if (r == k || factor == Complex(0)) continue;
      for (Index c = 0; c < n; ++c) {
        matrix(r, c) -= factor * matrix(k, c);
        inverse(r, c) -= factor * inverse(k, c);
      }
    }
  }
  return inverse;
}

/// The solution of (a - shift) x = right, or of its transpose, by Gauss with the pivots of each column; false where a
/// pivot is 0.
bool solve_shifted(const Eigen::MatrixXd& a, Complex shift, bool transposed, std::vector<Complex>& x) {
  const Index n = a.rows();
  Vectors m(n, n);
  for (Index c = 0; c < n; ++c)
    for (Index r = 0; r < n; ++r)
      m(r, c) = Complex(static_cast<Real>(transposed ? a(c, r) : a(r, c))) - (r == c ? shift : Complex(0));
  for (Index k = 0; k < n; ++k) {
    Index pivot = k;
    for (Index r = k + 1; r < n; ++r)
      if (std::norm(m(r, k)) > std::norm(m(pivot, k))) pivot = r;
    if (m(pivot, k) == Complex(0)) return false;
    std::swap(x[static_cast<std::size_t>(k)], x[static_cast<std::size_t>(pivot)]);
    for (Index c = k; c < n; ++c) std::swap(m(k, c), m(pivot, c));
    for (Index r = k + 1; r < n; ++r) {
      const Complex factor = m(r, k) / m(k, k);
      if (factor == Complex(0)) continue;
      for (Index c = k + 1; c < n; ++c) m(r, c) -= factor * m(k, c);
      x[static_cast<std::size_t>(r)] -= factor * x[static_cast<std::size_t>(k)];
    }
  }
  Real size = 0;
  for (Index k = n; k-- > 0;) {
    Complex& value = x[static_cast<std::size_t>(k)];
    for (Index c = k + 1; c < n; ++c) value -= m(k, c) * x[static_cast<std::size_t>(c)];
    value /= m(k, k);
    size = std::max(size, std::abs(value));
  }
  if (!std::isfinite(static_cast<double>(size)) || size == 0) return false;
  for (Complex& value : x) value /= size;
  return true;
}

/// Of small blocks: the eigenvalue by its vectors, from inverse iteration. The QR iteration is off by roundings of the
/// largest entry, which may be far more than a small eigenvalue; this is off by roundings of what takes part in it.
void refine(const Eigen::MatrixXd& a, const Eigen::VectorXd& scale, Vectors& right, Vectors& left, Index k,
            BlockEigenvalue& one) {
  const Index n = a.rows();
  std::vector<Complex> x, y;
  for (Index i = 0; i < n; ++i) {
    x.push_back(right(i, k));
    y.push_back(left(k, i));
  }
  Complex value(one.value.real(), one.value.imag());
  Real moved = 0, gross = 0;
  for (int round = 0; round < 3; ++round) {
    // Off the eigenvalue by a little, so that no pivot is 0.
    const Complex shift = value * (Real(1) + Real(1e-17L)) + Complex(static_cast<Real>(one.error) * Real(1e-4L));
    if (!solve_shifted(a, shift, false, x) || !solve_shifted(a, shift, true, y)) return;
    Complex product = 0, image = 0;
    gross = 0;
    for (Index i = 0; i < n; ++i) {
      const Complex yi = y[static_cast<std::size_t>(i)];
      product += yi * x[static_cast<std::size_t>(i)];
      for (Index j = 0; j < n; ++j) {
        if (a(i, j) == 0.0) continue;
        const Complex term = yi * static_cast<Real>(a(i, j)) * x[static_cast<std::size_t>(j)];
        image += term;
        gross += std::abs(term);
      }
    }
    const Complex next = image / product;
    gross /= std::abs(product);
    moved = std::abs(next - value);
    if (!(moved <= static_cast<Real>(round == 0 ? 10.0 * one.error : one.error))) return;  // another one, or none
    value = next;
  }
  const Real error = static_cast<Real>(kEntry) * gross + 4 * moved;
  if (!(static_cast<double>(error) < one.error)) return;
  one.error = static_cast<double>(error);
  const bool real = one.value.imag() == 0.0;
  one.value = {static_cast<double>(value.real()), real ? 0.0 : static_cast<double>(value.imag())};
  double sum = 0.0;
  for (Index i = 0; i < n; ++i) {
    const Complex xi = x[static_cast<std::size_t>(i)];
    const Complex scaled = xi * static_cast<Real>(scale(i));
    one.mode[static_cast<std::size_t>(i)] = {static_cast<double>(scaled.real()), static_cast<double>(scaled.imag())};
    one.participation[static_cast<std::size_t>(i)] = static_cast<double>(std::abs(y[static_cast<std::size_t>(i)] * xi));
    sum += one.participation[static_cast<std::size_t>(i)];
  }
  for (double& part : one.participation) part /= sum;
}

void solve_block(const Eigen::MatrixXd& balanced, const Eigen::VectorXd& scale, std::vector<BlockEigenvalue>& block) {
  using Matrix = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>;
  const Index n = balanced.rows();
  const Eigen::EigenSolver<Matrix> solver(balanced.cast<Real>());
  if (solver.info() != Eigen::Success) throw std::runtime_error("the QR iteration does not converge");
  Vectors right = solver.eigenvectors(), left = inverse_of(right);
  const Real norm = static_cast<Real>(balanced.norm());
  for (Index k = 0; k < n; ++k) {
    BlockEigenvalue& one = block[static_cast<std::size_t>(k)];
    one.value = {static_cast<double>(solver.eigenvalues()(k).real()),
                 static_cast<double>(solver.eigenvalues()(k).imag())};
    // y A x with y x = 1: what the entries' roundings and the iteration's can move it by.
    Real data = 0, left_size = 0, right_size = 0;
    for (Index i = 0; i < n; ++i) {
      left_size += std::norm(left(k, i));
      right_size += std::norm(right(i, k));
    }
    for (Index j = 0; j < n; ++j) {
      const Real x = std::abs(right(j, k));
      for (Index i = 0; i < n; ++i)
        if (balanced(i, j) != 0.0) data += std::abs(left(k, i)) * static_cast<Real>(std::abs(balanced(i, j))) * x;
    }
    const Real error = static_cast<Real>(kEntry) * data + static_cast<Real>(n) * std::numeric_limits<Real>::epsilon() *
                                                              norm * std::sqrt(left_size * right_size);
    one.error = std::isfinite(static_cast<double>(error)) ? static_cast<double>(error) : balanced.norm();
    double sum = 0.0;
    for (Index i = 0; i < n; ++i) {
      const auto part = static_cast<double>(std::abs(left(k, i) * right(i, k)));
      one.participation.push_back(std::isfinite(part) ? part : 0.0);
      sum += one.participation.back();
      const Complex x = right(i, k) * static_cast<Real>(scale(i));
      one.mode.emplace_back(static_cast<double>(x.real()), static_cast<double>(x.imag()));
    }
    for (double& part : one.participation) part = sum > 0.0 ? part / sum : 1.0 / static_cast<double>(n);
    if (n <= kRefined) refine(balanced, scale, right, left, k, one);
  }
}

}  // namespace

namespace {

/// Of a block too large for dense algebra.
std::vector<BlockEigenvalue> sparse_block(const LinearMatrix& matrix, const std::vector<std::uint32_t>& component,
                                          const std::vector<std::uint32_t>& place,
                                          const std::vector<std::uint32_t>& members, const PolesNear& some) {
  const std::uint32_t own = component[members.front()];
  std::vector<Eigen::Triplet<double>> entries;
  for (const auto& e : matrix.entries)
    if (component[e.row] == own && component[e.column] == own)
      entries.emplace_back(static_cast<int>(place[e.row]), static_cast<int>(place[e.column]), e.value);
  Eigen::SparseMatrix<double> a(static_cast<Index>(members.size()), static_cast<Index>(members.size()));
  a.setFromTriplets(entries.begin(), entries.end());
  std::vector<BlockEigenvalue> block = eigenvalues_near(a, some);
  for (BlockEigenvalue& one : block) one.rows = members;
  return block;
}

}  // namespace

std::vector<BlockEigenvalue> eigenvalues_by_blocks(const LinearMatrix& matrix, const std::optional<PolesNear>& some) {
  const std::size_t n = matrix.rows;
  std::vector<std::pair<std::size_t, std::size_t>> arcs;
  for (const auto& e : matrix.entries) arcs.emplace_back(e.row, e.column);
  const boost::compressed_sparse_row_graph<boost::directedS> graph(boost::edges_are_unsorted_multi_pass, arcs.begin(),
                                                                   arcs.end(), n);
  std::vector<std::uint32_t> component(n, 0);
  const std::size_t count =
      n == 0 ? 0
             : boost::strong_components(
                   graph, boost::make_iterator_property_map(component.begin(), boost::get(boost::vertex_index, graph)));
  std::vector<std::vector<std::uint32_t>> members(count);
  std::vector<std::uint32_t> place(n);
  for (std::uint32_t i = 0; i < n; ++i) {
    place[i] = static_cast<std::uint32_t>(members[component[i]].size());
    members[component[i]].push_back(i);
  }
  std::vector<Eigen::MatrixXd> blocks(count);
  for (std::size_t b = 0; b < count; ++b) {
    if (members[b].size() > kLargestDense && !some)
      throw std::length_error(std::to_string(members[b].size()) + " states act on each other");
    if (members[b].size() > kLargestDense) continue;
    blocks[b] = Eigen::MatrixXd::Zero(static_cast<Index>(members[b].size()), static_cast<Index>(members[b].size()));
  }
  for (const auto& e : matrix.entries)
    if (component[e.row] == component[e.column] && members[component[e.row]].size() <= kLargestDense)
      blocks[component[e.row]](place[e.row], place[e.column]) = e.value;
  std::vector<BlockEigenvalue> all;
  for (std::size_t b = 0; b < count; ++b) {
    std::vector<BlockEigenvalue> block(members[b].size());
    for (BlockEigenvalue& one : block) one.rows = members[b];
    if (block.size() > kLargestDense) {
      block = sparse_block(matrix, component, place, members[b], *some);
    } else if (block.size() == 1) {
      const double value = blocks[b](0, 0);
      block[0].value = value;
      block[0].error = kEntry * std::abs(value);
      block[0].participation = {1.0};
      block[0].mode = {1.0};
    } else {
      const Eigen::VectorXd scale = balance(blocks[b]);
      solve_block(blocks[b], scale, block);
    }
    // What is below its error is nothing that is known.
    for (BlockEigenvalue& one : block) {
      if (std::abs(one.value) <= one.error) one.value = 0.0;
      if (std::abs(one.value.real()) <= one.error) one.value.real(0.0);
    }
    all.insert(all.end(), block.begin(), block.end());
  }
  return all;
}

}  // namespace bgsim

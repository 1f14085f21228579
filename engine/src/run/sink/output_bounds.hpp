/// Whether outputs may be something else between the points at which they were measured.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "program/enclosure.hpp"

namespace bgsim {

/// Encloses the outputs that follow an operator that is neither a sum nor a product (exponentials, quotients, roots,
/// splines), so that a pulse of a state that is narrower than the distance of two points is not passed over. Outputs
/// that follow the unknowns of loops are left out.
class OutputBounds {
 public:
  OutputBounds(const Program& program, std::span<const double> parameters);

  [[nodiscard]] bool any() const { return !outputs_.empty(); }
  void set_modes(std::span<const double> modes);

  /// Of the states @p x those that enclose() asks for.
  void keep(const std::vector<double>& x, std::vector<double>& kept) const;
  /// Over [@p from, @p to], in which the states are near those at some points of it.
  /// @param times, states  points from beginning to end, and what keep() gave at each.
  /// @return  whether an operator bends there: else the points show what the outputs are.
  bool enclose(double from, double to, std::span<const double> times, const std::vector<std::vector<double>>& states);
  /// After that: by which positions of Program::output_names, and what holds all their values.
  [[nodiscard]] const std::vector<std::uint32_t>& outputs() const { return outputs_; }
  [[nodiscard]] Range of(std::size_t which) const { return (*bounds_)[operators_ + which].value; }

 private:
  std::vector<std::uint32_t> outputs_;  ///< positions
  std::size_t operators_ = 0;           ///< of the roots, the first; then the outputs
  std::optional<Enclosure> bounds_;
  std::vector<Jet> jets_;
};

}  // namespace bgsim

/// What expressions of a model are worth before the run.
#pragma once

#include <span>
#include <vector>

#include "bgsim/model.hpp"
#include "expression/rounded.hpp"

namespace bgsim {

/// Values at the start of a scene, or of the model alone.
class StartValues {
 public:
  StartValues(const Model& model, const Scene* scene) : StartValues(model, scene, {}) {}
  /// With the parameters' values as they are, by ParameterId.
  StartValues(const Model& model, std::span<const double> parameters) : StartValues(model, nullptr, parameters) {}

  /// Not a number if the expression has no value that is known before the run.
  Rounded operator()(ExprId expression);

 private:
  StartValues(const Model& model, const Scene* scene, std::span<const double> parameters)
      : model_(model),
        scene_(scene),
        parameters_(parameters),
        values_(model.pool.size()),
        known_(model.pool.size(), false) {}
  [[nodiscard]] const Rounded& at(std::uint32_t id) const { return values_[id]; }
  [[nodiscard]] ExprId behind_symbol(ExprId e) const;
  [[nodiscard]] bool starts_from_law(const ModelSymbol& symbol) const;
  [[nodiscard]] Rounded value_of(ExprId e) const;
  [[nodiscard]] Rounded value_of_symbol(ExprId e) const;

  const Model& model_;
  const Scene* scene_;
  std::span<const double> parameters_;
  std::vector<Rounded> values_;
  std::vector<bool> known_;
};

/// Whether an expression of the model depends on anything but parameters.
bool varies(const Model& model, ExprId expression);

}  // namespace bgsim

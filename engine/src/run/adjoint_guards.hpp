/// What conditions change by with all that an adjoint run has derivatives by.
#pragma once

#include <vector>

#include "bgsim/simulate.hpp"
#include "run/adjoint.hpp"
#include "run/variation.hpp"

namespace bgsim {

/// Slopes of guards by all states, then all parameters; or by seeds.
class FreeGuards : public GuardSlopes {
 public:
  /// @param units  of states, then parameters
  /// @param seeds  null: by states and parameters
  FreeGuards(const Program& program, const RunInputs& inputs, const std::vector<double>& units,
             const std::vector<AdjointSeed>* seeds)
      : evaluator_(program, inputs.parameters),
        units_(units),
        seeds_(seeds),
        rates_(program.state_names.size()),
        weights_(program.relations.size(), 0.0),
        by_states_(rates_.size()),
        by_columns_(program.transposed.columns.size() + 1) {}

  bool at(double t, const std::vector<double>& x, Branch& branch) override {
    return evaluator_.rates(t, x.data(), branch, rates_.data()) &&
           evaluator_.take_partials(t, x.data(), branch, Evaluator::Rows::guards);
  }
  double by_time(std::size_t relation) override {
    pull_back(relation);
    double sum = by_columns_.back();
    for (std::size_t i = 0; i < rates_.size(); ++i) sum += by_states_[i] * rates_[i];
    return sum;
  }
  std::vector<double> by_variation(std::size_t relation) override {
    pull_back(relation);
    std::vector<double> result;
    if (seeds_ == nullptr) {
      result = by_states_;
      result.insert(result.end(), by_columns_.begin(), by_columns_.end() - 1);
      return result;
    }
    for (const AdjointSeed& seed : *seeds_) {
      double sum = 0.0;
      for (std::size_t i = 0; i < rates_.size(); ++i) sum += by_states_[i] * seed.states[i];
      for (std::size_t i = 0; i < seed.columns.size(); ++i) sum += by_columns_[i] * seed.columns[i];
      result.push_back(sum);
    }
    return result;
  }
  [[nodiscard]] double unit(std::size_t of) const override { return seeds_ == nullptr ? units_[of] : 1.0; }

 private:
  void pull_back(std::size_t relation) {
    weights_[relation] = 1.0;
    evaluator_.pull_back({}, weights_, by_states_, by_columns_);
    weights_[relation] = 0.0;
  }

  Evaluator evaluator_;
  const std::vector<double>& units_;
  const std::vector<AdjointSeed>* seeds_;
  std::vector<double> rates_, weights_, by_states_, by_columns_;
};

}  // namespace bgsim

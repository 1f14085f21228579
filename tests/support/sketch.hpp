/// Small models for tests, written in one line: sketch("Se:s 1:a R:r C:c", "s>a a>r a>c").
#pragma once

#include <string>

#include "bgsim/bgsim.hpp"

namespace bgsim::test {

/// Model format 1 from a sketch. Elements are KIND:name with all coefficients 1 (`KIND:name=3` sets another); bonds are
/// tail>head. @p more_elements is JSON text of further members of "elements", e.g. elements with laws.
std::string sketch(const std::string& elements, const std::string& bonds, const std::string& more_elements = {});

/// The first three stages of a model.
struct Stages {
  Study study;
  const Model& model;
  const BondGraph& graph;
  const CausalGraph& causal;

  explicit Stages(const std::string& json);

  [[nodiscard]] ElementId element(const std::string& name) const;
  /// "at tail" or "at head".
  [[nodiscard]] std::string stroke(const std::string& bond) const;
  /// The element at the end of the stroke.
  [[nodiscard]] std::string stroke_at(const std::string& bond) const;
  [[nodiscard]] std::string states() const;     ///< port names of stores in integral causality: "a b"
  [[nodiscard]] std::string dependent() const;  ///< of the others
};

/// Empty if every junction, TF, GY, source and one-way law has the strokes that its rule asks for; else the first
/// element that has not.
std::string broken_rule(const Model& model, const BondGraph& graph, const std::vector<Stroke>& strokes);

/// The codes of the problems that reading or the first stages throw, in order: "BG301 BG303"; empty if none.
std::string problems_of(const std::string& json);
/// The rendered messages.
std::string messages_of(const std::string& json);

}  // namespace bgsim::test

/// flat_model_json: a model as one file of format 1, with elements cut out of it.
#pragma once

#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "bgsim/reduce.hpp"

namespace bgsim {

/// A cut that cannot be made, with the reason in words.
class CutRefused : public std::runtime_error {
 public:
  explicit CutRefused(const std::string& why, std::vector<ElementId> needed = {})
      : std::runtime_error(why), needed_(std::move(needed)) {}
  /// Elements that were dropped and that something written names, itself or by a bond.
  [[nodiscard]] const std::vector<ElementId>& needed() const { return needed_; }

 private:
  std::vector<ElementId> needed_;
};

struct FlatModelOptions {
  std::string file;         ///< where the text is to stand: data files are named relative to its folder
  std::string scene;        ///< the one scene that is written
  std::string name, about;  ///< of the new model
  std::vector<Cut> cuts;
  std::vector<ElementId> dropped;   ///< elements that are left away with all their bonds
  std::string reference;            ///< file of the reference trace, as it is to be written; empty: none
  double reference_relative = 0.0;  ///< tolerance to be written beside it
};

/// The flat name of each element, by ElementId: submodels' dots become underscores ("left.mass": "left_mass").
std::vector<std::string> flat_names(const Model& model);

/// Writes @p model with its submodels unfolded, one scene, the outputs which that records, and only the parameters and
/// signals that are used. An element with no effort at a 1-junction, or no flow at a 0-junction, is gone with its bond,
/// and so are junctions of which that leaves nothing; elsewhere a source of 0 takes its place. What expressions say of
/// a cut element is replaced by what the cut makes of it (effort or flow 0, the junction's other variable; the
/// displacement of a C without flow stays at its initial value).
/// @throws CutRefused  something needs a quantity that the cut leaves undefined: what a store without effort holds, or
/// a mass without flow; or names an element that is dropped, or one of its bonds.
/// @throws std::invalid_argument  a cut element is no one-port R, C or I, or there is no such scene.
/// @note Elements are dropped as requested: the caller must know that the value of nothing written depends on them
///       (unobserved_elements). What is written may still name them.
std::string flat_model_json(const Model& model, const BondGraph& graph, const FlatModelOptions& options);

}  // namespace bgsim

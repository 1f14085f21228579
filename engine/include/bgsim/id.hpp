/// Typed indices: a BondId cannot be used where an ElementId is meant.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>

namespace bgsim {

/// Index into one of the tables of a model, graph or system. A default-made id refers to nothing.
template <class Tag>
struct Id {
  static constexpr std::uint32_t kNone = 0xffffffffU;
  std::uint32_t value = kNone;

  constexpr Id() = default;
  constexpr explicit Id(std::size_t index) : value(static_cast<std::uint32_t>(index)) {}
  [[nodiscard]] constexpr bool valid() const { return value != kNone; }
  [[nodiscard]] constexpr std::size_t index() const { return value; }
  friend constexpr auto operator<=>(const Id&, const Id&) = default;
};

using DocumentId = Id<struct DocumentTag>;    ///< a JSON file of a model
using NodeId = Id<struct NodeTag>;            ///< a value inside a JSON file
using ExprId = Id<struct ExprTag>;            ///< an expression in an ExprPool
using SymbolId = Id<struct SymbolTag>;        ///< a named quantity that expressions refer to
using TableId = Id<struct TableTag>;          ///< a column of measured data
using ElementId = Id<struct ElementTag>;      ///< an element of a model (and of its bond graph)
using PortId = Id<struct PortTag>;            ///< a port in a BondGraph
using BondId = Id<struct BondTag>;            ///< a bond of a model (and of its bond graph)
using ParameterId = Id<struct ParameterTag>;  ///< a parameter of a model
using SignalId = Id<struct SignalTag>;        ///< a signal of a model

}  // namespace bgsim

template <class Tag>
struct std::hash<bgsim::Id<Tag>> {
  std::size_t operator()(const bgsim::Id<Tag>& id) const noexcept { return id.value; }
};

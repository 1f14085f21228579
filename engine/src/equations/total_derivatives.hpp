/// Derivatives by time that equations ask for: der(...) in a line of the model, and stores in derivative causality.
#pragma once

#include <cstdint>
#include <string>
#include <unordered_map>
#include <vector>

#include "bgsim/equations.hpp"
#include "equations/derivative_faults.hpp"

namespace bgsim {

/// Each derivative is an unknown of the system. Its equation, by the chain rule, is written when all others are known,
/// and may ask for further ones.
class TotalDerivatives {
 public:
  /// @param problems  receives BG402 (what jumps has no derivative) and BG403 (too many differentiations in a row).
  /// @param in_pieces  the parts between jumps are differentiated each by itself: nothing is asked of borders.
  TotalDerivatives(const Model& model, EquationSystem& system, std::vector<Diagnostic>& problems, bool in_pieces)
      : model_(model), system_(system), problems_(problems), in_pieces_(in_pieces) {}

  /// The total time derivative of @p argument, for which @p wish asks: an unknown, or a constant.
  ExprId of(ExprId argument, const Wish& wish);

  /// Writes the equations of all derivatives that were asked for, and of those that they ask for in turn.
  void write_equations();

 private:
  struct Pending {
    ExprId argument;
    SymbolId unknown;
    Wish wish;
  };

  [[nodiscard]] std::string name_of(ExprId argument) const;
  void write_equation(const Pending& pending);
  void differentiate_symbol(const Pending& pending);
  ExprId total(ExprId expression, Place place, const Pending& pending);
  ExprId chain_rule(ExprId expression, const Pending& pending);
  [[nodiscard]] bool varies(SymbolId symbol) const;
  void look_at_borders(ExprId expression, Place place, const Pending& pending);
  void look_at_sets(const State& state, const Pending& pending);
  void look_at_source(const Equation& equation, Place line, const Pending& pending);
  [[nodiscard]] bool follows_delay(ExprId expression) const;
  void report_index(const Equation& equation, const std::string& name);

  const Model& model_;
  EquationSystem& system_;
  std::vector<Diagnostic>& problems_;
  bool in_pieces_;
  std::unordered_map<ExprId, SymbolId> derivatives_;
  std::vector<Pending> pending_;
  std::unordered_map<SymbolId, std::uint32_t> depth_;  ///< differentiations between an unknown and the model's own
  /// Whether something was: a derivative of a jump is asked for again and again, up to the most.
  bool reported_ = false;
};

}  // namespace bgsim

/// Cancelling in products and quotients: 2*u/(2*c) is u/c.
#pragma once

#include <unordered_map>
#include <utility>
#include <vector>

#include "bgsim/expression.hpp"

namespace bgsim {

/// Rewrites expressions of one pool where a number or a factor of a product stands against one below the line; all
/// else stays as it is. The result never has more operators. It is equal where both are defined; x/x becomes 1.
/// What has been rewritten is kept, so that expressions with common parts cost their parts once.
class Canceller {
 public:
  explicit Canceller(ExprPool& pool) : pool_(pool) {}
  ExprId operator()(ExprId root);

 private:
  /// coefficient times factors to integer powers; the factors increase, no power is 0.
  struct Product {
    double coefficient = 1.0;
    std::vector<std::pair<ExprId, int>> factors;
  };
  struct Known {
    ExprId image;
    Product product;  ///< of the image
  };
  [[nodiscard]] const Known& known(std::uint32_t index) const { return known_.at(ExprId(index)); }
  Known rewritten(const ExprNode& node);
  Known rewritten_power(const ExprNode& node, ExprId image) const;
  [[nodiscard]] static Known atom(ExprId image) { return {image, {1.0, {{image, 1}}}}; }
  [[nodiscard]] static std::size_t size(const Product& product);
  [[nodiscard]] static Product times(const Product& a, const Product& b, int power_of_b);
  ExprId write(const Product& product);
  ExprId write_side(const Product& product, int sign);

  ExprPool& pool_;
  std::unordered_map<ExprId, Known> known_;
};

}  // namespace bgsim

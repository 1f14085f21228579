/// How large the states have been.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace bgsim {

/// Largest magnitudes in the first half of the run so far, to tell sudden growth from size (BG605).
class Magnitudes {
 public:
  explicit Magnitudes(std::size_t states) : early_(states, 0.0), now_(states, 0.0) {}

  /// An accepted point, @p elapsed after the start.
  void take(double elapsed, const std::vector<double>& x) {
    if (elapsed > 2.0 * early_until_) {
      early_ = now_;
      early_until_ = elapsed;
    }
    for (std::size_t i = 0; i < x.size(); ++i) now_[i] = std::max(now_[i], std::abs(x[i]));
  }
  [[nodiscard]] const std::vector<double>& early() const { return early_; }

  template <class Archive>
  void carry(Archive& archive) {
    archive("early", early_);
    archive("now", now_);
    archive("early until", early_until_);
  }

 private:
  std::vector<double> early_, now_;
  double early_until_ = 0.0;
};

}  // namespace bgsim

/// Whether steps still advance the time.
#pragma once

#include <cstdint>

namespace bgsim {

/// Counts steps in a row that are roundings of the time. After a restart some are normal: a state at zero with a strong
/// push starts with steps that move it by no more than its tolerance. For an electrostatic gap above pull-in, and for
/// growth without bound (BG605, BG608): their steps shrink without end.
class Vitality {
 public:
  /// An accepted step that ends at @p time. False: time no longer advances.
  bool look(double step, double time);

  template <class Archive>
  void carry(Archive& archive) {
    archive("tiny steps", tiny_);
    archive("empty steps", empty_);
  }

 private:
  std::uint64_t tiny_ = 0, empty_ = 0;  ///< in a row: within rounding of the time; of no length
};

}  // namespace bgsim

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
  /// An accepted step from @p from, and where the laws last had no value. True each time after a number of steps in a
  /// row that ended shortly before such a place. They need not be short: where a state is a large number, steps that
  /// move it by less than its rounding go on for ever.
  bool blocked(double step, double from, double fault);

  template <class Archive>
  void carry(Archive& archive) {
    archive("tiny steps", tiny_);
    archive("empty steps", empty_);
    archive("blocked steps", blocked_);
  }

 private:
  std::uint64_t tiny_ = 0, empty_ = 0;  ///< in a row: within rounding of the time; of no length
  std::uint64_t blocked_ = 0;           ///< in a row: shortly before laws without a value
};

}  // namespace bgsim

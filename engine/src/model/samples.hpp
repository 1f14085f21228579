/// How sampling times stand in a model's conditions.
#pragma once

namespace bgsim {

/// Times are multiplied by this in the conditions behind sampled signals, so that samples come some roundings early
/// (see add_samples() of the reader). No model has the number by chance, so it tells these conditions from others.
inline constexpr double kSamplesEarly = 1.0 + 0x1p-44;

}  // namespace bgsim

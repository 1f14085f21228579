/// Instructions as machine code.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "bgsim/program.hpp"

namespace bgsim {

/// Lists of instructions that an evaluator runs often, as straight-line code for the processor that it runs on: no
/// decision which operator comes next, and values that are used again at once stay in registers. Sums, products,
/// quotients and roots are single instructions, all else calls what the interpreter calls; so each value is, to the
/// bit, the interpreter's.
///
/// For x86-64 with AVX. Elsewhere, and where the system gives no memory for code, the interpreter goes on as before.
class MachineCode {
 public:
  /// For one point, whose slots are doubles, or for four, whose slots are four doubles each.
  enum class Width : std::uint8_t { one, four };
  /// @param slots   of all values
  /// @param points  of the four, those that count: where an operator costs as much for each
  using Entry = void (*)(double* slots, std::size_t points);

  /// @param program  must outlive it
  explicit MachineCode(const Program& program);
  ~MachineCode();
  MachineCode(const MachineCode&) = delete;
  MachineCode& operator=(const MachineCode&) = delete;

  /// To be asked before each run of a list of the program: its code, made when it was asked for often; null without.
  Entry of(const CodeList& code, Width width) {
    constexpr std::uint32_t kOften = 200;  // making it costs as much as some hundred runs
    if (code.number == 0) return nullptr;
    Kept& kept = kept_[static_cast<std::size_t>(width)][code.number];
    if (kept.entry != nullptr) return kept.entry;
    if (kept.runs > kOften || ++kept.runs <= kOften) return nullptr;
    return kept.entry = make(code, width);
  }

 private:
  struct Kept {
    Entry entry = nullptr;
    std::uint32_t runs = 0;
  };
  Entry make(const CodeList& code, Width width);

  const Program& program_;
  std::array<std::vector<Kept>, 2> kept_;  ///< by width and number of the list
  std::uint8_t* memory_ = nullptr;
  std::size_t used_ = 0;
  bool failed_ = false;
};

}  // namespace bgsim

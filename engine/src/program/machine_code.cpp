// Encoding: Intel 64 and IA-32 Architectures Software Developer's Manual, volume 2: instruction formats with the VEX
// prefix (2.3), and the instructions' own pages. Calls: System V Application Binary Interface, AMD64 supplement.
#include "program/machine_code.hpp"

#if defined(__x86_64__) && defined(__linux__)

#include <sys/mman.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <initializer_list>
#include <span>
#include <utility>

#include "expression/apply.hpp"
#include "expression/table_cell.hpp"

namespace bgsim {

namespace {

constexpr std::size_t kFour = 4;
/// The longest list that this pays for: longer ones are faster as loops (strips).
constexpr std::size_t kLongestList = 512;
/// For all lists of an evaluator, of which a short one takes some hundred bytes.
constexpr std::size_t kMemory = std::size_t{1} << 18U;

// --- What is called, with the operator's own part of apply_now() alone

template <Op kOp>
[[gnu::flatten]] double call_one(double a, double b, double c) {
  return apply_now(kOp, a, b, c);
}
template <Op kOp>
[[gnu::flatten]] void call_four(double* out, const double* a, const double* b, const double* c, std::size_t points) {
  for (std::size_t l = 0; l < points; ++l) out[l] = apply_now(kOp, a[l], b[l], c[l]);
}

constexpr std::size_t kOperators = static_cast<std::size_t>(Op::der) + 1;
using CallOne = double (*)(double, double, double);
using CallFour = void (*)(double*, const double*, const double*, const double*, std::size_t);

template <std::size_t... kOps>
constexpr auto all_of_one(std::index_sequence<kOps...>) {
  return std::array<CallOne, sizeof...(kOps)>{&call_one<static_cast<Op>(kOps)>...};
}
template <std::size_t... kOps>
constexpr auto all_of_four(std::index_sequence<kOps...>) {
  return std::array<CallFour, sizeof...(kOps)>{&call_four<static_cast<Op>(kOps)>...};
}
constexpr auto kCallOne = all_of_one(std::make_index_sequence<kOperators>());
constexpr auto kCallFour = all_of_four(std::make_index_sequence<kOperators>());

double value_of_table(const Table& values, Op op, double x, double cell) {
  return op == Op::table         ? value_in_cell(values, x, cell)
         : op == Op::table_slope ? slope_in_cell(values, x, cell)
                                 : apply_table(op, values, x);
}
void look_up_one(double* slots, const Program& program, const Instruction& i) {
  const double cell = i.c == kNoSlot ? -1.0 : slots[i.c];
  slots[i.out] = value_of_table(program.pool.table(TableId(i.b)), i.op, slots[i.a], cell);
}
void look_up_four(double* slots, const Program& program, const Instruction& i, std::size_t points) {
  for (std::size_t l = 0; l < points; ++l) {
    const double cell = i.c == kNoSlot ? -1.0 : slots[kFour * i.c + l];
    slots[kFour * i.out + l] = value_of_table(program.pool.table(TableId(i.b)), i.op, slots[kFour * i.a + l], cell);
  }
}

struct Masks {
  alignas(32) std::array<std::uint64_t, kFour> sign;
  alignas(32) std::array<std::uint64_t, kFour> magnitude;
};
constexpr std::uint64_t kSign = std::uint64_t{1} << 63U;
constexpr Masks kMasks{{kSign, kSign, kSign, kSign}, {~kSign, ~kSign, ~kSign, ~kSign}};

// --- Encoding

enum Register : std::uint8_t { rax = 0, rcx = 1, rdx = 2, rbx = 3, rsi = 6, rdi = 7, r8 = 8, r12 = 12, r14 = 14 };
enum Prefix : std::uint8_t { none = 0, p66 = 1, pf2 = 3 };
constexpr unsigned kNoRegister = 0xff;
constexpr std::uint8_t kLoad = 0x10, kStore = 0x11, kRoot = 0x51, kAnd = 0x54, kXor = 0x57, kAdd = 0x58, kMul = 0x59,
                       kSub = 0x5c, kDiv = 0x5e;

class Encoder {
 public:
  /// @param memory  to write to
  Encoder(const Program& program, const CodeList& code, MachineCode::Width width, std::span<std::uint8_t> memory)
      : program_(program), code_(code), four_(width == MachineCode::Width::four), memory_(memory) {
    slot_in_.fill(kNoSlot);
  }

  /// @return  bytes written; more than there are where the memory does not suffice.
  std::size_t encode() {
    bytes({0x53, 0x41, 0x54, 0x41, 0x56});  // push rbx, r12, r14: the stack is at a multiple of 16 then
    bytes({0x48, 0x89, 0xfb});              // mov rbx, rdi: the slots
    bytes({0x49, 0x89, 0xf4});              // mov r12, rsi: points
    bytes({0x49, 0xbe});                    // mov r14, masks
    number(&kMasks);
    for (const Instruction& i : code_) take(i);
    if (four_) leave_upper_halves();
    bytes({0x41, 0x5e, 0x41, 0x5c, 0x5b, 0xc3});  // pop r14, r12, rbx; ret
    return size_;
  }

 private:
  void byte(unsigned value) {
    if (size_ < memory_.size()) memory_[size_] = static_cast<std::uint8_t>(value);
    ++size_;
  }
  void bytes(std::initializer_list<std::uint8_t> list) {
    for (const std::uint8_t value : list) byte(value);
  }
  template <class Value>
  void number(const Value& value) {
    std::array<std::uint8_t, sizeof(Value)> raw{};  // NOLINT(bugprone-sizeof-expression): a pointer is meant as one
    std::memcpy(raw.data(), &value, raw.size());
    for (const std::uint8_t one : raw) byte(one);
  }
  [[nodiscard]] std::int32_t offset(std::uint32_t slot) const {
    return static_cast<std::int32_t>((four_ ? kFour : 1) * sizeof(double) * slot);
  }

  /// The prefix and the operation. @p reg is the register operand, @p first the first source, @p other the register
  /// (or the base) of the second.
  void vex(Prefix prefix, std::uint8_t operation, unsigned reg, unsigned first, unsigned other, bool wide) {
    byte(0xc4);
    byte((reg < 8 ? 0x80U : 0U) | 0x40U | (other < 8 ? 0x20U : 0U) | 1U);
    byte(((~first & 15U) << 3U) | (wide ? 4U : 0U) | prefix);
    byte(operation);
  }
  void with_memory(Prefix prefix, std::uint8_t operation, unsigned reg, unsigned first, Register base, std::int32_t at,
                   bool wide) {
    vex(prefix, operation, reg, first, base, wide);
    byte(0x80U | ((reg & 7U) << 3U) | (base & 7U));
    number(at);
  }
  void with_register(Prefix prefix, std::uint8_t operation, unsigned reg, unsigned first, unsigned second, bool wide) {
    vex(prefix, operation, reg, first, second, wide);
    byte(0xc0U | ((reg & 7U) << 3U) | (second & 7U));
  }
  [[nodiscard]] Prefix arithmetic() const { return four_ ? p66 : pf2; }
  void leave_upper_halves() { bytes({0xc5, 0xf8, 0x77}); }  // vzeroupper: called code may be older than AVX

  // Registers hold what slots hold; each result is in its slot, too.
  [[nodiscard]] unsigned register_of(std::uint32_t slot) {
    const auto found = std::find(slot_in_.begin(), slot_in_.end(), slot);
    if (found == slot_in_.end()) return kNoRegister;
    const auto r = static_cast<unsigned>(found - slot_in_.begin());
    last_used_[r] = ++clock_;
    return r;
  }
  void keep(std::uint32_t slot, unsigned in) {
    std::replace(slot_in_.begin(), slot_in_.end(), slot, kNoSlot);
    slot_in_[in] = slot;
    last_used_[in] = ++clock_;
  }
  /// The one that was used least lately.
  [[nodiscard]] unsigned any_register() const {
    return static_cast<unsigned>(std::min_element(last_used_.begin(), last_used_.end()) - last_used_.begin());
  }
  unsigned load(std::uint32_t slot) {
    if (const unsigned known = register_of(slot); known != kNoRegister) return known;
    const unsigned r = any_register();
    with_memory(arithmetic(), kLoad, r, 0, rbx, offset(slot), four_);
    keep(slot, r);
    return r;
  }
  void store(std::uint32_t slot, unsigned from) {
    with_memory(arithmetic(), kStore, from, 0, rbx, offset(slot), four_);
    keep(slot, from);
  }

  void combine(const Instruction& i, std::uint8_t operation) {
    const unsigned a = load(i.a);
    const unsigned b = register_of(i.b), to = any_register();
    if (b != kNoRegister)
      with_register(arithmetic(), operation, to, a, b, four_);
    else
      with_memory(arithmetic(), operation, to, a, rbx, offset(i.b), four_);
    store(i.out, to);
  }
  void mask(const Instruction& i, std::uint8_t operation, std::size_t at) {
    const unsigned a = load(i.a), to = any_register();
    with_memory(p66, operation, to, a, r14, static_cast<std::int32_t>(at), four_);
    store(i.out, to);
  }
  void root(const Instruction& i) {
    const unsigned a = load(i.a), to = any_register();
    with_register(arithmetic(), kRoot, to, four_ ? 0 : a, a, four_);
    store(i.out, to);
  }

  void address(unsigned reg, std::uint32_t slot) {  // lea reg, [rbx + offset]
    byte(reg < 8 ? 0x48 : 0x4c);
    byte(0x8d);
    byte(0x80U | ((reg & 7U) << 3U) | rbx);
    number(offset(slot));
  }
  template <class Function>
  void call(Function* function) {
    if (four_) leave_upper_halves();
    bytes({0x48, 0xb8});  // mov rax, function
    number(function);
    bytes({0xff, 0xd0});
    slot_in_.fill(kNoSlot);
  }
  void call_operator(const Instruction& i) {
    const auto op = static_cast<std::size_t>(i.op);
    if (four_) {
      address(rdi, i.out);
      address(rsi, i.a);
      address(rdx, i.b);
      address(rcx, i.c);
      bytes({0x4d, 0x89, 0xe0});  // mov r8, r12
      call(kCallFour[op]);
      return;
    }
    const std::array<std::uint32_t, 3> arguments{i.a, i.b, i.c};
    for (unsigned k = 0; k < static_cast<unsigned>(arity(i.op)); ++k)
      with_memory(pf2, kLoad, k, 0, rbx, offset(arguments[k]), false);
    call(kCallOne[op]);
    store(i.out, 0);
  }
  void look_up(const Instruction& i) {
    bytes({0x48, 0x89, 0xdf});  // mov rdi, rbx
    bytes({0x48, 0xbe});        // mov rsi, program
    number(&program_);
    bytes({0x48, 0xba});  // mov rdx, instruction
    number(&i);
    if (four_) {
      bytes({0x4c, 0x89, 0xe1});  // mov rcx, r12
      call(&look_up_four);
    } else {
      call(&look_up_one);
    }
  }

  void take(const Instruction& i) {
    switch (i.op) {
      case Op::add:
        return combine(i, kAdd);
      case Op::sub:
        return combine(i, kSub);
      case Op::mul:
        return combine(i, kMul);
      case Op::div:
        return combine(i, kDiv);
      case Op::neg:
        return mask(i, kXor, offsetof(Masks, sign));
      case Op::abs:
        return mask(i, kAnd, offsetof(Masks, magnitude));
      case Op::sqrt:
        return root(i);
      default:
        return is_table(i.op) ? look_up(i) : call_operator(i);
    }
  }

  const Program& program_;
  const CodeList& code_;
  bool four_;
  std::span<std::uint8_t> memory_;
  std::size_t size_ = 0;
  std::array<std::uint32_t, 16> slot_in_{}, last_used_{};  ///< by register
  std::uint32_t clock_ = 0;
};

}  // namespace

MachineCode::MachineCode(const Program& program) : program_(program) {
  kept_.fill(std::vector<Kept>(program.code_lists));
}

MachineCode::~MachineCode() {
  if (memory_ != nullptr) munmap(memory_, kMemory);
}

MachineCode::Entry MachineCode::make(const CodeList& code, Width width) {
  // Offsets are of 31 bits.
  constexpr std::size_t kMostSlots = std::size_t{1} << 25U;
  static const bool known = __builtin_cpu_supports("avx") != 0;
  if (!known || failed_ || code.size() == 0 || code.size() > kLongestList || program_.slots > kMostSlots)
    return nullptr;
  // Memory is written to or run, never both at once.
  if (memory_ == nullptr) {
    void* const memory = mmap(nullptr, kMemory, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    failed_ = memory == MAP_FAILED;
    if (failed_) return nullptr;
    memory_ = static_cast<std::uint8_t*>(memory);
  } else if (mprotect(memory_, kMemory, PROT_READ | PROT_WRITE) != 0) {
    failed_ = true;  // what is there can still be run
    return nullptr;
  }
  std::uint8_t* const begin = memory_ + used_;
  const std::size_t size = Encoder(program_, code, width, {begin, kMemory - used_}).encode();
  const bool whole = size <= kMemory - used_;
  constexpr std::size_t kAligned = 32;
  if (whole) used_ = std::min(kMemory, (used_ + size + kAligned - 1) / kAligned * kAligned);
  if (mprotect(memory_, kMemory, PROT_READ | PROT_EXEC) != 0) {
    // Nothing of it can be run any more.
    failed_ = true;
    for (std::vector<Kept>& kept : kept_)
      for (Kept& one : kept) one.entry = nullptr;
    return nullptr;
  }
  return whole ? std::bit_cast<Entry>(begin) : nullptr;
}

}  // namespace bgsim

#else

namespace bgsim {

MachineCode::MachineCode(const Program& program) : program_(program) {
  kept_.fill(std::vector<Kept>(program.code_lists));
}
MachineCode::~MachineCode() = default;
MachineCode::Entry MachineCode::make(const CodeList&, Width) { return nullptr; }

}  // namespace bgsim

#endif

#include "run/integrate/butcher_tables.hpp"

#include <arkode/arkode_butcher_dirk.h>
#include <arkode/arkode_butcher_erk.h>

#include <array>
#include <new>

namespace bgsim {

namespace {

constexpr double kThird = 1.0 / 3.0, kSixth = 1.0 / 6.0;

/// @param a  by rows.
template <std::size_t kStages>
ARKodeButcherTable create(int order, std::array<double, kStages> c, std::array<double, kStages * kStages> a,
                          std::array<double, kStages> b) {
  return ARKodeButcherTable_Create(static_cast<int>(kStages), order, 0, c.data(), a.data(), b.data(), nullptr);
}

ARKodeButcherTable load(Method method) {
  switch (method) {
    case Method::erk2:
      return ARKodeButcherTable_LoadERK(ARKODE_HEUN_EULER_2_1_2);
    case Method::erk3:
      return ARKodeButcherTable_LoadERK(ARKODE_BOGACKI_SHAMPINE_4_2_3);
    case Method::erk4:
      return ARKodeButcherTable_LoadERK(ARKODE_ZONNEVELD_5_3_4);
    case Method::erk5:
      return ARKodeButcherTable_LoadERK(ARKODE_DORMAND_PRINCE_7_4_5);
    case Method::erk6:
      return ARKodeButcherTable_LoadERK(ARKODE_VERNER_8_5_6);
    case Method::erk8:
      return ARKodeButcherTable_LoadERK(ARKODE_FEHLBERG_13_7_8);
    case Method::dirk2:
      return ARKodeButcherTable_LoadDIRK(ARKODE_TRBDF2_3_3_2);
    case Method::dirk3:
      return ARKodeButcherTable_LoadDIRK(ARKODE_ESDIRK325L2SA_5_2_3);
    case Method::dirk4:
      return ARKodeButcherTable_LoadDIRK(ARKODE_ESDIRK436L2SA_6_3_4);
    case Method::dirk5:
      return ARKodeButcherTable_LoadDIRK(ARKODE_ESDIRK547L2SA2_7_4_5);
    case Method::euler:
      return create<1>(1, {0.0}, {0.0}, {1.0});
    case Method::implicit_euler:
      return create<1>(1, {1.0}, {1.0}, {1.0});
    case Method::rk4:
      return create<4>(4, {0.0, 0.5, 0.5, 1.0},
                       {0.0, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0},
                       {kSixth, kThird, kThird, kSixth});
    default:
      return nullptr;
  }
}

}  // namespace

ButcherTableHandle butcher_table(Method method) {
  ButcherTableHandle table(load(method));
  if (!table) throw std::bad_alloc();
  return table;
}

}  // namespace bgsim

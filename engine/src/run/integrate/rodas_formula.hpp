/// Rodas5P, a Rosenbrock method of order 5 with eight stages, stiffly accurate: its coefficients.
#pragma once

#include <array>
#include <cstddef>

namespace bgsim::rodas {

inline constexpr std::size_t kStages = 8;

/// In the form without products with the Jacobian: stage i solves
///
///     (I/gamma - h J) U_i = h f(t + kAt_i h, y + sum kState_ij U_j) + sum kRight_ij U_j + kTime_i h^2 f_t,
///
/// sums over j < i, and the step ends at y + sum kState_8j U_j + U_8, where U_8 is also the distance from the embedded
/// formula of order 4. The numbers have the digits of a double; tests derive the order conditions from them.
/// @cite steinebach2023 (table 3), hairer1996 IV.7
inline constexpr double kGamma = 0.21193756319429014;
inline constexpr double kShift = 1.0 / kGamma;
inline constexpr std::array<double, kStages> kAt = {
    0.0, 0.6358126895828704, 0.4095798393397535, 0.9769306725060716, 0.4288403609558666, 1.0, 1.0, 1.0};
inline constexpr std::array<double, kStages> kTime = {0.21193756319429014,
                                                      -0.42387512638858027,
                                                      -0.3384627126235924,
                                                      1.8046452872882734,
                                                      2.325825639765069,
                                                      0.0,
                                                      0.0,
                                                      0.0};
inline constexpr std::array<std::array<double, 7>, 8> kState = {
    {{0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0},
     {3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0},
     {2.849394379747939, 0.45842242204463923, 0.0, 0.0, 0.0, 0.0, 0.0},
     {-6.954028509809101, 2.489845061869568, -10.358996098473584, 0.0, 0.0, 0.0, 0.0},
     {2.8029986275628964, 0.5072464736228206, -0.3988312541770524, -0.04721187230404641, 0.0, 0.0, 0.0},
     {-7.502846399306121, 2.561846144803919, -11.627539656261098, -0.18268767659942256, 0.030198172008377946, 0.0, 0.0},
     {-7.502846399306121, 2.561846144803919, -11.627539656261098, -0.18268767659942256, 0.030198172008377946, 1.0, 0.0},
     {-7.502846399306121, 2.561846144803919, -11.627539656261098, -0.18268767659942256, 0.030198172008377946, 1.0,
      1.0}}};
inline constexpr std::array<std::array<double, 7>, 8> kRight = {
    {{0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0},
     {-14.155112264123755, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0},
     {-17.97296035885952, -2.859693295451294, 0.0, 0.0, 0.0, 0.0, 0.0},
     {147.12150275711716, -1.41221402718213, 71.68940251302358, 0.0, 0.0, 0.0, 0.0},
     {165.43517024871676, -0.4592823456491126, 42.90938336958603, -5.961986721573306, 0.0, 0.0, 0.0},
     {24.854864614690072, -3.0009227002832186, 47.4931110020768, 5.5814197821558125, -0.6610691825249471, 0.0, 0.0},
     {30.91273214028599, -3.1208243349937974, 77.79954646070892, 34.28646028294783, -19.097331116725623,
      -28.087943162872662, 0.0},
     {37.80277123390563, -3.2571969029072276, 112.26918849496327, 66.9347231244047, -40.06618937091002,
      -54.66780262877968, -9.48861652309627}}};

/// Dense output of order 4: with D_k = sum kDense_kj U_j, at y + u (y_1 - y) + u (1 - u) (D_1 + u (D_2 + u D_3)).
inline constexpr std::array<std::array<double, 8>, 3> kDense = {
    {{25.948786856663858, -2.5579724845846235, 10.433815404888879, -2.3679251022685204, 0.524948541321073,
      1.1241088310450404, 0.4272876194431874, -0.17202221070155493},
     {-9.91568850695171, -0.9689944594115154, 3.0438037242978453, -24.495224566215796, 20.176138334709044,
      15.98066361424651, -6.789040303419874, -6.710236069923372},
     {11.419903575922262, 2.8879645146136994, 72.92137995996029, 80.12511834622643, -52.072871366152654,
      -59.78993625266729, -0.15582684282751913, 4.883087185713722}}};

/// The dense output is held to the equations at one point. With the residual d = h f - p' there, the solution of
/// (I/gamma - h J) e = d is what the polynomial is wrong by, times the bubble's value, if it is wrong by a multiple of
/// u^2 (1 - u)^2: at this point the slope of that is 1/gamma times its value. It is also in the widest gap between the
/// stages' times, so what comes and goes there within a step is seen.
constexpr double bubble(double u) { return u * u * (1.0 - u) * (1.0 - u); }
inline constexpr double kCheckedAt = 0.2683828512465044;
inline constexpr double kLargestBubble = 1.0 / 16.0;

}  // namespace bgsim::rodas

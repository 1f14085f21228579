/// Linear complementarity, as ideal diodes pose it.
#pragma once

#include <cstddef>
#include <vector>

#include "base/power_series.hpp"

namespace bgsim {

/// Z z + W w = r with n rows; z >= 0, w >= 0 and z_i w_i = 0 are wanted.
struct Complementarity {
  struct Entry {
    std::size_t column = 0;
    PowerSeries value;
  };
  std::size_t size = 0;
  std::vector<std::vector<Entry>> z, w;  ///< by row: what is not 0
  std::vector<PowerSeries> r;
};

/// Powers of two by which rows, and the unknowns of pairs, are divided: these do not round.
struct ComplementarityUnits {
  std::vector<int> row, z, w;
};

struct ComplementarySides {
  bool solved = false;
  /// By pair: whether z_i is the one that may differ from 0. Together they are a basis: with all others at 0, the rows
  /// determine them.
  std::vector<bool> takes_z;
  std::vector<PowerSeries> value;      ///< by pair: of z_i or of w_i, whichever it is
  std::vector<std::size_t> unbounded;  ///< where there is no solution: the pairs on the ray that shows it
};

/// The problem in these units, and what was found in them as it is.
void scale(Complementarity& problem, const ComplementarityUnits& units);
void scale_back(ComplementarySides& sides, const ComplementarityUnits& units);

/// Solves by Lemke's method with lexicographic ratios, from the basis nearest to @p first. It ends for every problem;
/// where the relation between z and w is monotone (what a passive network makes of its ports), the end is a
/// solution or a proof that there is none.
/// @param first  by pair: z_i is the one to begin with. As a basis it need not be regular.
/// @param held   by pair: z_i is 0 and w_i of any sign.
/// @param open   where nothing else is found, a solution with values of which the series say no more than that they
///               are 0 as far as these are known
/// @note n pivots of n^2 operations as a rule, exponential at the worst; ended after 50 (n + 10) of them, unsolved.
ComplementarySides solve_complementarity(const Complementarity& problem, const std::vector<bool>& first,
                                         const std::vector<bool>& held, bool open = false);

}  // namespace bgsim

/// Long curves for the screen: fewer points, the same picture.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace bgsim::cli {

/// Indices, increasing, of the points of a curve that its picture needs. Where x never decreases, the range of x is cut
/// into @p buckets, and of each the first and last point and those of least and greatest y stay: every extreme is
/// there, at its place to the width of a bucket (M4, @cite jugel2014). Other curves (x over y) lose points that lie
/// within a @p buckets -th of the ranges from the last one that stayed.
/// @param x, y  of one length. @note Time linear in the length; at most 4 points in a bucket.
std::vector<std::size_t> thinned(std::span<const double> x, std::span<const double> y, std::size_t buckets);

}  // namespace bgsim::cli

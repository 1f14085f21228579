/// The times at which a run is recorded.
#pragma once

#include <cstddef>
#include <initializer_list>
#include <utility>
#include <vector>

namespace bgsim {

/// Increasing times. Equidistant ones are worked out one by one, so that their number costs no memory; any others are
/// a list.
class OutputTimes {
 public:
  OutputTimes() = default;
  /// A list is used wherever times are required.
  /// @pre increasing
  OutputTimes(std::vector<double> list)  // NOLINT(google-explicit-constructor)
      : list_(std::move(list)), count_(list_.size()) {}
  OutputTimes(std::initializer_list<double> list) : OutputTimes(std::vector<double>(list)) {}

  /// @p count times from @p start to @p stop, which is the last one.
  /// @pre count > 0, and start < stop if it is above 1
  static OutputTimes equidistant(double start, double stop, std::size_t count);
  /// @p start, @p start + @p interval and so on, then @p stop: @p count times.
  /// @pre count > 0, and the last multiple before stop is that of count - 2
  static OutputTimes at_multiples(double start, double stop, double interval, std::size_t count);

  [[nodiscard]] std::size_t size() const { return count_ - first_; }
  [[nodiscard]] bool empty() const { return size() == 0; }
  /// @pre i < size()
  [[nodiscard]] double operator[](std::size_t i) const;
  /// @pre not empty
  [[nodiscard]] double front() const { return (*this)[0]; }
  [[nodiscard]] double back() const { return (*this)[size() - 1]; }
  /// These without the first @p count, or none if there are no more.
  [[nodiscard]] OutputTimes without_first(std::size_t count) const;
  /// Position of the first one after @p t; size() if there is none.
  [[nodiscard]] std::size_t first_after(double t) const;
  /// All of them, in memory.
  [[nodiscard]] std::vector<double> list() const;

 private:
  enum class Form { list, shares, multiples };

  std::vector<double> list_;  ///< of the form list only
  std::size_t count_ = 0;     ///< with those that are left out
  std::size_t first_ = 0;     ///< that is not left out
  Form form_ = Form::list;
  double start_ = 0.0, stop_ = 0.0;
  double interval_ = 0.0;  ///< of the form multiples only
};

}  // namespace bgsim

/// verify: holds a run's trace against a reference trace, or against the trace of another run.
#pragma once

#include <string>
#include <vector>

#include "bgsim/csv.hpp"
#include "bgsim/simulate.hpp"

namespace bgsim {

/// A column held against its reference. A value is accepted if it lies between the least and the greatest value that
/// the reference takes within [t - tube, t + tube] (linear between its records), widened on both sides by
/// `limit` = relative * (largest magnitude of the reference's column) + absolute. With tube 0 that is |x - reference|
/// <= limit.
struct ColumnCheck {
  std::string output;     ///< name in the trace
  std::string reference;  ///< name in the reference
  double limit = 0.0;
  double error = 0.0;                         ///< largest distance from the reference's range within the tube
  double time = 0.0;                          ///< where that is
  double value = 0.0, low = 0.0, high = 0.0;  ///< the trace's value there, and the reference's range
  [[nodiscard]] bool ok() const { return error <= limit; }
};

struct ReferenceCheck {
  std::vector<ColumnCheck> columns;  ///< in the trace's order
  std::vector<std::string> unused;   ///< columns of the reference that no output is held against
  std::vector<std::string> unheld;   ///< outputs that the reference has no column for
  [[nodiscard]] bool ok() const;
};

/// Reads the reference that a scene names.
/// @throws ModelError BG150 the file cannot be read, is no table of numbers, has no column t, or times that do not
///         increase; with the place in the model and the line in the file.
CsvTable read_reference(const Model& model, const Reference& reference);

/// The scene's inputs with the reference's times as output times, so that nothing is interpolated.
/// @throws ModelError BG151 a reference whose times lie outside of the scene's.
RunInputs at_reference_times(const Model& model, const RunInputs& inputs, const CsvTable& table);

/// Holds @p trace, computed at_reference_times, against @p table. Outputs are paired with columns of the same name, or
/// as Reference::columns says.
/// @throws ModelError BG152 a column that Reference::columns names is in neither, or nothing at all is in both.
/// @note Cost: the trace's size times the reference's records within one tube.
ReferenceCheck hold_against(const Model& model, const Trace& trace, const CsvTable& table, const Reference& reference);

/// A column of a reference as an output is held against it, for drawing: at each of the reference's times the record,
/// and the least and greatest value that is accepted there.
struct ReferenceBand {
  std::string output, reference;  ///< names as in ColumnCheck
  double limit = 0.0;
  std::vector<double> values, low, high;
};

/// The bands of all outputs that @p table has a column for, in the order of @p outputs.
/// @throws ModelError BG152 as hold_against.
std::vector<ReferenceBand> reference_bands(const Model& model, const std::vector<std::string>& outputs,
                                           const CsvTable& table, const Reference& reference);

/// The largest distance of an output from another run's, relative to that one's range over the scene.
struct OutputError {
  std::string output;
  double error = 0.0;  ///< infinite where the other run's output is constant 0 and this one is not
  double rms = 0.0;
  double time = 0.0;  ///< of the largest
};
/// By output: @p reduced against @p full. Both traces have the same times and columns.
std::vector<OutputError> output_errors(const Trace& full, const Trace& reduced);
/// The largest of them.
OutputError worst(const std::vector<OutputError>& errors);

}  // namespace bgsim

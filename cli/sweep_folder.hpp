/// The folder of a sweep: what it is of, and a log for each process that works on it.
#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "bgsim/sweep.hpp"

namespace bgsim::cli {

/// Runs k, k + of, k + 2 of, ... of a sweep; k from 0.
struct Shard {
  std::uint64_t number = 0, of = 1;
  [[nodiscard]] bool has(std::uint64_t run) const { return run % of == number; }
};

/// What two processes must agree on to work on one sweep: the model's files, options, plan, results.
nlohmann::ordered_json sweep_identity(const Model& model, const RunInputs& inputs,
                                      const std::vector<std::string>& options, const SweepPlan& plan,
                                      std::uint64_t runs, const SweepResults& results);

/// Makes @p folder, or sees that it holds the same sweep.
/// @throws UsageError  it holds another one (what differs), or no sweep but other files; it cannot be written.
void enter_sweep(const std::string& folder, const nlohmann::ordered_json& identity);
/// What enter_sweep() wrote. @throws UsageError if there is no sweep.
nlohmann::ordered_json sweep_in(const std::string& folder);

/// A run as a record of a log: number, values, as many results, status, number of notes, and the first or what failed.
std::string sweep_record(const SweepRun& run, std::size_t results);
/// The head of the columns.
std::string sweep_header(const nlohmann::ordered_json& identity);

/// The log of one shard: records are only ever added. After a crash it ends with a part of one, which is cut off.
class SweepLog {
 public:
  /// @param shard  none: of a sweep that processes share, the first log that no other process writes
  /// @throws UsageError  another process writes it; it has other columns; the system's reason.
  SweepLog(const std::string& folder, const std::optional<Shard>& shard, const std::string& header);
  ~SweepLog();
  SweepLog(const SweepLog&) = delete;
  SweepLog& operator=(const SweepLog&) = delete;

  void add(const std::string& record);
  /// Hands all over to the system. @throws UsageError with its reason.
  void flush();

 private:
  /// @return false if another process writes it
  bool open(const std::string& path);
  std::string path_, pending_;
  int file_ = -1;
};

/// The whole records of all logs in @p folders by number of run, each run once.
/// @throws UsageError  a log has other columns, or a record of none of the @p runs.
std::map<std::uint64_t, std::string> read_logs(const std::vector<std::string>& folders, const std::string& header,
                                               std::uint64_t runs);

}  // namespace bgsim::cli

/// The programs of one run of a model with switches and delayed signals.
#pragma once

#include <map>
#include <memory>

#include "run/diodes.hpp"
#include "run/watch/delay_lines.hpp"

namespace bgsim {

/// Copies of programs that are shared between runs, all with the same tables for the delayed signals, which are of one
/// run. Without delayed signals it gives the programs themselves.
class DelayedPrograms {
 public:
  /// @param program  any one of the model
  explicit DelayedPrograms(const Program& program) : tables_(own_tables(program)) {}

  [[nodiscard]] const DelayTables& tables() const { return tables_; }
  const Program& of(const Program& shared) {
    if (tables_.empty()) return shared;
    std::unique_ptr<Program>& own = programs_[&shared];
    if (!own) own = std::make_unique<Program>(with_tables(shared, tables_));
    return *own;
  }
  const DiodeNetwork& of(const DiodeNetwork& shared) { return of(shared, networks_); }
  const ImpactProgram& of(const ImpactProgram& shared) { return of(shared, impacts_); }

 private:
  template <class Shared>
  const Shared& of(const Shared& shared, std::map<const Shared*, std::unique_ptr<Shared>>& kept) {
    if (tables_.empty()) return shared;
    std::unique_ptr<Shared>& own = kept[&shared];
    if (!own) {
      own = std::make_unique<Shared>(shared);
      own->program = with_tables(shared.program, tables_);
    }
    return *own;
  }

  DelayTables tables_;
  std::map<const Program*, std::unique_ptr<Program>> programs_;  ///< by what they are copies of
  std::map<const DiodeNetwork*, std::unique_ptr<DiodeNetwork>> networks_;
  std::map<const ImpactProgram*, std::unique_ptr<ImpactProgram>> impacts_;
};

}  // namespace bgsim

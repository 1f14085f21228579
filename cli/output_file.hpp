/// A result on its way to disk: whole under its own name, or not there at all.
#pragma once

#include <sys/stat.h>

#include <initializer_list>
#include <ostream>
#include <string>

#include "descriptor_buffer.hpp"

namespace bgsim::cli {

/// A file that is written beside its target, as NAME.partial, and renamed onto it when it is complete. Until then the
/// target keeps what it holds, whatever fails.
///
/// * Symbolic links stay: the file they point to is replaced. Its permissions are kept.
/// * The partial file is locked while it is written (flock): a second writer of the same target is refused. A partial
///   file without a lock was left by a run that was killed; it is replaced, as that run's target would have been.
/// * A target that cannot be replaced by renaming (its folder cannot be written to, or it is a mount point) is
///   overwritten in place when all is known, after its space has been reserved.
/// * Devices, pipes, /dev/stdout and "-" are written directly.
class OutputFile {
 public:
  /// @param path  "-": standard output.
  /// @throws UsageError with the system's reason: no such folder, no permission, another writer.
  explicit OutputFile(const std::string& path);
  /// Without commit() or keep(), removes the partial file.
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  std::ostream& stream() { return stream_; }
  /// Hands what was written to the system, so that it outlives the process.
  /// @throws UsageError with the system's reason: disk full, file size limit, closed pipe.
  void flush();
  /// flush(), and waits until the disk has it. After this only the renaming can fail.
  /// @throws UsageError
  void finish();
  /// finish(), then the target is replaced.
  /// @throws UsageError; the target stays as it was.
  void commit();
  /// Leaves the partial file where it is, for what was written up to now is worth having; or not, after all.
  void keep(bool kept = true) { kept_ = kept; }
  /// Bytes that the system has taken so far.
  [[nodiscard]] std::size_t written() const { return buffer_.written(); }
  /// The partial file; "" if there is none, since the target is written directly or in place.
  [[nodiscard]] std::string partial() const;

 private:
  void open_target();
  void open_direct(const std::string& file);
  void open_beside(const std::string& file);
  void open_in_place(const std::string& file);
  void lock_existing(const std::string& file);
  bool create_partial();
  bool remove_stale();
  void take_permissions();
  void copy_in_place();
  void drop() noexcept;
  void leave();
  [[nodiscard]] bool is_ours() const;
  void rename_onto_target();
  friend void remove_partial_files();
  friend void commit_all(std::initializer_list<OutputFile*> files);
  [[noreturn]] void fail(int error) const;
  [[noreturn]] void fail(const std::string& reason) const;

  /// A descriptor, closed at the end.
  struct Descriptor {
    int value = -1;
    Descriptor() = default;
    ~Descriptor();
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    Descriptor& operator=(int opened);
  };

  std::string path_;          ///< as given
  std::string name_;          ///< the target within folder_, links followed
  std::string partial_;       ///< within folder_; "" if there is none
  Descriptor folder_, file_;  ///< file_: what is written
  Descriptor target_;         ///< of a target that is overwritten in place
  struct stat old_ {};        ///< the target as it was
  bool exists_ = false, kept_ = false, done_ = false;
  DescriptorBuffer buffer_;
  std::ostream stream_;
  OutputFile *next_ = nullptr, **previous_ = nullptr;  ///< all that are not complete
};

/// Completes several results of one command: all are on disk before the first target is replaced.
/// @throws UsageError
void commit_all(std::initializer_list<OutputFile*> files);

/// Removes the partial files of all OutputFiles that are not complete and not kept: for a process that ends now.
/// Safe within a signal handler.
void remove_partial_files();

/// Where an OutputFile of @p path is written before it is complete; "" for standard output.
std::string partial_path(const std::string& path);

}  // namespace bgsim::cli

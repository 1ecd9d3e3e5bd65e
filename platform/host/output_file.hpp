// Files that exist complete or not at all: written under a temporary name in the same directory and renamed by commit().
// An uncommitted output removes its temporary when it goes out of scope, also after Ctrl-C (platform/host/interrupt.hpp).
// A path that is no regular file (/dev/null, a pipe) is written to directly. Errors are UserError and name the path.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace aluminate::host {

class OutputFile {
 public:
  /// Creates the temporary, so an unwritable place is an error before any work is done.
  explicit OutputFile(std::string path);
  ~OutputFile();
  OutputFile(OutputFile&& other) noexcept;
  OutputFile& operator=(OutputFile&& other) noexcept;
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  const std::string& path() const { return path_; }
  const std::string& temporary_path() const { return temporary_; }  // empty when written to directly

  void write(std::string_view text);
  void write(std::span<const std::uint8_t> bytes);

  /// Flushes to the disk, closes and renames. At most once; nothing may be written after it.
  void commit();

 private:
  friend class OutputSet;
  void close_for_commit();
  void rename_into_place();
  void discard() noexcept;

  std::string path_, target_, temporary_;  // target_: path_ with symbolic links followed, absolute
  int descriptor_ = -1;
  int removal_slot_ = -1;
  bool committed_ = false;
};

/// Outputs that belong together: commit() first flushes and closes all of them and only then renames them, so a full
/// disk or a write error leaves every old file as it was.
class OutputSet {
 public:
  /// The reference stays valid as long as the set. A path named twice is an error.
  OutputFile& add(std::string path);
  void commit();

 private:
  std::vector<std::unique_ptr<OutputFile>> files_;
};

/// Throws UserError when an output could not be created at path: its directory is missing or not writable, or it is a
/// directory itself. Leaves nothing behind.
void check_writable(const std::string& path);

/// Creates a directory and its parents; fine when it exists.
void make_directories(const std::string& path);

/// One whole file, atomically.
void write_file(const std::string& path, std::string_view text);
void write_file(const std::string& path, std::span<const std::uint8_t> bytes);

}  // namespace aluminate::host

// Numbered locks in one file, for processes (on one machine or on several that share the folder) that divide
// work among themselves. A lock is gone when its holder lets go of it or dies, however it dies: what it held
// can be taken over.
#pragma once

#include <cstddef>
#include <string>

namespace aluminate::host {

/// Opens or creates `path`, which stays empty. Locks are advisory and belong to this object, not to the
/// process. UserError when the file cannot be opened, or its file system has no locks.
class LockFile {
 public:
  explicit LockFile(std::string path);
  ~LockFile();
  LockFile(const LockFile&) = delete;
  LockFile& operator=(const LockFile&) = delete;

  /// False when somebody else holds it.
  bool try_lock(std::size_t number);
  /// Waits for its holder. Throws Interrupted after Ctrl-C.
  void lock(std::size_t number);
  void unlock(std::size_t number);

 private:
  bool set(std::size_t number, short type);
  std::string path_;
  int descriptor_ = -1;
};

}  // namespace aluminate::host

#include "platform/host/file_lock.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <thread>

#include "platform/host/error.hpp"
#include "platform/host/interrupt.hpp"

namespace aluminate::host {

LockFile::LockFile(std::string path) : path_(std::move(path)) {
  descriptor_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (descriptor_ < 0)
    throw UserError(SourcePlace{path_}, std::strerror(errno), "the folder must be writable");
}

LockFile::~LockFile() { ::close(descriptor_); }

// Lock n is byte n of the file, which need not exist. Locks of the open file, unlike those of the process,
// also keep two users within one process apart.
bool LockFile::set(std::size_t number, short type) {
  struct flock range {};
  range.l_type = type;
  range.l_whence = SEEK_SET;
  range.l_start = static_cast<off_t>(number);
  range.l_len = 1;
  while (::fcntl(descriptor_, F_OFD_SETLK, &range) != 0) {
    if (errno == EINTR) continue;
    if (errno == EAGAIN || errno == EACCES) return false;
    throw UserError(
        SourcePlace{path_}, std::strerror(errno),
        "this file system has no locks: give each process its own --shard I/N of a folder that has");
  }
  return true;
}

bool LockFile::try_lock(std::size_t number) { return set(number, F_WRLCK); }

// By asking again: a signal handler with SA_RESTART would put a blocking wait back to sleep.
void LockFile::lock(std::size_t number) {
  while (!try_lock(number)) {
    throw_if_interrupted();
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
}

void LockFile::unlock(std::size_t number) { set(number, F_UNLCK); }

}  // namespace aluminate::host

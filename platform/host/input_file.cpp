#include "platform/host/input_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "platform/host/error.hpp"

namespace aluminate::host {
namespace {

struct Descriptor {
  int value;
  ~Descriptor() {
    if (value >= 0) ::close(value);
  }
};

// Buffer: std::string or std::vector<std::uint8_t>. Grows as it reads, so that pipes work as well.
template <class Buffer>
Buffer read_whole(const std::string& path) {
  constexpr std::size_t kStepBytes = std::size_t{1} << 16;
  const Descriptor file{::open(path.c_str(), O_RDONLY | O_CLOEXEC)};
  struct stat facts {};
  if (file.value < 0 || ::fstat(file.value, &facts) != 0) {
    const int reason = errno;
    throw UserError({path}, fmt::format("cannot read the file: {}", std::strerror(reason)),
                    reason == ENOENT ? "check the path; it is relative to the current directory" : "");
  }
  if (S_ISDIR(facts.st_mode)) throw UserError({path}, "expected a file, found a directory");
  if (facts.st_size > kMaxInputBytes) {
    throw UserError({path}, fmt::format("the file has {} bytes, the limit is {}", facts.st_size, kMaxInputBytes));
  }
  Buffer content;
  content.resize(static_cast<std::size_t>(facts.st_size) + 1);  // + 1: the end is seen without another resize
  std::size_t used = 0;
  while (true) {
    if (used == content.size()) content.resize(used + std::max(used, kStepBytes));
    const ssize_t got = ::read(file.value, content.data() + used, content.size() - used);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw UserError({path}, fmt::format("cannot read the file: {}", std::strerror(errno)));
    if (got == 0) break;
    used += static_cast<std::size_t>(got);
    if (used > static_cast<std::size_t>(kMaxInputBytes)) {
      throw UserError({path}, fmt::format("the input goes past the limit of {} bytes", kMaxInputBytes));
    }
  }
  content.resize(used);
  return content;
}

}  // namespace

std::vector<std::uint8_t> read_bytes(const std::string& path) { return read_whole<std::vector<std::uint8_t>>(path); }
std::string read_text(const std::string& path) { return read_whole<std::string>(path); }

}  // namespace aluminate::host

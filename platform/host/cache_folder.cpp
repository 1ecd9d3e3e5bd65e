#include "platform/host/cache_folder.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

namespace aluminate::host {
namespace {

namespace fs = std::filesystem;

bool is_private(const struct ::stat& s) { return s.st_uid == ::geteuid() && (s.st_mode & (S_IWGRP | S_IWOTH)) == 0; }

// The folder, made when it is missing; nothing when there is none to trust.
std::optional<fs::path> cache_folder() {
  const char* xdg = std::getenv("XDG_CACHE_HOME");
  const char* home = std::getenv("HOME");
  fs::path base;
  if (xdg != nullptr && *xdg == '/') {
    base = xdg;
  } else if (home != nullptr && *home == '/') {
    base = fs::path(home) / ".cache";
  } else {
    return std::nullopt;
  }
  std::error_code error;
  fs::create_directories(base, error);
  const fs::path folder = base / "aluminate";
  ::mkdir(folder.c_str(), 0700);
  struct ::stat s {};
  if (::lstat(folder.c_str(), &s) != 0 || !S_ISDIR(s.st_mode) || !is_private(s)) return std::nullopt;
  return folder;
}

class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int number() const { return number_; }

 private:
  int number_;
};

void remove_oldest(const fs::path& folder, const std::string& ending, std::size_t budget) {
  struct Entry {
    fs::file_time_type time;
    std::size_t bytes;
    fs::path path;
  };
  std::vector<Entry> entries;
  std::size_t total = 0;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    if (!entry.path().filename().string().ends_with(ending) || !entry.is_regular_file(error)) continue;
    entries.push_back({entry.last_write_time(error), static_cast<std::size_t>(entry.file_size(error)), entry.path()});
    total += entries.back().bytes;
  }
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) { return a.time < b.time; });
  for (std::size_t i = 0; i < entries.size() && total > budget; ++i) {
    fs::remove(entries[i].path, error);
    total -= entries[i].bytes;
  }
}

}  // namespace

std::optional<std::vector<std::uint8_t>> read_cache_file(const std::string& name) noexcept {
  try {
    const auto folder = cache_folder();
    if (!folder) return std::nullopt;
    // Not blocking: somebody may have put a pipe there.
    const Descriptor file(::open((*folder / name).c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC | O_NONBLOCK));
    struct ::stat s {};
    if (file.number() < 0 || ::fstat(file.number(), &s) != 0 || !S_ISREG(s.st_mode) || !is_private(s)) return std::nullopt;
    if (s.st_size < 0 || static_cast<std::size_t>(s.st_size) > kCacheFileBytes) return std::nullopt;
    std::vector<std::uint8_t> bytes(static_cast<std::size_t>(s.st_size));
    std::size_t got = 0;
    while (got < bytes.size()) {
      const ::ssize_t n = ::read(file.number(), bytes.data() + got, bytes.size() - got);
      if (n <= 0) return std::nullopt;
      got += static_cast<std::size_t>(n);
    }
    return bytes;
  } catch (...) {
    return std::nullopt;
  }
}

void write_cache_file(const std::string& name, std::span<const std::uint8_t> bytes, const std::string& ending,
                      std::size_t budget) noexcept {
  try {
    const auto folder = cache_folder();
    if (!folder || bytes.size() > kCacheFileBytes || bytes.size() > budget) return;
    // The temporary carries the ending too, so that one left behind by a crash is removed with the old files.
    const fs::path temporary = *folder / fmt::format("new-{}-{}", ::getpid(), name);
    {
      const Descriptor file(::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0600));
      if (file.number() < 0) return;
      std::size_t put = 0;
      while (put < bytes.size()) {
        const ::ssize_t n = ::write(file.number(), bytes.data() + put, bytes.size() - put);
        if (n <= 0) break;
        put += static_cast<std::size_t>(n);
      }
      if (put != bytes.size()) {
        ::unlink(temporary.c_str());
        return;
      }
    }
    if (::rename(temporary.c_str(), (*folder / name).c_str()) != 0) ::unlink(temporary.c_str());
    remove_oldest(*folder, ending, budget);
  } catch (...) {
    return;
  }
}

}  // namespace aluminate::host

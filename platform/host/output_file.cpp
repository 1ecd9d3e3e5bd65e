#include "platform/host/output_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

#include "platform/host/error.hpp"
#include "platform/host/interrupt.hpp"

namespace aluminate::host {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const std::string& path, const char* doing, int reason, std::string hint = {}) {
  throw UserError({path}, fmt::format("cannot {}: {}", doing, std::strerror(reason)), std::move(hint));
}

// Where the rename must land: behind symbolic links, so that a link stays a link; absolute, so that a later change of
// the working directory or the signal handler cannot miss it.
fs::path resolved(const std::string& path) {
  if (path.empty()) throw UserError("expected an output path, found an empty one");
  std::error_code error;
  fs::path target = fs::absolute(path, error);
  for (int links = 0; links < 32 && fs::is_symlink(target, error); ++links) {
    const fs::path next = fs::read_symlink(target, error);
    if (error) break;
    target = next.is_absolute() ? next : target.parent_path() / next;
  }
  return target.lexically_normal();
}

// A device or a pipe is written to where it is: renaming over it would replace it.
bool is_special(const struct stat& facts) { return !S_ISREG(facts.st_mode) && !S_ISDIR(facts.st_mode); }

struct Opened {
  int descriptor = -1;
  std::string target, temporary;
};

Opened open_output(const std::string& path) {
  const fs::path target = resolved(path);
  struct stat facts {};
  const bool exists = ::stat(target.c_str(), &facts) == 0;
  if ((exists && S_ISDIR(facts.st_mode)) || !target.has_filename()) {
    throw UserError({path}, "expected a file to write, found a directory", "name a file inside it");
  }
  if (exists && is_special(facts)) {
    const int descriptor = ::open(target.c_str(), O_WRONLY | O_CLOEXEC);
    if (descriptor < 0) fail(path, "write", errno);
    return {descriptor, target, ""};
  }
  const fs::path directory = target.parent_path();
  std::error_code error;
  if (!fs::is_directory(directory, error)) {
    throw UserError({path}, fmt::format("the directory '{}' does not exist", directory.string()),
                    fmt::format("create it first: mkdir -p '{}'", directory.string()));
  }
  static std::atomic<unsigned> serial{0};
  for (int attempt = 0; attempt < 100; ++attempt) {
    // Long names are cut: the temporary must not be longer than the file system allows where the final name is not.
    const std::string name = fmt::format(".{:.200}.{}-{}.tmp", target.filename().string(), ::getpid(), serial++);
    const fs::path temporary = directory / name;
    const int descriptor = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor >= 0) {
      if (exists) (void)::fchmod(descriptor, facts.st_mode & 07777);  // an overwritten file keeps its mode
      return {descriptor, target, temporary};
    }
    if (errno != EEXIST) fail(path, "create the file", errno, "choose a directory you may write to");
  }
  fail(path, "create a temporary file beside it", EEXIST);
}

}  // namespace

OutputFile::OutputFile(std::string path) : path_(std::move(path)) {
  Opened opened = open_output(path_);
  descriptor_ = opened.descriptor;
  target_ = std::move(opened.target);
  temporary_ = std::move(opened.temporary);
  if (!temporary_.empty()) removal_slot_ = arm_removal(temporary_.c_str());
}

OutputFile::~OutputFile() { discard(); }

OutputFile::OutputFile(OutputFile&& other) noexcept
    : path_(std::move(other.path_)),
      target_(std::move(other.target_)),
      temporary_(std::exchange(other.temporary_, {})),
      descriptor_(std::exchange(other.descriptor_, -1)),
      removal_slot_(std::exchange(other.removal_slot_, -1)),
      committed_(std::exchange(other.committed_, true)) {}

OutputFile& OutputFile::operator=(OutputFile&& other) noexcept {
  if (this != &other) {
    discard();
    path_ = std::move(other.path_);
    target_ = std::move(other.target_);
    temporary_ = std::exchange(other.temporary_, {});
    descriptor_ = std::exchange(other.descriptor_, -1);
    removal_slot_ = std::exchange(other.removal_slot_, -1);
    committed_ = std::exchange(other.committed_, true);
  }
  return *this;
}

void OutputFile::discard() noexcept {
  if (descriptor_ >= 0) ::close(std::exchange(descriptor_, -1));
  if (!committed_ && !temporary_.empty()) ::unlink(temporary_.c_str());
  disarm_removal(std::exchange(removal_slot_, -1));
  committed_ = true;
}

void OutputFile::write(std::string_view text) {
  ALU_CHECK(descriptor_ >= 0, "write to {} after its commit", path_);
  const char* from = text.data();
  std::size_t left = text.size();
  constexpr std::size_t kLarge = std::size_t{1} << 20;
  while (left > 0) {
    const ssize_t written = ::write(descriptor_, from, left);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail(path_, "write", errno);
    from += written;
    left -= static_cast<std::size_t>(written);
  }
  // The disk starts on large pieces now, so that commit() need not wait for all of them. A hint: errors show there.
  if (text.size() >= kLarge && !temporary_.empty())
    (void)::sync_file_range(descriptor_, 0, 0, SYNC_FILE_RANGE_WRITE);
}

void OutputFile::write(std::span<const std::uint8_t> bytes) {
  write(std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
}

void OutputFile::close_for_commit() {
  ALU_CHECK(descriptor_ >= 0, "second commit of {}", path_);
  // Pipes and devices cannot be synchronised; for a file it is the moment at which a full disk shows.
  const bool synced = temporary_.empty() || ::fsync(descriptor_) == 0;
  const int sync_error = errno;
  const bool closed = ::close(std::exchange(descriptor_, -1)) == 0;
  if (!synced) fail(path_, "write", sync_error);
  if (!closed) fail(path_, "write", errno);
}

void OutputFile::rename_into_place() {
  if (!temporary_.empty() && ::rename(temporary_.c_str(), target_.c_str()) != 0) fail(path_, "rename into place", errno);
  committed_ = true;
  disarm_removal(std::exchange(removal_slot_, -1));
}

void OutputFile::commit() {
  close_for_commit();
  rename_into_place();
}

OutputFile& OutputSet::add(std::string path) {
  auto file = std::make_unique<OutputFile>(std::move(path));
  for (const auto& other : files_) {
    if (!file->temporary_.empty() && other->target_ == file->target_) {
      throw UserError({file->path()}, "two outputs have this name", "give each output its own file");
    }
  }
  files_.push_back(std::move(file));
  return *files_.back();
}

void OutputSet::commit() {
  for (const auto& file : files_) file->close_for_commit();
  throw_if_interrupted();  // the last moment at which nothing has changed yet
  for (const auto& file : files_) file->rename_into_place();
  files_.clear();
}

void check_writable(const std::string& path) { const OutputFile probe(path); }

void make_directories(const std::string& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (error) throw UserError({path}, fmt::format("cannot create the directory: {}", error.message()));
  if (!fs::is_directory(path, error)) throw UserError({path}, "expected a directory, found a file");
}

void write_file(const std::string& path, std::string_view text) {
  OutputFile file(path);
  file.write(text);
  file.commit();
}

void write_file(const std::string& path, std::span<const std::uint8_t> bytes) {
  OutputFile file(path);
  file.write(bytes);
  file.commit();
}

}  // namespace aluminate::host

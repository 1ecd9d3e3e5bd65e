#include "platform/host/module_file.hpp"

#include <dlfcn.h>

#include <filesystem>
#include <vector>

#include "platform/host/error.hpp"

namespace aluminate::host {

namespace {

namespace fs = std::filesystem;

// Beside the program first, so that an installed or copied build never picks up another build's module.
std::vector<fs::path> find_places(const std::string& file, const std::string& build_directory) {
  std::vector<fs::path> places, found;
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  if (!error) {
    places.push_back(program.parent_path() / file);
    places.push_back(program.parent_path().parent_path() / "lib" / "aluminate" / file);
  }
  places.push_back(fs::path(build_directory) / file);
  for (const fs::path& place : places)
    if (fs::exists(place, error)) found.push_back(place);
  return found;
}

}  // namespace

std::string find_module(const std::string& file, const std::string& build_directory) {
  const std::vector<fs::path> places = find_places(file, build_directory);
  return places.empty() ? std::string() : places.front().string();
}

void* open_module(const std::string& file, const std::string& build_directory, const std::string& symbol, const std::string& purpose) {
  std::string reasons;
  for (const fs::path& place : find_places(file, build_directory)) {
    void* library = ::dlopen(place.c_str(), RTLD_NOW | RTLD_LOCAL);
    void* address = library != nullptr ? ::dlsym(library, symbol.c_str()) : nullptr;
    if (address != nullptr) return address;
    reasons += fmt::format("{}{}", reasons.empty() ? ": " : "; ", ::dlerror());
  }
  throw UserError(fmt::format("cannot open {}, which {}{}", file, purpose, reasons),
                  "it belongs beside the program; building the project puts it there");
}

}  // namespace aluminate::host

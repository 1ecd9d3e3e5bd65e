// Compiled programs kept on disk (platform/host/cache_folder): compiling the same source again reads a file.
//   in   what compile() takes
//   out  what compile() gives back, or its error
// The key names everything the program depends on: this build, the options, the source and every text its
// #includes could reach. A file that is not exactly what was written for its key is as good as none.
#pragma once

#include "platform/host/hash.hpp"
#include "shading/compiler/compile.hpp"

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace aluminate::compiler {

/// Beyond this the oldest programs are dropped from the disk.
inline constexpr std::size_t kProgramDiskBudget = std::size_t{32} << 20;

/// Nothing when the program cannot be known by its texts: an #include named by a macro, no build id, no
/// source.
std::optional<host::Hash128> program_key(const Options& options);

/// The file's content, and what such a file gives back.
std::vector<std::uint8_t> pack_kept(const host::Hash128& key, const vm::Program& program);
std::optional<vm::Program> unpack_kept(const host::Hash128& key, std::span<const std::uint8_t> file);
/// Name of the disk file of a key.
std::string kept_file_name(const host::Hash128& key);

/// compile(), unless this build has compiled the same before.
vm::Program compile_kept(const Options& options);

}  // namespace aluminate::compiler

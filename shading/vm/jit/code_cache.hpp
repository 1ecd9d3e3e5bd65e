// Compiled code that is kept: in memory for this process, on disk for the next ones.
//   in   a decoded program and what was assumed of its inputs
//   out  code whose key, size and checksum all match, or nothing
// The key names everything the code depends on: the program and what is proven of its ranges, the processor, the compiler
// module and LLVM behind it.
#pragma once

#include <memory>

#include "platform/host/hash.hpp"
#include "shading/vm/jit/compiler.hpp"

namespace aluminate::vm::jit {

/// Beyond this, the longest unused code is dropped: from memory, and from the disk.
inline constexpr std::size_t kMemoryBudget = std::size_t{64} << 20, kDiskBudget = std::size_t{64} << 20;

host::Hash128 code_key(const Decoded& decoded, const CompileOptions& options);

/// The file's content, and what such a file gives back: nothing unless every byte is as it was written for this key.
std::vector<std::uint8_t> pack_code(const host::Hash128& key, const Compiled& compiled);
std::shared_ptr<const Native> unpack_code(const host::Hash128& key, std::span<const std::uint8_t> file);

std::shared_ptr<const Native> find_code(const host::Hash128& key) noexcept;
std::shared_ptr<const Native> keep_code(const host::Hash128& key, const Compiled& compiled) noexcept;

/// Name of the disk file of a key.
std::string code_file_name(const host::Hash128& key);

/// For tests: what this process remembers is forgotten.
void forget_code_in_memory();

}  // namespace aluminate::vm::jit

// Object file -> one block of position-independent code whose first byte is the entry.
//   in   a relocatable ELF object of this machine that defines kFunctionName and needs nothing from outside
//   out  the bytes, or why it cannot be flat: an outside symbol, a relocation that would need its address
#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include <llvm/ADT/StringRef.h>

namespace aluminate::vm::jit {

/// Code, or a sentence that says what is in the way.
using FlatCode = std::variant<std::vector<std::uint8_t>, std::string>;
FlatCode flatten(llvm::StringRef object);

}  // namespace aluminate::vm::jit

// What a shader may ask for. Far beyond what the consoles held (512 to 4096 instructions), and small enough that the
// worst text within them compiles in seconds and in memory that does not matter. Each limit ends in a UserError that
// names it; docs/limits.md lists them for users.
#pragma once

#include <cstddef>
#include <cstdint>

namespace aluminate::compiler {

/// Largest source file, and largest total with includes, in bytes.
inline constexpr std::size_t kMaxSourceBytes = 512 * 1024;
inline constexpr std::size_t kMaxTotalBytes = 4 * 1024 * 1024;
/// Deepest nesting of brackets, and longest run of prefix operators or else-if branches: the parsers recurse.
inline constexpr int kMaxBracketDepth = 200;

/// Tokens of a source with its macros expanded.
inline constexpr std::uint64_t kMaxExpandedTokens = 65536;
/// Statements inside statements: the validator's time grows with the third power.
inline constexpr int kMaxStatementDepth = 130;

/// Largest SPIR-V module, as it comes from outside or from the front end: bytes, the header's bound of ids, parts of one
/// type; with calls inlined: instructions of the entry point, and ifs, switches and loops.
inline constexpr std::size_t kMaxModuleBytes = 4 * 1024 * 1024;
inline constexpr std::size_t kMaxModuleIds = 500000;
inline constexpr std::uint64_t kMaxTypeParts = 16384;
inline constexpr std::uint64_t kMaxModuleInstructions = 32768;
inline constexpr std::uint64_t kMaxModuleBranches = 400;

/// Nodes of one program before dead code goes: unrolling past it ends.
inline constexpr std::size_t kMaxNodes = 32768;
/// Blocks inside blocks while lowering; what remains of them must fit kMaxNesting.
inline constexpr int kMaxBlockNesting = 120;
/// Ifs and loops one inside the other in the finished program: vm::validate() allows no more.
inline constexpr int kMaxNesting = 63;
/// Instructions one lane may run as far as the trip counts of counted loops say: a picture has a million lanes.
inline constexpr std::uint64_t kMaxCountedInstructions = std::uint64_t{1} << 24;
/// Work of lowering: one step is a look at a block or at a trip of a counted loop, an instruction is several.
inline constexpr std::size_t kMaxLoweringSteps = std::size_t{1} << 25;
inline constexpr std::size_t kStepsPerInstruction = 16;
/// Numbers in all values of a program together: values of arrays are held number by number.
inline constexpr std::size_t kMaxHeldScalars = std::size_t{1} << 23;
/// Iterations of a loop that is counted at compile time; vm::kLoopLimit for the others.
inline constexpr int kMaxTrips = 65535;

/// Numbers one local variable may hold; more would not fit any register file either.
inline constexpr std::uint32_t kMaxLocalScalars = 4096;
/// Elements an indexed local array may have when it is not constant: each costs an instruction per access.
inline constexpr std::uint32_t kMaxIndexedElements = 64;
/// Numbers of one input or output variable: 64 registers.
inline constexpr std::uint32_t kMaxInterfaceScalars = 256;
/// Longest uniform file a shader may name; the consoles have 256 pixel and 512 vertex constants.
inline constexpr int kMaxUniformRegisters = 16384;

}  // namespace aluminate::compiler

// SPIR-V in, SPIR-V out: validation, specialisation constants, the optimizer.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace aluminate::compiler {

/// Loop control bit that stands for "the source asked for [unroll]" behind the optimizer. Unrolling is the
/// lowering's business, so the optimizer must not see the request; this bit (DependencyInfinite) it carries
/// along untouched.
inline constexpr std::uint32_t kUnrollRequested = 0x4;

/// Throws UserError{file} with the validator's message.
void validate_spirv(const std::vector<std::uint32_t>& words, const std::string& file);

/// Sets specialisation constants by constant_id ("3") or name, freezes all of them. UserError names an
/// unknown one and lists what exists.
std::vector<std::uint32_t> specialise(const std::vector<std::uint32_t>& words,
                                      const std::map<std::string, double>& values, const std::string& file);

/// Inlines, promotes to SSA, folds; with `full` the optimizer's performance passes. Never moves code out of
/// loops and never unrolls.
std::vector<std::uint32_t> optimise_spirv(std::vector<std::uint32_t> words, bool full,
                                          const std::string& file);

}  // namespace aluminate::compiler

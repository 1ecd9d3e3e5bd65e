// How large a SPIR-V module is before anyone looks at it closely: the validator and the optimizer take time that grows
// faster than their input, inlining multiplies code, and types multiply too. One pass over the words, linear in them.
// In: words as they come, not validated. Out: nothing, or a UserError that names the limit.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace aluminate::compiler {

/// Limits: kMaxModuleBytes, kMaxModuleIds, kMaxTypeParts, and for the entry points with all calls inlined
/// kMaxModuleInstructions and kMaxModuleBranches. A module that is not well-formed passes: the validator says what it is.
void check_module_size(const std::vector<std::uint32_t>& words, const std::string& file);

}  // namespace aluminate::compiler

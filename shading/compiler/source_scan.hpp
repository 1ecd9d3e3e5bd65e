// Looks over shader text before a parser does: sizes and nesting that would exhaust the parser's stack,
// effect-framework syntax no parser here knows, and registers named explicitly.
#pragma once

#include <set>
#include <string>

namespace aluminate::compiler {

/// UserError when the text is too large or nested too deeply to be handed to a recursive parser.
void scan_source(const std::string& text, const std::string& file);

/// UserError for technique, pass, sampler_state, texture declarations and asm blocks, with what to write
/// instead.
void refuse_effect_syntax(const std::string& text, const std::string& file);

/// Adds the names declared with ": register(cN)".
void find_explicit_registers(const std::string& text, std::set<std::string>& names);

}  // namespace aluminate::compiler

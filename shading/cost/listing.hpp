// StaticCost to text: the tables people read, the JSON and TSV scripts read, and the period compiler's
// comment shape. Pure formatting: no number is computed here. Text fits 100 columns and prints the convention
// beside the figures.
#pragma once

#include "shading/cost/static_cost.hpp"

#include <span>
#include <string>
#include <vector>

namespace aluminate::cost {

enum class Format { Text, Json, Tsv, Markdown, Fxc360 };

/// "text", "json", "tsv", "markdown", "fxc360"; UserError with the nearest name otherwise.
Format parse_format(const std::string& word);

/// One row (text, tsv, markdown), object (json: only the "programs" array's document, see below) or comment
/// block (fxc360) for each cost, in order. Json: {"programs": [...]} with the keys of the documented cost
/// schema; the caller adds schema, tool, command and inputs.
std::string format_cost(const std::vector<StaticCost>& costs, Format format);

/// Instruction by instruction: word, pipe, instruction, source line, slots; clause boundaries marked.
std::string format_listing(const StaticCost& cost, Format format = Format::Text);

/// The schedule one issue a line without numbers or places, so that a changed instruction changes one line: "V mad ...",
/// "+ S rsq ..." for the other half of a word, "T tex ...", "block 1" where a block begins.
std::vector<std::string> listing_lines(const StaticCost& cost);

}  // namespace aluminate::cost

// docs/isa.md, written from isa.def so that the page and the machine cannot disagree.
#pragma once

#include <string>

namespace aluminate::vm {

std::string isa_markdown();

}  // namespace aluminate::vm

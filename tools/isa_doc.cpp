// Prints docs/isa.md:  isa_doc > docs/isa.md
#include <cstdio>

#include "shading/vm/isa_doc.hpp"

int main() { std::fputs(aluminate::vm::isa_markdown().c_str(), stdout); }

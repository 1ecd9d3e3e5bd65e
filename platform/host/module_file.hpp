// Modules: shared libraries of ours that are opened on first use, so that a command which does not need a large
// third-party library does not wait for it. In: a file name. Out: the address of its one exported symbol.
#pragma once

#include <string>

namespace aluminate::host {

/// Looks beside the program, then in ../lib/aluminate, then in build_directory. The module is never closed: its library
/// may have started threads and statics that cannot be unloaded. Throws UserError that says what the module is for.
void* open_module(const std::string& file, const std::string& build_directory, const std::string& symbol, const std::string& purpose);

/// The file open_module() would open first; empty when there is none.
std::string find_module(const std::string& file, const std::string& build_directory);

}  // namespace aluminate::host

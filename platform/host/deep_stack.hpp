// A call with more stack than the caller has: for parsers that recurse once per nested construct of their input. In: a
// size and a function; it runs on a thread of its own while the caller waits. Its exception is rethrown to the caller.
#pragma once

#include <cstddef>
#include <functional>

namespace aluminate::host {

/// bytes: at least 64 KiB; reserved, not touched, so a generous size costs nothing.
void run_on_deep_stack(std::size_t bytes, const std::function<void()>& work);

}  // namespace aluminate::host

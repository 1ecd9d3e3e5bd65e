// Vectors whose elements are not zeroed when they grow: of a large picture every value is written anyway, by
// many threads, and clearing it first costs a pass over memory on one.
#pragma once

#include <memory>
#include <new>
#include <utility>
#include <vector>

namespace aluminate::host {

template <class T>
struct UninitializedAllocator : std::allocator<T> {
  template <class U>
  struct rebind {
    using other = UninitializedAllocator<U>;
  };
  using std::allocator<T>::allocator;
  template <class U>
  void construct(U* at) noexcept {
    ::new (static_cast<void*>(at)) U;
  }
  template <class U, class... Arguments>
  void construct(U* at, Arguments&&... arguments) {
    ::new (static_cast<void*>(at)) U(std::forward<Arguments>(arguments)...);
  }
};

/// resize() leaves new elements indeterminate; T is a plain number.
template <class T>
using UninitializedVector = std::vector<T, UninitializedAllocator<T>>;

}  // namespace aluminate::host

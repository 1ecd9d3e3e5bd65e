#include "platform/host/deep_stack.hpp"

#include <pthread.h>

#include <cstring>
#include <exception>

#include "platform/host/error.hpp"

namespace aluminate::host {

void run_on_deep_stack(std::size_t bytes, const std::function<void()>& work) {
  struct Call {
    const std::function<void()>& work;
    std::exception_ptr error;
  } call{work, nullptr};
  const auto start = [](void* argument) -> void* {
    Call& mine = *static_cast<Call*>(argument);
    try {
      mine.work();
    } catch (...) {
      mine.error = std::current_exception();
    }
    return nullptr;
  };
  pthread_attr_t attributes;
  ALU_CHECK(pthread_attr_init(&attributes) == 0, "thread attributes");
  const int refused = pthread_attr_setstacksize(&attributes, bytes);
  pthread_t thread{};
  const int failed = refused != 0 ? refused : pthread_create(&thread, &attributes, start, &call);
  pthread_attr_destroy(&attributes);
  ALU_CHECK(failed == 0, "no thread with a stack of {} bytes: {}", bytes, std::strerror(failed));
  pthread_join(thread, nullptr);
  if (call.error) std::rethrow_exception(call.error);
}

}  // namespace aluminate::host

#include "shading/vm/jit/tier.hpp"

#include <fmt/format.h>

#include <condition_variable>
#include <deque>
#include <map>
#include <thread>

#include "platform/host/log.hpp"
#include "shading/vm/jit/code_cache.hpp"
#include "shading/vm/jit/slot.hpp"

namespace aluminate::vm::jit {
namespace {

void compile_now(const Executable& executable, Assume assume) {
  CompileOptions options;
  options.assume = assume;
  const host::Hash128 key = code_key(executable.decoded(), options);
  std::shared_ptr<const Native> native = find_code(key);
  if (native == nullptr) {
    const Compiled made = compile(executable.decoded(), options);
    if (made.code.empty()) {
      host::warning(fmt::format("shaders are interpreted: {}", made.problem));
      return;
    }
    native = keep_code(key, made);
  }
  executable.slot().publish(assume, native);
}

// One thread, started by the first request. Never destroyed, because the thread may outlive main().
class Background {
 public:
  void add(const Executable& executable, Assume assume) {
    const std::lock_guard lock(mutex_);
    if (!started_) std::thread([this] { work(); }).detach();
    started_ = true;
    requests_.push_back({executable, assume});
    changed_.notify_all();
  }
  void wait() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return requests_.empty() && !busy_; });
  }

 private:
  struct Request {
    Executable executable;
    Assume assume;
  };

  void work() {
    std::unique_lock lock(mutex_);
    for (;;) {
      changed_.wait(lock, [this] { return !requests_.empty(); });
      const Request request = std::move(requests_.front());
      requests_.pop_front();
      busy_ = true;
      lock.unlock();
      compile_now(request.executable, request.assume);
      lock.lock();
      busy_ = false;
      changed_.notify_all();
    }
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Request> requests_;
  bool started_ = false, busy_ = false;
};

// How much interpreting each program may still do, over all frames of this process.
Slot::Patience patience_of(const host::Hash128& key) {
  struct Known {
    std::mutex mutex;
    std::map<host::Hash128, Slot::Patience> by_key;
  };
  static Known* const known = new Known;
  const std::lock_guard lock(known->mutex);
  Slot::Patience& patience = known->by_key[key];
  if (patience == nullptr) patience = std::make_shared<std::atomic<std::int64_t>>(kPatienceBatches);
  return patience;
}

Background& background() {
  static Background* const one = new Background;
  return *one;
}

}  // namespace

void select_tier(const Executable& executable, Tier tier) {
  if (tier == Tier::Interpreter) return;
  Slot& slot = executable.slot();
  if (tier == Tier::Jit) {
    compile_now(executable, Assume::Typical);
    slot.watch(Assume::Nothing, std::make_shared<std::atomic<std::int64_t>>(0));  // as soon as it is needed
    return;
  }
  for (const Assume assume : {Assume::Typical, Assume::Nothing}) {
    CompileOptions options;
    options.assume = assume;
    const host::Hash128 key = code_key(executable.decoded(), options);
    slot.publish(assume, find_code(key));
    if (slot.find(assume) == nullptr) slot.watch(assume, patience_of(key));
  }
}

void compile_later(const Executable& executable, Assume assume) noexcept {
  try {
    background().add(executable, assume);
  } catch (const std::exception& error) {
    host::warning(fmt::format("shaders are interpreted: {}", error.what()));
  }
}

void wait_for_background() { background().wait(); }

}  // namespace aluminate::vm::jit

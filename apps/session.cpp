#include "apps/session.hpp"

#include <algorithm>

#include "platform/host/parallel.hpp"

namespace aluminate::apps {

void FrameArguments::add_to(CLI::App& command, const std::vector<std::string>& names) {
  for (const passes::OptionInfo& option : passes::option_table()) {
    const std::string name(option.name);
    if (!names.empty() && std::find(names.begin(), names.end(), name) == names.end()) continue;
    if (name == "checked") {
      command.add_flag("--checked", checked_, std::string(option.help));
      continue;
    }
    command.add_option(name.size() == 1 ? "-" + name : "--" + name, values_[name], std::string(option.help))
        ->type_name(std::string(option.values))
        ->allow_extra_args(false);
  }
  command.add_option("--threads", threads_, "threads to use; never changes a result (0: every core)")
      ->type_name("N");
}

passes::FrameOptions FrameArguments::resolve() const {
  host::set_thread_count(threads_);
  passes::FrameOptions options;
  for (const auto& [name, values] : values_)
    for (const std::string& value : values) passes::set_option(options, name, value);
  options.checked = checked_;
  return options;
}

}  // namespace aluminate::apps

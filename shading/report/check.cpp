#include "shading/report/check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <memory>

#include "platform/host/error.hpp"
#include "platform/host/hash.hpp"
#include "platform/host/image_file.hpp"
#include "platform/host/input_file.hpp"
#include "platform/host/interrupt.hpp"
#include "platform/host/output_file.hpp"
#include "platform/host/parallel.hpp"
#include "platform/host/suggest.hpp"
#include "rasterizer/vector_target.hpp"
#include "scenes/loader.hpp"
#include "shading/passes/inspect.hpp"
#include "shading/report/cost_report.hpp"
#include "shading/report/difference_page.hpp"
#include "shading/report/job.hpp"
#include "shading/report/self_test.hpp"

namespace aluminate::report {
namespace {

namespace fs = std::filesystem;

// Another number of threads, another vector unit and the plain interpreter for as long as it lives: none may
// matter.
class OtherConditions {
 public:
  OtherConditions() : threads_(host::thread_count()) {
    host::set_thread_count(threads_ < host::kMaxThreads - 2 ? threads_ + 2 : 1);
    const std::vector<std::string> units = raster::vector_targets();
    raster::use_vector_target(units.size() > 1 ? units[1] : units[0]);
  }
  ~OtherConditions() {
    raster::use_vector_target("");
    host::set_thread_count(threads_);
  }
  OtherConditions(const OtherConditions&) = delete;
  OtherConditions& operator=(const OtherConditions&) = delete;

 private:
  int threads_;
};

// What one run of a check gives.
struct Found {
  Golden golden;
  std::vector<std::uint8_t> rgba8;  // empty without an image
  std::vector<std::uint8_t> png;    // only on request
  bool fits = true;
};

class CheckRunner {
 public:
  explicit CheckRunner(const CheckRequest& request) : request_(request), file_(request.file) {}

  CheckRun run() {
    find_extra_goldens();
    const std::vector<std::string>& names = request_.update.empty() ? request_.names : request_.update;
    refuse_unknown(names);
    if (!request_.update.empty()) {
      const SelfTest test = self_test();
      if (!test.passed)
        throw UserError("nothing can be accepted here: this machine does not give the bits it should",
                        "'aluminate doctor' says more");
    }
    CheckRun run;
    for (const CheckSpec& spec : file_.checks)
      if (names.empty() || std::find(names.begin(), names.end(), spec.name) != names.end())
        run.results.push_back(guarded(spec));
    for (const std::string& extra : extra_) {
      if (request_.update.empty() ? !names.empty()
                                  : std::find(names.begin(), names.end(), extra) == names.end())
        continue;
      run.results.push_back(extra_result(extra));
    }
    return run;
  }

 private:
  const CheckSpec* find_spec(const std::string& name) const {
    for (const CheckSpec& spec : file_.checks)
      if (spec.name == name) return &spec;
    return nullptr;
  }

  void find_extra_goldens() {
    if (!fs::is_directory(file_.goldens)) return;
    for (const auto& entry : fs::recursive_directory_iterator(file_.goldens)) {
      if (!entry.is_regular_file() || entry.path().extension() != ".toml") continue;
      std::string name = fs::relative(entry.path(), file_.goldens).replace_extension().generic_string();
      if (find_spec(name) == nullptr) extra_.push_back(std::move(name));
    }
    std::sort(extra_.begin(), extra_.end());
  }

  void refuse_unknown(const std::vector<std::string>& names) const {
    for (const std::string& name : names) {
      if (find_spec(name) != nullptr ||
          (!request_.update.empty() && std::find(extra_.begin(), extra_.end(), name) != extra_.end()))
        continue;
      std::vector<std::string> known;
      for (const CheckSpec& spec : file_.checks) known.push_back(spec.name);
      throw UserError(fmt::format("{} has no check '{}'", file_.path, name), host::did_you_mean(name, known));
    }
  }

  CheckResult guarded(const CheckSpec& spec) {
    const auto started = std::chrono::steady_clock::now();
    CheckResult result;
    try {
      result = request_.update.empty() ? compare(spec) : accept(spec);
    } catch (const UserError& error) {
      result.outcome = Outcome::Error;
      result.message = error.what();
      if (!error.hint().empty()) result.message += "\n" + error.hint();
      if (error.place().file.empty()) result.message = spec.place.text() + ": " + result.message;
    }
    result.name = spec.name;
    result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count();
    return result;
  }

  // Scenes are kept from one check to the next: neighbours in the file often share one.
  const scenes::Scene& scene(const std::string& path) {
    if (scene_ == nullptr || scene_path_ != path) {
      scene_ = std::make_unique<scenes::Scene>(scenes::load_scene(path));
      scene_path_ = path;
    }
    return *scene_;
  }

  Found find(const CheckSpec& spec, bool keep_png) {
    Found found;
    if (spec.scene.empty()) {
      const CostRequest request{{spec.subject},     spec.options, spec.stage, spec.entry, {},
                                cost::Format::Text, false};
      found.golden = golden_of(spec.name, cost_command(request), price_subjects(request));
      return found;
    }
    Billed billed = bill(scene(spec.scene), spec.options, spec.budget_ms);
    found.golden = golden_of(spec.name, billed, spec.image, spec.cost);
    found.fits = billed.budget.fits;
    result_ms_ = billed.budget.derated_ms;
    if (!spec.image) return found;
    if (keep_png) found.png = encode_picture("golden.png", billed);
    found.rgba8 = std::move(billed.frame.rgba8);
    return found;
  }

  // The same again under other conditions; empty when the two agree.
  GoldenDifference unstable(const CheckSpec& spec, const Found& first, ImageDifference& image) {
    const OtherConditions conditions;
    CheckSpec plain = spec;
    passes::set_option(plain.options, "vm", "interpreter");
    const Found second = find(plain, false);
    const GoldenDifference difference = compare_goldens(first.golden, second.golden);
    if (difference.image_differs) image = compare_images(first.golden.width, first.rgba8, second.rgba8);
    return difference;
  }

  CheckResult compare(const CheckSpec& spec) {
    CheckResult result;
    const std::string page = page_path(spec.name);
    fs::remove(page);
    Found found = find(spec, false);
    result.frame_ms = result_ms_;
    result.budget_ms = spec.budget_ms;
    if (request_.verify) {
      result.difference = unstable(spec, found, result.image);
      if (!result.difference.same()) {
        result.outcome = Outcome::Unstable;
        return result;
      }
    }
    result.found = std::move(found.golden);
    const std::string path = golden_path(file_, spec.name);
    if (!fs::exists(path)) {
      result.outcome = Outcome::Missing;
      result.renamed_from = same_contents(result.found);
      return result;
    }
    result.accepted = read_golden(spec.name);
    result.difference = compare_goldens(result.accepted, result.found);
    result.outcome = !result.difference.same()           ? Outcome::Differs
                     : !found.fits && spec.budget_ms > 0 ? Outcome::OverBudget
                                                         : Outcome::Ok;
    if (result.difference.image_differs) show_difference(spec, found.rgba8, result);
    return result;
  }

  CheckResult accept(const CheckSpec& spec) {
    CheckResult result;
    const Found found = find(spec, true);
    result.frame_ms = result_ms_;
    result.difference = unstable(spec, found, result.image);
    if (!result.difference.same()) {
      result.outcome = Outcome::Unstable;
      return result;
    }
    result.found = found.golden;
    const std::string path = golden_path(file_, spec.name), picture = golden_picture_path(file_, spec.name);
    if (fs::exists(path)) {
      try {
        result.accepted = read_golden(spec.name);
        result.difference = compare_goldens(result.accepted, result.found);
      } catch (const UserError&) {
        result.accepted = {};  // a broken golden is replaced like a missing one
      }
    }
    host::make_directories(fs::path(path).parent_path().string());
    host::OutputSet outputs;
    outputs.add(path).write(write_golden(found.golden));
    if (!found.png.empty()) outputs.add(picture).write(found.png);
    outputs.commit();
    if (found.png.empty()) fs::remove(picture);
    fs::remove(page_path(spec.name));
    result.outcome = Outcome::Accepted;
    return result;
  }

  Golden read_golden(const std::string& name) const {
    const std::string path = golden_path(file_, name);
    Golden golden = parse_golden(host::read_text(path), path);
    if (golden.check != name)
      throw UserError(SourcePlace{path}, fmt::format("is the golden of '{}'", golden.check),
                      fmt::format("accept again: aluminate check --update {}", name));
    return golden;
  }

  std::string same_contents(const Golden& found) const {
    for (const std::string& extra : extra_) {
      try {
        if (compare_goldens(read_golden(extra), found).same()) return extra;
      } catch (const UserError&) {  // reported by itself, as an extra golden
      }
    }
    return {};
  }

  // The accepted picture is read only now; its contents must be what the text beside it says.
  std::vector<std::uint8_t> accepted_picture(const CheckSpec& spec, const Golden& golden) const {
    const std::string path = golden_picture_path(file_, spec.name);
    const host::Image8 image = host::read_image_rgba8(path);
    const std::string hash = image_hash(image.width, image.height, image.texels);
    if (hash != golden.image_hash)
      throw UserError(SourcePlace{path},
                      fmt::format("is not the picture that was accepted: its hash is {}, {} says {}", hash,
                                  golden_path(file_, spec.name), golden.image_hash),
                      fmt::format("restore it, or accept again: aluminate check --update {}", spec.name));
    return image.texels;
  }

  void show_difference(const CheckSpec& spec, const std::vector<std::uint8_t>& after, CheckResult& result) {
    if (result.accepted.image_hash.empty() || result.found.image_hash.empty() ||
        result.accepted.width != result.found.width || result.accepted.height != result.found.height)
      return;  // image checks switched on or off, or another size: there are no two pixels to hold side by
               // side
    const std::vector<std::uint8_t> before = accepted_picture(spec, result.accepted);
    const int width = result.found.width;
    result.image = compare_images(width, before, after);
    PixelChange& pixel = result.pixel;
    for (std::size_t i = 0; i < after.size(); i += 4) {
      if (std::equal(&before[i], &before[i] + 4, &after[i])) continue;
      pixel.x = static_cast<int>(i / 4 % static_cast<std::size_t>(width));
      pixel.y = static_cast<int>(i / 4 / static_cast<std::size_t>(width));
      std::copy_n(&before[i], 4, pixel.before.begin());
      std::copy_n(&after[i], 4, pixel.after.begin());
      break;
    }
    const passes::PixelReport report =
        passes::inspect_pixel(scene(spec.scene), spec.options, pixel.x, pixel.y);
    for (const passes::PixelVisit& visit : report.visits)
      if (visit.outcome == "drawn" || visit.outcome == "blended")
        pixel.draw = fmt::format("draw {} '{}', {}", visit.draw, visit.mesh, visit.outcome);
    result.page = page_path(spec.name);
    host::make_directories(fs::path(result.page).parent_path().string());
    host::write_file(result.page,
                     difference_page({.title = spec.name,
                                      .name_a = "accepted",
                                      .name_b = "found",
                                      .command = result.found.command,
                                      .accept = fmt::format("aluminate check --update {}", spec.name),
                                      .width = width,
                                      .height = result.found.height,
                                      .a = before,
                                      .b = after}));
  }

  CheckResult extra_result(const std::string& name) const {
    CheckResult result;
    result.name = name;
    result.outcome = Outcome::Extra;
    if (request_.update.empty()) return result;
    fs::remove(golden_path(file_, name));
    fs::remove(golden_picture_path(file_, name));
    result.outcome = Outcome::Removed;
    return result;
  }

  std::string page_path(const std::string& name) const { return file_.output + "/" + name + ".html"; }

  const CheckRequest& request_;
  const CheckFile& file_;
  std::vector<std::string> extra_;
  std::unique_ptr<scenes::Scene> scene_;
  std::string scene_path_;
  double result_ms_ = 0;
};

}  // namespace

int CheckRun::count(Outcome outcome) const {
  return static_cast<int>(std::count_if(results.begin(), results.end(),
                                        [&](const CheckResult& r) { return r.outcome == outcome; }));
}

int CheckRun::exit_code() const {
  if (count(Outcome::Error) > 0) return 2;
  const int fine = count(Outcome::Ok) + count(Outcome::Accepted) + count(Outcome::Removed);
  return fine == static_cast<int>(results.size()) ? 0 : 1;
}

CheckRun run_checks(const CheckRequest& request) { return CheckRunner(request).run(); }

std::string golden_path(const CheckFile& file, const std::string& name) {
  return file.goldens + "/" + name + ".toml";
}
std::string golden_picture_path(const CheckFile& file, const std::string& name) {
  return file.goldens + "/" + name + ".png";
}

}  // namespace aluminate::report

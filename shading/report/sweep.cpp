#include "shading/report/sweep.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "platform/host/error.hpp"
#include "platform/host/file_lock.hpp"
#include "platform/host/hash.hpp"
#include "platform/host/input_file.hpp"
#include "platform/host/interrupt.hpp"
#include "platform/host/output_file.hpp"
#include "platform/host/text_table.hpp"
#include "scenes/loader.hpp"
#include "shading/report/job.hpp"

namespace aluminate::report {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr std::size_t kMostJobs = 1000000;

constexpr const char* kResults[] = {"image_xxh3_128", "pixels",  "helper_lanes", "alu_words",
                                    "alu_slots",      "fetches", "fetch_cyc",    "frame_ms",
                                    "peak_ms",        "bound",   "error"};

struct Job {
  std::size_t index = 0;
  std::string scene;
  std::vector<std::pair<std::string, std::string>> values;

  std::string name() const {
    std::string text = scene;
    for (const auto& [key, value] : values) text += fmt::format(" {}={}", key, value);
    return text;
  }
};

std::vector<Job> jobs_of(const SweepRequest& request) {
  std::size_t count = request.scenes.size();
  for (const auto& [key, values] : request.vary) {
    count *= values.size();
    if (count > kMostJobs)
      throw UserError(fmt::format("a sweep of more than {} jobs", kMostJobs), "vary fewer options at once");
  }
  std::vector<Job> jobs;
  for (std::size_t i = 0; i < count; ++i) {
    Job job{i, {}, {}};
    std::size_t rest = i;
    for (auto it = request.vary.rbegin(); it != request.vary.rend(); ++it) {
      job.values.emplace_back(it->first, it->second[rest % it->second.size()]);
      rest /= it->second.size();
    }
    std::reverse(job.values.begin(), job.values.end());
    job.scene = request.scenes[rest];
    jobs.push_back(std::move(job));
  }
  return jobs;
}

class Sweep {
 public:
  explicit Sweep(const SweepRequest& request) : request_(request), jobs_(jobs_of(request)) {}

  SweepDone run() {
    claim_folder();
    SweepDone done;
    done.jobs = jobs_.size();
    host::LockFile locks(request_.folder + "/jobs.lock");
    std::vector<const Job*> busy;
    for (const Job& job : jobs_) {
      if (job.index % static_cast<std::size_t>(request_.shards) !=
          static_cast<std::size_t>(request_.shard - 1))
        continue;
      if (result_of(job)) {
        ++done.kept;
      } else if (locks.try_lock(job.index)) {
        finish(job, locks, done);
      } else {
        busy.push_back(&job);
      }
    }
    for (const Job* job : busy) {
      locks.lock(job->index);
      finish(*job, locks, done);
    }
    std::vector<ordered_json> results;
    for (const Job& job : jobs_) {
      const std::optional<ordered_json> result = result_of(job);
      if (!result) {
        ++done.missing;
        continue;
      }
      if (!result->at("error").get<std::string>().empty()) done.failed.push_back(job.name());
      results.push_back(*result);
    }
    if (done.missing == 0) {
      locks.lock(jobs_.size());  // one writer at a time; all write the same
      write_tables(results);
      done.table_written = true;
    }
    return done;
  }

 private:
  // Runs a job whose lock is held, unless somebody has just finished it, and lets go of it.
  void finish(const Job& job, host::LockFile& locks, SweepDone& done) {
    if (result_of(job)) {
      ++done.kept;
    } else {
      host::throw_if_interrupted();
      host::write_file(path_of(job),
                       ordered_json({{"job", job.name()}, {"result", execute(job)}}).dump(1) + "\n");
      ++done.ran;
    }
    locks.unlock(job.index);
  }

  // The first process writes down what the sweep is; the others must agree.
  void claim_folder() const {
    host::make_directories(request_.folder + "/jobs");
    std::string text;
    for (const Job& job : jobs_) text += job.name() + "\n";
    const passes::FrameOptions& o = request_.options;
    const std::string what =
        fmt::format("{} jobs {} {}\n", jobs_.size(),
                    host::hash_text(text + canonical_command("sweep", {.scene_file = "", .scene_hash = "", .file_hashes = {}, .options = o})).hex(), ALUMINATE_VERSION);
    const std::string path = request_.folder + "/sweep.txt";
    if (!fs::exists(path)) host::write_file(path, what);
    if (host::read_text(path) != what)
      throw UserError(SourcePlace{path}, "this folder holds another sweep",
                      "give a new folder with -o, or repeat the scenes and options of the first run");
  }

  std::string path_of(const Job& job) const {
    return fmt::format("{}/jobs/{:06}.json", request_.folder, job.index);
  }

  // A result that another process wrote, or nothing: an unreadable file counts as nothing and is written
  // again.
  std::optional<ordered_json> result_of(const Job& job) const {
    if (!fs::exists(path_of(job))) return std::nullopt;
    const ordered_json document = ordered_json::parse(host::read_text(path_of(job)), nullptr, false);
    if (!document.is_object() || document.value("job", "") != job.name() || !document.contains("result"))
      return std::nullopt;
    for (const char* key : kResults)
      if (!document["result"].contains(key)) return std::nullopt;
    return document["result"];
  }

  ordered_json execute(const Job& job) {
    ordered_json result = ordered_json::object();
    for (const char* key : kResults) result[key] = "";
    try {
      passes::FrameOptions options = request_.options;
      for (const auto& [key, value] : job.values) passes::set_option(options, key, value);
      if (scene_ == nullptr || scene_path_ != job.scene) {
        scene_ = nullptr;
        scene_ = std::make_unique<scenes::Scene>(scenes::load_scene(job.scene));
        scene_path_ = job.scene;
      }
      const Billed billed = bill(*scene_, options, 0);
      passes::PassTotals sum;
      for (const passes::PassTotals& pass : billed.frame.passes) {
        sum.pixels += pass.pixels;
        sum.helper_lanes += pass.helper_lanes;
        sum.alu_words += pass.alu_words;
        sum.alu_slots += pass.alu_slots;
        sum.fetches += pass.fetches;
        sum.fetch_cyc += pass.fetch_cyc;
      }
      result["image_xxh3_128"] = image_hash(billed.frame);
      result["pixels"] = sum.pixels;
      result["helper_lanes"] = sum.helper_lanes;
      result["alu_words"] = sum.alu_words;
      result["alu_slots"] = sum.alu_slots;
      result["fetches"] = sum.fetches;
      result["fetch_cyc"] = sum.fetch_cyc;
      result["frame_ms"] = billed.budget.derated_ms;
      result["peak_ms"] = billed.budget.peak_ms;
      result["bound"] = console::unit_name(billed.budget.bound);
    } catch (const UserError& error) {
      result["error"] = error.what();
    }
    return result;
  }

  static std::string cell(const ordered_json& value) {
    return value.is_string() ? value.get<std::string>() : value.dump();
  }

  // RFC 4180: a cell with a comma, a quote or a line break stands in quotes.
  static std::string csv(const std::string& text) {
    if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
    std::string out = "\"";
    for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
    return out + "\"";
  }

  void write_tables(const std::vector<ordered_json>& results) const {
    std::vector<std::string> names = {"scene"};
    for (const auto& [key, values] : request_.vary) names.push_back(key);
    names.insert(names.end(), std::begin(kResults), std::end(kResults));
    std::vector<host::TableColumn> columns;
    for (const std::string& name : names) columns.push_back({name});
    host::TextTable markdown(columns);
    std::string text = fmt::format("{}\n", fmt::join(names, ","));
    ordered_json rows = ordered_json::array();
    for (std::size_t i = 0; i < jobs_.size(); ++i) {
      std::vector<std::string> cells = {jobs_[i].scene};
      ordered_json row = {{"scene", jobs_[i].scene}};
      for (const auto& [key, value] : jobs_[i].values) {
        cells.push_back(value);
        row[key] = value;
      }
      for (const char* key : kResults) {
        cells.push_back(cell(results[i][key]));
        row[key] = results[i][key];
      }
      for (std::size_t c = 0; c < cells.size(); ++c) text += (c ? "," : "") + csv(cells[c]);
      text += "\n";
      markdown.add_row(cells);
      rows.push_back(std::move(row));
    }
    host::OutputSet outputs;
    outputs.add(request_.folder + "/table.csv").write(text);
    outputs.add(request_.folder + "/table.md").write(markdown.markdown());
    outputs.add(request_.folder + "/table.json")
        .write(ordered_json({{"schema", 1},
                             {"tool", {{"name", "aluminate"}, {"version", ALUMINATE_VERSION}}},
                             {"command", "sweep"},
                             {"inputs", {{"scenes", request_.scenes}}},
                             {"rows", rows}})
                   .dump(1) +
               "\n");
    outputs.commit();
  }

  const SweepRequest& request_;
  std::vector<Job> jobs_;
  std::unique_ptr<scenes::Scene> scene_;
  std::string scene_path_;
};

}  // namespace

void add_variation(SweepRequest& request, const std::string& text) {
  const auto equals = text.find('=');
  const std::string key = text.substr(0, equals);
  if (equals == std::string::npos || equals + 1 == text.size())
    throw UserError(fmt::format("--vary takes KEY=VALUE|VALUE.., got '{}'", text),
                    "for example visibility=cheap|schlick-smith");
  for (const auto& [name, values] : request.vary)
    if (name == key)
      throw UserError(fmt::format("--vary {} is given twice", key),
                      "list all its values at once, with '|' between them");
  std::vector<std::string> values;
  for (std::size_t begin = equals + 1; begin <= text.size();) {
    const std::size_t end = std::min(text.find('|', begin), text.size());
    values.push_back(text.substr(begin, end - begin));
    passes::FrameOptions trial;
    passes::set_option(trial, key, values.back());
    begin = end + 1;
  }
  request.vary.emplace_back(key, std::move(values));
}

void parse_shard(SweepRequest& request, const std::string& text) {
  const char* end = text.data() + text.size();
  const auto first = std::from_chars(text.data(), end, request.shard);
  const bool slash = first.ec == std::errc() && first.ptr != end && *first.ptr == '/';
  const auto second = slash ? std::from_chars(first.ptr + 1, end, request.shards) : first;
  if (!slash || second.ec != std::errc() || second.ptr != end || request.shard < 1 ||
      request.shard > request.shards)
    throw UserError(fmt::format("--shard takes I/N with I from 1 to N, got '{}'", text), "for example 2/8");
}

SweepDone run_sweep(const SweepRequest& request) { return Sweep(request).run(); }

std::string sweep_text(const SweepDone& done, const std::string& folder) {
  std::string text = fmt::format(
      "{} jobs: {} run here, {} already had a result or got it from another process, {} missing, {} failed\n",
      done.jobs, done.ran, done.kept, done.missing, done.failed.size());
  for (const std::string& name : done.failed) text += fmt::format("failed: {}\n", name);
  return text + (done.table_written
                     ? fmt::format("{0}/table.csv\n{0}/table.json\n{0}/table.md\n", folder)
                     : "no table yet: run the other shards, or this command without --shard\n");
}

}  // namespace aluminate::report

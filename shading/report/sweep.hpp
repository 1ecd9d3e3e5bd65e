// A matrix of scenes and options as independent jobs, each with a small result file, and the table of them
// all. In: scenes and lists of values. Out: a folder. The table is the same bytes whoever ran which job, in
// any order, on any number of machines; a job that failed is a named row. A killed process leaves whole
// result files only, which the next one keeps.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "shading/passes/options.hpp"

namespace aluminate::report {

struct SweepRequest {
  std::vector<std::string> scenes;
  passes::FrameOptions options;  // what is not varied
  std::vector<std::pair<std::string, std::vector<std::string>>>
      vary;  // option name, its values; the last varies fastest
  std::string folder;
  int shard = 1, shards = 1;  // this process runs job i when i % shards == shard - 1, i from 0
};

/// "visibility=cheap|none" into `vary`. UserError for unknown options and values, names given twice, empty
/// lists.
void add_variation(SweepRequest& request, const std::string& text);
/// "2/8". UserError unless 1 <= i <= n.
void parse_shard(SweepRequest& request, const std::string& text);

struct SweepDone {
  std::size_t jobs = 0, ran = 0, kept = 0, missing = 0;  // missing: other shards' jobs without a result yet
  std::vector<std::string> failed;  // names of jobs whose result is an error, this shard's or not
  bool table_written = false;
};

/// Runs this shard's jobs that have no result yet. When every job has one, writes table.csv, table.json and
/// table.md. At most 1000000 jobs. Throws UserError for a folder that holds the results of another sweep.
SweepDone run_sweep(const SweepRequest& request);

std::string sweep_text(const SweepDone& done, const std::string& folder);

}  // namespace aluminate::report

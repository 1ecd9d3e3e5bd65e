// A matrix of scenes and options as independent jobs, each with a small result file, and the table of them
// all. In: scenes and lists of values. Out: a folder. Any number of processes, on any machines that share the
// folder, may run the same sweep: each takes the next job that has no result and that nobody holds (a lock of
// the file jobs.lock), so mpirun, srun or a shell loop are launchers enough. The table is the same bytes
// whoever ran which job; a job that failed is a named row. A killed process leaves whole result files only,
// and its lock goes with it: others take its job over, or a later run does.
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
  // A process that cannot see the others' folder: only job i with i % shards == shard - 1, i from 0.
  int shard = 1, shards = 1;
};

/// "visibility=cheap|none" into `vary`. UserError for unknown options and values, names given twice, empty
/// lists.
void add_variation(SweepRequest& request, const std::string& text);
/// "2/8". UserError unless 1 <= i <= n.
void parse_shard(SweepRequest& request, const std::string& text);

struct SweepDone {
  std::size_t jobs = 0, ran = 0,
              kept = 0;             // ran by this process; kept: of its shard, by an earlier or another one
  std::size_t missing = 0;          // other shards' jobs without a result yet
  std::vector<std::string> failed;  // names of jobs whose result is an error, this shard's or not
  bool table_written = false;
};

/// Runs the shard's jobs that have no result yet and that no other process is running, then waits for those
/// and runs what their holders left. When every job has a result, writes table.csv, table.json and table.md.
/// At most 1000000 jobs. Throws UserError for a folder that holds the results of another sweep.
SweepDone run_sweep(const SweepRequest& request);

std::string sweep_text(const SweepDone& done, const std::string& folder);

}  // namespace aluminate::report
